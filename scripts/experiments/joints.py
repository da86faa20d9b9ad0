# SPDX-License-Identifier: BSD-3-Clause
"""Figures 6 and 7: the same stabilizer shakes the feet when joints follow perfectly, and not with servo and rotor."""
import re

from experiment import Experiment, tell_run, tell_varied, upright
from measure import high_pass, low_pass, median, rms
from walk_views import LEFT, RATE, RIGHT, add_foot_force, add_pictures, cut

BAND = (25.0, 100.0)  # [Hz] above the landings' own frequencies, below the contact's
WEIGHT = 120.0 * 9.81  # [N]


def calc_band(c, key):
    """[N rms] of the steady walk within BAND."""
    y = low_pass(high_pass(c[key], RATE, BAND[0]), RATE, BAND[1])
    return rms(y, [i for i, t in enumerate(c['time']) if 3.0 < t < 11.0])


def find_plateaus(c, key):
    """Medians of the force in swing and in single support, told apart by the other foot."""
    other = RIGHT if key == LEFT else LEFT
    chosen = [i for i, t in enumerate(c['time']) if 3.0 < t < 11.0]
    swing = [c[key][i] for i in chosen if c[other][i] > 0.9 * WEIGHT]
    single = [c[key][i] for i in chosen if c[other][i] == 0.0]
    return (median(swing) if swing else float('nan')), (median(single) if single else float('nan'))


def find_double_support(c):
    """(median of each foot's force while both carry in the steady walk, share of these samples within 10 % of half the weight)."""
    chosen = [i for i, t in enumerate(c['time']) if 3.0 < t < 11.0 and c[LEFT][i] > 30.0 and c[RIGHT][i] > 30.0]
    forces = [[c[key][i] for i in chosen] for key in (LEFT, RIGHT)]
    near = sum(abs(f / (WEIGHT / 2) - 1.0) < 0.1 for foot in forces for f in foot) / max(1, 2 * len(chosen))
    return [median(foot) for foot in forces] if chosen else [float('nan')] * 2, near


# Sensors' filter [s] and damping of the height law [N s/m], the gain's inverse; figures 6 and 7 have the first of both, figures 8
# to 11 the second filter.
FILTERS, GAINS = (0.0, 0.01, 0.02), (1250.0, 600.0, 300.0, 150.0)


def map_loop(run, out):
    """What the loop of height law, joints and sensors needs to shake."""
    shakes = {}
    for seconds in FILTERS:
        for damping in GAINS:
            for name in ('fig6', 'fig7'):
                text = re.sub(r'force_filter: \S+', 'force_filter: %g' % seconds, run.text(name))
                s, c = run.trial('map', re.sub(r'height_damping: \d+', 'height_damping: %g' % damping, text), True)
                shakes[name, seconds, damping] = None if s['fallen'] else calc_band(c, LEFT)
            out.number('filter %g ms, height damping %g N s/m' % (1e3 * seconds, damping), 'joints that follow %s, servos %s' % tuple(
                'fall' if shakes[name, seconds, damping] is None else '%.0f N rms' % shakes[name, seconds, damping]
                for name in ('fig6', 'fig7')))
    filtered = [shakes[name, 0.01, GAINS[0]] for name in ('fig6', 'fig7')]
    out.claim('control: with the filter of figures 8 to 11 neither shakes at this gain (%s N rms, below 30)'
              % ', '.join('%.0f' % f if f else 'falls' for f in filtered), all(f and f < 30.0 for f in filtered))
    strong = [shakes[name, 0.01, GAINS[-1]] for name in ('fig6', 'fig7')]
    out.claim('with that filter and eight times the gain joints that follow shake with at least four times the power of servos (%s N rms)'
              % ', '.join('%.0f' % f if f else 'falls' for f in strong), all(strong) and strong[0] > 2.0 * strong[1])


def add_closer_look(run, out, name, c):
    near = cut(c, 5.0, 7.0)
    out.figure('Two seconds of it.',
               run.plot(name + '_near', 'Vertical force on each foot, two seconds', 'time [s]', 'force [N]', near['time'],
                        {'left foot': near[LEFT], 'right foot': near[RIGHT]}))


def fig6(run, out):
    text = run.text('fig6')
    s, c = run.both('fig6', text)
    tell_run(out, s)
    out.claim('walks', upright(s))
    there = calc_band(run.trial('fig7', run.text('fig7'), True)[1], LEFT)

    def calc_power(columns):
        return (calc_band(columns, LEFT) / there) ** 2

    here, power = calc_band(c, LEFT), calc_power(c)
    out.number('foot force between %g and %g Hz' % BAND, '%.0f N rms; figure 7, with servos: %.0f N rms' % (here, there))
    out.see('foot force of %.0f N rms from %g to %g Hz, %.0f times the power of figure 7' % (here, *BAND, power))
    out.claim('power of the oscillation at least ten times that of figure 7 (%.0f times), and below 1000 N rms' % power,
              power > 10.0 and here < 1000.0)
    map_loop(run, out)
    tell_varied(run, out, 'fig6', text, lambda r, columns: upright(r) and calc_power(columns) > 10.0,
                'walks, the foot force shaking with at least ten times the power of figure 7,', table=True)
    add_foot_force(run, out, 'fig6', s, c)
    add_closer_look(run, out, 'fig6', c)
    add_pictures(run, out, 'fig6', s, c)


def judge_plateaus(c):
    """[(claim, holds)] for both feet; 10 %: the heights of plateaus, not of the steps' overshoots."""
    claims = []
    for key, foot in ((LEFT, 'left'), (RIGHT, 'right')):
        swing, single = find_plateaus(c, key)
        standing = median([c[key][i] for i, t in enumerate(c['time']) if 13.0 < t < 14.0])
        claims += [('%s foot: 0 N in swing (%.1f N)' % (foot, swing), abs(swing) < 1.0),
                   ('%s foot: about 590 N standing on both feet (%.0f N, within 10 %%)' % (foot, standing),
                    abs(standing / (WEIGHT / 2) - 1) < 0.1),
                   ('%s foot: about 1177 N in single support (%.0f N, within 10 %%)' % (foot, single),
                    abs(single / WEIGHT - 1) < 0.1)]
    return claims


def fig7(run, out):
    text = run.text('fig7')
    s, c = run.both('fig7', text)
    tell_run(out, s)
    out.claim('walks', upright(s))
    for claim, holds in judge_plateaus(c):
        out.claim(claim, holds)
    for key, foot in ((LEFT, 'left'), (RIGHT, 'right')):
        swing, single = find_plateaus(c, key)
        out.see('%s foot %.0f N in swing, %.0f N in single support' % (foot, swing, single))
    band, (double, near) = calc_band(c, LEFT), find_double_support(c)
    out.see('%.0f N rms from %g to %g Hz' % (band, *BAND))
    out.claim('the oscillation is gone: below 30 N rms (%.0f)' % band, band < 30.0)
    out.claim('each foot lands once a step, six times in ten steps and the last (%d, %d)' % tuple(s['landings']),
              all(n == 6 for n in s['landings']))
    # The pattern's ZMP crosses from foot to foot at constant speed: forces are ramps through half the weight, no plateau.
    out.claim('while it walks, both feet down, half the weight is in the middle: medians within 10 %% of 590 N (%.0f, %.0f N)'
              % tuple(double), all(abs(f / (WEIGHT / 2) - 1.0) < 0.1 for f in double))
    out.see('both feet down in the walk: medians %.0f and %.0f N, %.0f %% of the samples within 10 %% of 590 N' % (*double, 100 * near))
    tell_varied(run, out, 'fig7', text, lambda r, columns: upright(r) and all(holds for _, holds in judge_plateaus(columns)),
                'walks with these plateaus', table=True)
    add_foot_force(run, out, 'fig7', s, c)
    add_closer_look(run, out, 'fig7', c)
    add_pictures(run, out, 'fig7', s, c)


EXPERIMENTS = [
    Experiment('fig6', 'Figure 6: joints that follow perfectly',
               'Soft feet, stabilizer, joints that follow perfectly: HRP-1S walks, but the vertical foot force oscillates.',
               fig6, cost=8.0),
    Experiment('fig7', 'Figure 7: joint servos and rotor inertia',
               'The same gains with joint servos and rotor inertia: the oscillation is gone; zero in swing, a middle plateau '
               '(590 N) in double support, a high one (1177 N) in single support.', fig7, cost=6.0),
]
