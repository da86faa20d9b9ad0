# SPDX-License-Identifier: BSD-3-Clause
"""Figures 3 and 5: rigid feet walk, soft feet fall."""
import math
import re

from experiment import Experiment, tell_run, tell_varied, upright
from swing import HRP1S_WEIGHT_MOMENT
from walk_views import add_foot_force, add_pictures


def fig3(run, out):
    text = run.text('fig3')
    s, c = run.both('fig3', text)
    tell_run(out, s)
    steps = sum(s['landings'])
    out.see('%d landings' % steps)
    out.claim('upright to the end', upright(s))
    out.claim('eight to fourteen landings (%d)' % steps, 8 <= steps <= 14)
    tell_varied(run, out, 'fig3', text, lambda r: upright(r) and sum(r['landings']) >= 8, 'walks eight steps')
    add_pictures(run, out, 'fig3', s, c)
    add_foot_force(run, out, 'fig3', s, c)


def set_bush(text, k, c):
    """Roll and pitch alike: k [N m/rad], c [N m s/rad] of a foot."""
    return re.sub(r'k_roll: 1000, k_pitch: 1000, c_roll: 25, c_pitch: 25',
                  'k_roll: %g, k_pitch: %g, c_roll: %g, c_pitch: %g' % (k, k, c, c), text)


def stands(run, k):
    """HRP-1S with locked joints, the rubber right under the centre of mass: nothing but the stiffness decides."""
    text = re.sub(r'hands:\n(  .*\n)+', '', run.text('fig4')).replace('{kz:', '{center: [-0.004, 0, -0.11], kz:')
    return upright(run.trial('fig5_stands', set_bush(text.replace('duration: 16}', 'duration: 30}'), k, 25.0))[0])


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


# One thing at a time: the law, the floor, the rubber. `contact` of a scenario.
FLOORS = (('impulses', 'model: impulse'), ('points, 1e8 N/m', 'stiffness: 1.0e8, tangential_stiffness: 1.0e7, margin: 0.001'),
          ('points, 1e7 N/m', 'stiffness: 1.0e7, tangential_stiffness: 1.0e7'),
          ('points, 2e6 N/m', 'stiffness: 2.0e6, tangential_stiffness: 2.0e6'),
          ('wrench of pairs, alpha 0', 'model: wrench, alpha: 0, tangential_damping: 1.0e5, margin: 0.04'),
          ('wrench of pairs, alpha 2.4', 'model: wrench, tangential_damping: 1.0e5, margin: 0.04'))


def control(run, out, text):
    fell = {}
    for floor, keys in FLOORS:
        for rubber in (True, False):
            changed = re.sub(r'(?m)^contact: .*', 'contact: {%s}' % keys, text)
            changed = changed if rubber else re.sub(r'foot_bush:\n(  .*\n)+', '', changed)
            summary, _ = run.trial('fig5_control', changed)
            fell[floor, rubber] = summary['fallen']
            out.number('%s, %s' % (floor, 'soft feet' if rubber else 'rigid feet'), 'falls at %.2f s' % summary['fall_time']
                       if summary['fallen'] else 'upright, largest lean %.3f rad' % summary['largest_lean'])
    same = ('impulses', 'points, 1e8 N/m', 'points, 1e7 N/m', 'wrench of pairs, alpha 0')
    out.claim('it is the rubber: soft feet fall and rigid ones do not, with %s' % '; '.join(same),
              all(fell[floor, True] and not fell[floor, False] for floor in same))
    out.claim('a floor as soft as rubber makes it fall, too: rigid feet on 2e6 N/m', fell['points, 2e6 N/m', False])


def fig5(run, out):
    text = run.text('fig5')
    s, c = run.both('fig5', text)
    tell_run(out, s)
    out.claim('falls, and not before it lifts its first foot at 2.2 s nor after its fourth step (%.2f s)' % s['fall_time'],
              s['fallen'] and 2.2 < s['fall_time'] < 6.0)
    control(run, out, text)
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
    Experiment('fig5', 'Figure 5: HRP-1S on soft feet', 'HRP-1S falls on soft feet without a stabilizer.', fig5, cost=10.0),
]
