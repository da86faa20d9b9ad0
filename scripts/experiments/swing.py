# SPDX-License-Identifier: BSD-3-Clause
"""Figure 4: a robot on soft feet is held by a hand, tilted, released, and swings about both axes. The rubber is found as the paper
does: a first estimate from frequency and decrement, then the simulation is adjusted until it swings alike."""
import math
import re

from experiment import Experiment, tell_logs, tell_varied, upright
from measure import least_squares, rms
from walk_views import RATE, add_pictures

SPAN = 20  # [steps] of the differences that give rates: long enough that the six digits of the table do not matter
RELEASE, END = 6.0, 15.9  # [s] the hand lets go; end of what is looked at
AXES = ('pitch', 'roll')


class Swing:
    """What is known of a robot on its feet: its IMU, height and forward place of the sensor over the sole's middle [m],
    m g h [N m/rad], inertia about the sole [kg m^2], vertical stiffness of the mechanism [N/m] and half the distance of the feet
    [m]. And what is to be found, of both feet: {axis: (stiffness [N m/rad], damping [N m s/rad])}."""

    def __init__(self, imu, height, forward, weight_moment, inertia, vertical, half, truth):
        self.imu, self.height, self.forward = imu, height, forward
        self.weight_moment, self.inertia, self.vertical, self.half, self.truth = weight_moment, inertia, vertical, half, truth

    def other_stiffness(self, axis):
        """Stiffness about an axis that is not that of the rubber's rotation [N m/rad]."""
        return -self.weight_moment + (2.0 * self.vertical * self.half ** 2 if axis == 'roll' else 0.0)


# m g h of one HRP-1S-like robot on its feet: 120 kg x 9.81 m/s^2 x 0.863 m.
HRP1S_WEIGHT_MOMENT = 1015.0
HRP1S_SWING = Swing('trunk', 0.11, 0.035, HRP1S_WEIGHT_MOMENT, 107.0, 5e5, 0.09, {'pitch': (2000.0, 50.0), 'roll': (2000.0, 50.0)})
HRP2P_SWING = Swing('chest', 0.105, 0.015, 462.0, 45.5, 3e5, 0.095, {'pitch': (914.0, 22.0), 'roll': (643.0, 45.0)})


def sample_swing(c, key, begin, end):
    """(indices at which sensors are read, angle, rate, acceleration) of both feet's bushes together: joints are locked, so
    they are the body's lean, which the IMU tells."""
    t, lean, h = c['time'], c[key], SPAN / RATE
    chosen = [i for i in range(SPAN, len(t) - SPAN) if begin < t[i] < end and i % 5 == 4]
    rate = [(lean[i + SPAN] - lean[i - SPAN]) / (2.0 * h) for i in chosen]
    acceleration = [(lean[i + SPAN] - 2.0 * lean[i] + lean[i - SPAN]) / (h * h) for i in chosen]
    return chosen, [lean[i] for i in chosen], rate, acceleration


def calc_moments(c, swing, side, axis):
    """About the middle of the sole, `height` below and `forward` of the sensor, at every step [N m]: M_S = M - p x f."""
    torque, across = (c['%s_foot/%s' % (side, part)] for part in (('ty', 'fx') if axis == 'pitch' else ('tx', 'fy')))
    if axis == 'roll':
        return [t - swing.height * f for t, f in zip(torque, across)]
    return [t + swing.height * f + swing.forward * fz for t, f, fz in zip(torque, across, c['%s_foot/fz' % side])]


def identify(moment, angle, rate):
    """K, C of moment = -K angle - C rate - O, by least squares: the wrench is the foot's on the leg, it rights the body."""
    k, c, _ = least_squares([angle, rate, [1.0] * len(angle)], [-m for m in moment])
    return k, c


def calc_oscillation(angle, rate, acceleration):
    """Undamped frequency [Hz] and damping ratio of acceleration = -w^2 angle - 2 z w rate + constant."""
    w2, d, _ = least_squares([angle, rate, [1.0] * len(angle)], [-a for a in acceleration])
    return math.sqrt(w2) / (2.0 * math.pi), d / (2.0 * math.sqrt(w2))


def measure_swing(c, swing, axis='pitch', begin=RELEASE + 0.1, end=END):
    """({foot: (K, C)} from the sensed moments, undamped frequency [Hz], damping ratio)."""
    chosen, angle, rate, acceleration = sample_swing(c, '%s/%s' % (swing.imu, axis), begin, end)
    feet = {}
    for side in ('left', 'right'):
        moments = calc_moments(c, swing, side, axis)
        feet[side] = identify([moments[i] for i in chosen], angle, rate)
    return (feet,) + calc_oscillation(angle, rate, acceleration)


def calc_errors(feet, swing, axis='pitch'):
    """Of K and C of both feet together."""
    return [sum(values) / true - 1.0 for values, true in zip(zip(*feet.values()), swing.truth[axis])]


def estimate(swing, axis, frequency, ratio):
    """K, C of both feet from frequency and decrement: I w^2 = K + other stiffness, 2 z w = C / I."""
    w = 2.0 * math.pi * frequency
    return swing.inertia * w * w - swing.other_stiffness(axis), 2.0 * ratio * w * swing.inertia


def set_rubber(text, found):
    """The scenario with this rubber, {axis: (K, C) of both feet}, the same in each foot."""
    for axis, values in found.items():
        for letter, value in zip('kc', values):
            text = re.sub(r'%s_%s: [0-9.e+-]+' % (letter, axis), '%s_%s: %.6g' % (letter, axis, max(0.5 * value, 1e-3)), text)
    return text


def simulate(run, name, text, swing, found):
    """({axis: (frequency, ratio)}, columns) of the model with this rubber."""
    columns = run.trial(name + '_model', set_rubber(text, found), True)[1]
    return {axis: measure_swing(columns, swing, axis)[1:] for axis in AXES}, columns


def adjust(run, name, text, swing, measured):
    """The rubber with which the simulation swings as measured, {axis: (frequency, ratio)}. Returns the first estimate, the adjusted
    one, and the columns of both."""
    first = {axis: estimate(swing, axis, *measured[axis]) for axis in AXES}
    found, before = dict(first), None
    for _ in range(4):
        seen, columns = simulate(run, name, text, swing, found)
        before = before or columns
        for axis in AXES:  # what the estimate would change for what is left
            there, here = estimate(swing, axis, *measured[axis]), estimate(swing, axis, *seen[axis])
            found[axis] = tuple(value + a - b for value, a, b in zip(found[axis], there, here))
    return first, found, before, simulate(run, name, text, swing, found)[1]


def calc_gap(model, real, key):
    """Difference of two curves over the swing of one, both rms."""
    chosen = [i for i, t in enumerate(real['time']) if RELEASE + 0.1 < t < END]
    mean = sum(real[key][i] for i in chosen) / len(chosen)
    return rms([a - b for a, b in zip(model[key], real[key])], chosen) / rms([x - mean for x in real[key]], chosen)


def calc_quiet(c, swing, axis):
    """Largest rate in the last second before the release over that after it."""
    rates = [max(map(abs, sample_swing(c, '%s/%s' % (swing.imu, axis), *span)[2])) for span in ((4.95, 5.95), (6.1, 9.0))]
    return rates[0] / rates[1]


def off(found, truth):
    return [value / true - 1.0 for value, true in zip(found, truth)]


def tell_axis(out, swing, axis, c, first, found, before, after):
    feet, frequency, ratio = measure_swing(c, swing, axis)
    out.number('%s: %.3f Hz, damping ratio %.3f' % (axis, frequency, ratio),
               'estimate %.0f, %.1f; adjusted %.0f, %.1f; least squares %.0f, %.1f; truth %g N m/rad, %g N m s/rad'
               % (*first, *found, *(sum(v) for v in zip(*feet.values())), *swing.truth[axis]))
    out.claim('%s: the start-up has settled before the release (rate below 2 %% of the swing\'s: %.2f %%)'
              % (axis, 100 * calc_quiet(c, swing, axis)), calc_quiet(c, swing, axis) < 0.02)
    errors = off(found, swing.truth[axis])
    out.see('%s %.3f Hz, damping ratio %.3f: adjusted K %+.1f %%, C %+.1f %%' % (axis, frequency, ratio, *(100 * e for e in errors)))
    # The model has the same rubber in both feet, the robot need not. About roll C is a small part of the damping.
    out.claim('%s: K comes back within 2 %% (%+.2f %%), C within 5 %% (%+.2f %%)' % (axis, *(100 * e for e in errors)),
              abs(errors[0]) < 0.02 and abs(errors[1]) < 0.05)
    errors = calc_errors(feet, swing, axis)
    out.claim('%s: so they do by least squares on the sensed moments, within 5 %% (%+.2f, %+.2f %%)' % (axis, *(100 * e for e in errors)),
              max(map(abs, errors)) < 0.05)
    key = '%s/%s' % (swing.imu, axis)
    gaps = calc_gap(before, c, key), calc_gap(after, c, key)
    out.claim('%s: the curve comes nearer by adjusting, to within 5 %% (%.1f, then %.1f %%)' % (axis, *(100 * g for g in gaps)),
              gaps[1] < 0.05 and gaps[1] < gaps[0])


def adjust_wrong(run, out, name, text, swing):
    """The same when the model has other masses and angles than the robot, as with a real one."""
    worst = {axis: [0.0, 0.0] for axis in AXES}
    for seed in (1, 2, 3):
        robot = text + 'variation: {mass: 0.02, pose: 0.02, seed: %d}\n' % seed
        c = run.trial(name + '_robot', robot, True)[1]
        measured = {axis: measure_swing(c, swing, axis)[1:] for axis in AXES}
        found = adjust(run, name, text, swing, measured)[1]
        for axis in AXES:
            worst[axis] = [max(w, abs(e)) for w, e in zip(worst[axis], off(found[axis], swing.truth[axis]))]
    for axis in AXES:
        out.number('%s, model with masses 2 %% and joints 0.02 rad off' % axis, 'K off by up to %.1f %%, C by up to %.1f %%'
                   % tuple(100 * w for w in worst[axis]))
    # About roll the vertical rubber is four fifths of the stiffness: its frequency says little of the rubber's rotation.
    out.claim('with a model that is wrong so pitch comes back within 5 %% (%.1f, %.1f %%)' % tuple(100 * w for w in worst['pitch']),
              max(worst['pitch']) < 0.05)


def tilt(name, swing):
    def measure(run, out):
        text = run.text(name)
        s, c = run.both(name, text)
        tell_logs(out, s)
        measured = {axis: measure_swing(c, swing, axis)[1:] for axis in AXES}
        first, found, before, after = adjust(run, name, text, swing, measured)
        for axis in AXES:
            tell_axis(out, swing, axis, c, first[axis], found[axis], before, after)
        by_hand = math.sqrt((swing.truth['pitch'][0] - swing.weight_moment) / swing.inertia) / (2.0 * math.pi)
        # One rigid body; its moments are known to three digits, and floor and vertical rubber give a little, too.
        out.claim('undamped frequency about pitch within 2 %% of the hand calculation sqrt((K - m g h) / I) / 2 pi (%.4f, %.4f Hz)'
                  % (measured['pitch'][0], by_hand), abs(measured['pitch'][0] / by_hand - 1.0) < 0.02)
        wrong = {axis: (1.1 * k, d) for axis, (k, d) in found.items()}
        gap = calc_gap(simulate(run, name, text, swing, wrong)[1], c, swing.imu + '/pitch')
        out.claim('control: with K a tenth too large the curve is off by more than 20 %% (%.0f %%)' % (100 * gap), gap > 0.2)
        adjust_wrong(run, out, name, text, swing)
        tell_varied(run, out, name, text, lambda r, v: upright(r) and max(
            abs(e) for axis in AXES for e in calc_errors(measure_swing(v, swing, axis)[0], swing, axis)) < 0.05,
            'K and C of both axes come back within 5 %', table=True)
        add_pictures(run, out, name, s, c, (5.6, 8.0), words='the swing')
        for axis, part in (('pitch', 'ty'), ('roll', 'tx')):
            key = 'left_foot/' + part
            out.figure('Torque about the %s axis at the left force sensor: measured, simulated with the first estimate, and with '
                       'the adjusted rubber.' % axis,
                       run.plot('%s_%s' % (name, axis), 'Ankle %s torque' % axis, 'time [s]', 'torque [N m]', c['time'],
                                {'measured': c[key], 'before': before[key], 'after': after[key]}))
    return measure


EXPERIMENTS = [
    Experiment('fig4', 'Figure 4: HRP-1S tilted and released',
               'Tilted and released without feedback the robot swings; stiffness and damping of the feet are found from the '
               'damped oscillation.', tilt('fig4', HRP1S_SWING), cost=20.0),
    Experiment('fig4_hrp2p', 'Figure 4 with HRP-2P', 'The same with HRP-2P.', tilt('fig4_hrp2p', HRP2P_SWING), cost=20.0),
]
