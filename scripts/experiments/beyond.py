# SPDX-License-Identifier: BSD-3-Clause
"""Beyond the paper: ten metres, turning, sideways, a slope, stairs, a slippery floor, an
attitude from noisy sensors, with the gains of figure 9; a public robot."""
import math

from experiment import Experiment, tell_run, tell_varied, upright
from walk_views import add_foot_force, add_pictures, find_feet


def walk(name, words, good, pictures=()):
    """words of the claim; good(summary)."""
    def measure(run, out):
        text = run.text(name)
        feet = find_feet(text)
        s, c = run.both(name, text)
        tell_run(out, s)
        out.see('%.2f m to the left, %.2f m up, turned by %.2f rad' % tuple(
            round(value, 2) + 0.0 for value in (s['travelled'][1], s['travelled'][2], s['turned'])))
        out.claim('upright to the end', upright(s))
        out.claim(words, good(s))
        tell_varied(run, out, name, text, lambda r: upright(r) and good(r), words)
        add_pictures(run, out, name, s, c, None, pictures, feet=feet)
        add_foot_force(run, out, name, s, c, feet)
    return measure


EXPERIMENTS = [
    Experiment('ten_metres', 'Ten metres forward', '', walk(
        'beyond_10m', 'walks 10 m, less than 0.5 m aside',
        lambda s: s['travelled'][0] > 9.5 and abs(s['travelled'][1]) < 0.5), 'beyond', 16.0),
    Experiment('turn', 'A turn on the spot', '', walk(
        'beyond_turn', 'turns by 2 pi within 0.2 rad', lambda s: abs(s['turned'] - 2 * math.pi) < 0.2), 'beyond', 14.0),
    Experiment('sideways', 'A metre sideways', '', walk(
        'beyond_sideways', 'walks 1 m to the left within 0.1 m', lambda s: abs(s['travelled'][1] - 1.0) < 0.1,
        ['--azimuth', '-0.3']), 'beyond', 10.0),
    Experiment('slope', 'Up a slope of 3 degrees', '', walk(
        'beyond_slope', 'climbs', lambda s: s['travelled'][2] > 0.05,
        ['--azimuth', '-1.4', '--elevation', '0.1']), 'beyond', 6.0),
    Experiment('stairs', 'Up four steps of 3 cm', '', walk(
        'beyond_stairs', 'climbs 12 cm within 1 cm, 1.44 m forward within 0.15 m',
        lambda s: abs(s['travelled'][2] - 0.12) < 0.01 and abs(s['travelled'][0] - 1.44) < 0.15,
        ['--azimuth', '-1.2', '--elevation', '0.25']), 'beyond', 6.0),
    Experiment('jvrc1', 'JVRC-1 walks', '', walk(
        'beyond_jvrc1', 'at least eight steps, 1 m forward',
        lambda s: sum(s['landings']) >= 8 and s['travelled'][0] > 1.0), 'beyond', 10.0),
    Experiment('attitude', 'Attitude from a noisy gyro and accelerometer', '', walk(
        'beyond_attitude', 'walks 2 m within 0.2 m', lambda s: abs(s['travelled'][0] - 2.0) < 0.2), 'beyond', 5.0),
    Experiment('friction', 'A floor with friction 0.3', '', walk(
        'beyond_friction', 'walks 2 m within 0.2 m', lambda s: abs(s['travelled'][0] - 2.0) < 0.2), 'beyond', 6.0),
]
