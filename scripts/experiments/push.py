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


def tell_directions(out, words, least):
    out.see('%s: %s N s at 0, 45, ... 315 degrees from forward to the left' % (words, ', '.join('%.1f' % v for v in least)))
    out.claim('%s, at least 8 N s in every direction (%.1f N s)' % (words, min(least)), min(least) >= 8.0)


def push(run, out):
    text, with_steps = run.text('beyond_push'), run.text('beyond_push_steps')
    alone, adjusted = find_least(run, 'push', text), find_least(run, 'push_steps', with_steps)
    tell_directions(out, 'stabilizer alone', alone)
    tell_directions(out, 'with step adjustment', adjusted)
    gain = sum(adjusted) / sum(alone) - 1.0
    out.see('on average step adjustment carries %+.0f %%' % (100 * gain))
    out.claim('step adjustment carries further than the stabilizer alone, on average over the directions (%+.0f %%)'
              % (100 * gain), gain > 0.0)
    out.figure('Largest impulse survived; the robot walks upward in the picture.',
               draw_polar(DIRECTIONS, {'with step adjustment': adjusted, 'stabilizer alone': alone,
                                       'wanted': [8.0] * len(DIRECTIONS)}, 'N s'))
    # A push that only step adjustment survives, where it carries most.
    k = max(range(len(DIRECTIONS)), key=lambda i: adjusted[i] - alone[i])
    words = '%.1f N s from %d degrees at 6.0 s, with step adjustment' % (adjusted[k], DIRECTIONS[k])
    s, c = run.both('push_steps', set_push(with_steps, adjusted[k], DIRECTIONS[k], STARTS[0]))
    tell_run(out, s)
    add_pictures(run, out, 'push_steps', s, c, (5.8, 8.6), words=words)
    add_foot_force(run, out, 'push_steps', s, c)


EXPERIMENTS = [Experiment('push', 'Pushed while walking', '', push, 'beyond', 90.0)]
