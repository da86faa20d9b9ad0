# SPDX-License-Identifier: BSD-3-Clause
"""Figures 3, 4, 5: rigid feet walk, the feet's rubber is found from a swing, soft feet fall."""
import math
import re

from experiment import Experiment, tell_logs, tell_run, tell_varied, upright
from measure import least_squares
from walk_views import RATE, add_foot_force, add_pictures


def fig3(run, out):
    text = run.text('fig3')
    s, c = run.both('fig3', text)
    tell_run(out, s)
    steps = sum(s['landings'])
    out.see('%d landings' % steps)
    out.claim('upright to the end', upright(s))
    out.claim('at least eight steps (%d)' % steps, steps >= 8)
    tell_varied(run, out, 'fig3', text, lambda r: upright(r) and sum(r['landings']) >= 8, 'walks eight steps')
    add_pictures(run, out, 'fig3', s, c)
    add_foot_force(run, out, 'fig3', s, c)


SPAN = 20  # [steps] of the differences that give rates: long enough that the six digits of the table do not matter


def sample_swing(c, imu, begin, end):
    """(indices at which sensors are read, angle, rate, acceleration) of both feet's bushes together: joints are locked, so
    they are the body's pitch, which the IMU tells."""
    t, pitch, h = c['time'], c[imu + '/pitch'], SPAN / RATE
    chosen = [i for i in range(SPAN, len(t) - SPAN) if begin < t[i] < end and i % 5 == 4]
    rate = [(pitch[i + SPAN] - pitch[i - SPAN]) / (2.0 * h) for i in chosen]
    acceleration = [(pitch[i + SPAN] - 2.0 * pitch[i] + pitch[i - SPAN]) / (h * h) for i in chosen]
    return chosen, [pitch[i] for i in chosen], rate, acceleration


def identify(moment, angle, rate):
    """K, C of moment = -K angle - C rate - O, by least squares: the wrench is the foot's on the leg, it rights the body."""
    k, c, _ = least_squares([angle, rate, [1.0] * len(angle)], [-m for m in moment])
    return k, c


def calc_oscillation(angle, rate, acceleration):
    """Undamped frequency [Hz] and damping ratio of acceleration = -w^2 angle - 2 z w rate + constant."""
    w2, d, _ = least_squares([angle, rate, [1.0] * len(angle)], [-a for a in acceleration])
    return math.sqrt(w2) / (2.0 * math.pi), d / (2.0 * math.sqrt(w2))


class Swing:
    """What is known of a robot on its feet: its IMU, height and forward place of the sensor over the sole's middle [m],
    stiffness [N m/rad] and damping [N m s/rad] of both feet, m g h [N m/rad], inertia about the sole [kg m^2]."""

    def __init__(self, imu, height, forward, stiffness, damping, weight_moment, inertia):
        self.imu, self.height, self.forward = imu, height, forward
        self.stiffness, self.damping = stiffness, damping
        self.weight_moment, self.inertia = weight_moment, inertia


def measure_swing(c, swing):
    """({foot: (K, C)}, undamped frequency, damping ratio)."""
    chosen, angle, rate, acceleration = sample_swing(c, swing.imu, 2.7, 11.5)
    feet = {}
    for side in ('left', 'right'):
        # About the middle of the sole, `height` below and `forward` of the sensor: M_S = M - p x f.
        ty, fx, fz = (c['%s_foot/%s' % (side, part)] for part in ('ty', 'fx', 'fz'))
        moment = [ty[i] + swing.height * fx[i] + swing.forward * fz[i] for i in chosen]
        feet[side] = identify(moment, angle, rate)
    return (feet,) + calc_oscillation(angle, rate, acceleration)


def calc_errors(feet, swing):
    """Of K and C of both feet together."""
    return [sum(values) / true - 1.0 for values, true in zip(zip(*feet.values()), (swing.stiffness, swing.damping))]


def tilt(name, swing):
    def measure(run, out):
        text = run.text(name)
        s, c = run.both(name, text)
        tell_logs(out, s)
        feet, frequency, ratio = measure_swing(c, swing)
        for side, (k, d) in feet.items():
            out.number('%s foot' % side, 'K %.1f N m/rad, C %.2f N m s/rad' % (k, d))
        off_k, off_c = calc_errors(feet, swing)
        by_hand = math.sqrt((swing.stiffness - swing.weight_moment) / swing.inertia) / (2.0 * math.pi)
        out.see('K %.1f of %g N m/rad (%+.1f %%), C %.2f of %g N m s/rad (%+.1f %%), both feet'
                % ((1 + off_k) * swing.stiffness, swing.stiffness, 100 * off_k,
                   (1 + off_c) * swing.damping, swing.damping, 100 * off_c))
        out.see('%.3f Hz (by hand %.3f Hz), damping ratio %.3f' % (frequency, by_hand, ratio))
        out.claim('K comes back within 5 %% (%+.2f %%)' % (100 * off_k), abs(off_k) < 0.05)
        out.claim('C comes back within 5 %% (%+.2f %%)' % (100 * off_c), abs(off_c) < 0.05)
        # One rigid body; its moments are known to three digits, and floor and vertical rubber give a little, too.
        out.claim('undamped frequency within 2 %% of the hand calculation sqrt((K - m g h) / I) / 2 pi (%.4f, %.4f Hz)'
                  % (frequency, by_hand), abs(frequency / by_hand - 1.0) < 0.02)
        tell_varied(run, out, name, text, lambda r, c: max(map(abs, calc_errors(measure_swing(c, swing)[0], swing))) < 0.05,
                    'K and C come back within 5 %', table=True)
        add_pictures(run, out, name, s, c, (2.0, 4.4), words='the swing')
        out.figure('Torque about the pitch axis at the force sensors, the curve of the paper\'s figure.',
                   run.plot(name, 'Ankle pitch torque', 'time [s]', 'torque [N m]', c['time'],
                            {'left': c['left_foot/ty'], 'right': c['right_foot/ty']}))
    return measure


# m g h of one HRP-1S-like robot on its feet, robots-and-algorithms facts: 120 kg x 9.81 m/s^2 x 0.863 m.
HRP1S_WEIGHT_MOMENT = 1015.0
HRP1S_SWING = Swing('trunk', 0.11, 0.035, 2000.0, 50.0, HRP1S_WEIGHT_MOMENT, 107.0)
HRP2P_SWING = Swing('chest', 0.105, 0.015, 914.0, 22.0, 462.0, 45.5)


def set_bush(text, k, c):
    """Roll and pitch alike: k [N m/rad], c [N m s/rad] of a foot."""
    return re.sub(r'k_roll: 1000, k_pitch: 1000, c_roll: 25, c_pitch: 25',
                  'k_roll: %g, k_pitch: %g, c_roll: %g, c_pitch: %g' % (k, k, c, c), text)


def stands(run, k):
    """HRP-1S with locked joints, the rubber right under the centre of mass: nothing but the stiffness decides."""
    text = re.sub(r'pushes:\n.*\n', '', run.text('fig4')).replace('{kz:', '{center: [-0.004, 0, -0.11], kz:')
    return upright(run.trial('fig5_stands', set_bush(text.replace('duration: 12}', 'duration: 30}'), k, 25.0))[0])


def walks(run, k):
    """The gentle open-loop walk, with damping in proportion."""
    return upright(run.trial('fig5_walk', set_bush(run.text('fig5_walk'), k, 0.025 * k))[0])


def find_threshold(survives, low, high, precision):
    """Stiffness of one foot [N m/rad] below which the robot falls, by bisection; None when it is not in between."""
    if survives(low) or not survives(high):
        return None
    while high / low > 1.0 + precision:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if survives(middle) else (middle, high)
    return math.sqrt(low * high)


def fig5(run, out):
    text = run.text('fig5')
    s, c = run.both('fig5', text)
    tell_run(out, s)
    out.claim('falls', s['fallen'])
    standing = find_threshold(lambda k: stands(run, k), 200.0, 1000.0, 0.005)
    walking = find_threshold(lambda k: walks(run, k), 1000.0, 16000.0, 0.05)
    out.claim('thresholds between 200 and 1000 (standing), 1000 and 16000 N m/rad a foot (walking)', standing and walking)
    if standing:
        ratio = 2.0 * standing / HRP1S_WEIGHT_MOMENT
        out.see('standing on both feet it begins to fall below %.0f N m/rad, %.2f m g h' % (2.0 * standing, ratio))
        out.claim('a standing robot begins to fall at m g h = 1015 N m/rad of both feet, within 5 %% (%.3f m g h)' % ratio,
                  abs(ratio - 1.0) < 0.05)
    if walking:
        out.see('in a gentle walk, below %.0f N m/rad of the one that carries, %.1f m g h'
                % (walking, walking / HRP1S_WEIGHT_MOMENT))
    tell_varied(run, out, 'fig5', text, lambda r: r['fallen'], 'falls')
    add_pictures(run, out, 'fig5', s, c)
    add_foot_force(run, out, 'fig5', s, c)


EXPERIMENTS = [
    Experiment('fig3', 'Figure 3: HRP-1S on rigid feet',
               'HRP-1S walks on rigid feet with impulse contact, without a stabilizer.', fig3, cost=18.0),
    Experiment('fig4', 'Figure 4: HRP-1S tilted and released',
               'Tilted and released without feedback the robot swings; stiffness and damping of the feet are found from the '
               'damped oscillation.',
               tilt('fig4', HRP1S_SWING), cost=5.0),
    Experiment('fig4_hrp2p', 'Figure 4 with HRP-2P', 'The same with HRP-2P.',
               tilt('fig4_hrp2p', HRP2P_SWING), cost=4.0),
    Experiment('fig5', 'Figure 5: HRP-1S on soft feet', 'HRP-1S falls on soft feet without a stabilizer.', fig5, cost=10.0),
]
