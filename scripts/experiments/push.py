# SPDX-License-Identifier: BSD-3-Clause
"""Beyond the paper: the largest push to the chest that is survived while walking, in eight directions."""
import math
import re

from experiment import Experiment, tell_run, upright
from polar import draw_polar
from walk_views import add_foot_force, add_pictures

DIRECTIONS = [45 * k for k in range(8)]  # [deg] from forward to the left
STARTS = (6.0, 6.45)  # [s] single support, and the other part of the step
LENGTH = 0.1          # [s]
LARGEST = 32.0        # [N s]


def set_push(text, impulse, degrees, start):
    a = math.radians(degrees)
    force = '[%.3f, %.3f, 0]' % (impulse / LENGTH * math.cos(a), impulse / LENGTH * math.sin(a))
    return re.sub(r'force: \[.*?\], start: [\d.]+', 'force: %s, start: %g' % (force, start), text)


def find_largest(run, name, text, degrees, start):
    """[N s] the largest impulse survived, by bisection to 0.5 N s."""
    low, high = 0.0, LARGEST
    while high - low > 0.5:
        middle = 0.5 * (low + high)
        survived = upright(run.trial(name + '_try', set_push(text, middle, degrees, start))[0])
        low, high = (middle, high) if survived else (low, middle)
    return low


def find_least(run, name, text):
    return [min(find_largest(run, name, text, d, start) for start in STARTS) for d in DIRECTIONS]


def push(run, out):
    text = run.text('beyond_push')
    least = find_least(run, 'push', text)
    rows = {'survived': least, 'wanted': [8.0] * len(DIRECTIONS)}
    out.see('%s N s at 0, 45, ... 315 degrees from forward to the left' % ', '.join('%.1f' % v for v in least))
    for d, value in zip(DIRECTIONS, least):
        out.number('%d degrees from forward to the left' % d, '%.1f N s' % value)
    out.claim('at least 8 N s in every direction (%.1f N s)' % min(least), min(least) >= 8.0)
    out.figure('Largest impulse survived [N s]; the robot walks upward in the picture.', draw_polar(DIRECTIONS, rows, 'N s'))
    weakest = DIRECTIONS[least.index(min(least))]
    s, c = run.both('push', set_push(text, 8.0, weakest, STARTS[0]))
    tell_run(out, s)
    add_pictures(run, out, 'push', s, c, (5.8, 8.0), words='8 N s from the weakest direction (%d degrees) at 6.0 s' % weakest)
    add_foot_force(run, out, 'push', s, c)


EXPERIMENTS = [Experiment('push', 'Pushed while walking', '', push, 'beyond', 60.0)]
