# SPDX-License-Identifier: BSD-3-Clause
"""Figures 6 and 7: the same stabilizer shakes the feet when joints follow perfectly, and not with servo and rotor."""
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
    out.claim('power of the oscillation at least ten times that of figure 7 (%.0f times)' % power, power > 10.0)
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
                   ('%s foot: about 590 N on both feet (%.0f N, within 10 %%)' % (foot, standing),
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
    out.see('%.0f N rms from %g to %g Hz' % (calc_band(c, LEFT), *BAND))
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
