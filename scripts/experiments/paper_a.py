# SPDX-License-Identifier: BSD-3-Clause
"""Experiments of Hirukawa et al. 2003: run, measure, judge, report."""
import argparse
import html
import math
import os
import re
import sys
import time

from runs import ROOT, Runner, high_pass, least_squares, low_pass, median, rms

LEFT, RIGHT = 'L_ANKLE_R_LINK/force_z', 'R_ANKLE_R_LINK/force_z'
RATE = 1000.0  # [Hz] of the tables, the physics step


class Outcome:
    """claims: (text, holds). numbers: (name, value with unit)."""

    def __init__(self, saw):
        self.saw, self.claims, self.numbers, self.plots = saw, [], [], []

    def claim(self, text, holds):
        self.claims.append((text, bool(holds)))

    def number(self, name, value):
        self.numbers.append((name, value))

    def passed(self):
        return bool(self.claims) and all(holds for _, holds in self.claims)


def tell(run, out, summary):
    if summary.get('same') is not None:
        out.claim('server set and single process end in the same state, bit for bit', summary['same'])
    out.number('upright to the end', 'no, falls at %.2f s' % summary['fall_time'] if summary['fallen'] else 'yes')
    out.number('largest lean of the body', '%.3f rad' % summary['largest_lean'])
    out.number('travelled', '%.2f m forward, %.2f m to the left' % tuple(summary['travelled'][:2]))


def robust(run, out, name, text, runs, good, words):
    if not runs:
        return
    results = run.vary(name, text, runs)
    held = sum(1 for r in results if good(r))
    out.claim('%s in at least nine of ten runs with masses changed by up to 2 %% and joints by up to 0.02 rad (%d of %d)'
              % (words, held, runs), held >= 0.9 * runs)


def foot_force_plot(run, name, c):
    return run.plot(name, 'Vertical force on each foot', 'time [s]', 'force [N]', c['time'],
                    {'left foot': c[LEFT], 'right foot': c[RIGHT]})


def upright(r):
    return not r['fallen'] and not r['fault']


def fig3(run, runs):
    out = Outcome('Rigid feet, impulse contact, no stabilizer: HRP-1S walks in simulation.')
    text = run.text('fig3')
    s, c = run.both('fig3', text)
    tell(run, out, s)
    steps = sum(s['landings'])
    out.number('landings', str(steps))
    out.claim('upright to the end', upright(s))
    out.claim('at least eight steps', steps >= 8)
    robust(run, out, 'fig3', text, runs, lambda r: upright(r) and sum(r['landings']) >= 8, 'walks eight steps')
    out.plots.append(foot_force_plot(run, 'fig3', c))
    return out


def identify(c, begin, end):
    """K, C, O of both feet's bushes together: moment about the sole's middle against the body's pitch and its rate."""
    t = c['time']
    chosen = [i for i in range(1, len(t) - 1) if begin < t[i] < end and i % 5 == 4]  # when sensors are read
    pitch = c['base/pitch']
    angle = [pitch[i] for i in chosen]
    rate = [(pitch[i + 1] - pitch[i - 1]) * RATE / 2.0 for i in chosen]
    return chosen, angle, rate


def fig4_of(run, runs, name, height, forward, k_true, c_true, weight_moment, inertia):
    out = Outcome('Tilted and released without feedback the robot swings; stiffness and damping of the feet are found from '
                  'the damped oscillation of the ankle torque.')
    text = run.text(name)
    s, c = run.both(name, text)
    out.claim('server set and single process end in the same state, bit for bit', s['same'])
    chosen, angle, rate = identify(c, 2.7, 11.5)
    k_sum = c_sum = 0.0
    for side in ('left', 'right'):
        # About the middle of the sole, `height` below and `forward` of the sensor: M_S = M - p x f.
        ty, fx, fz = (c['%s_foot/%s' % (side, part)] for part in ('ty', 'fx', 'fz'))
        moment = [ty[i] + height * fx[i] + forward * fz[i] for i in chosen]
        # The wrench is the foot's on the leg: it rights the body, -K q - C qd - O.
        k, d, _ = least_squares([angle, rate, [1.0] * len(angle)], [-m for m in moment])
        k_sum, c_sum = k_sum + k, c_sum + d
        out.number('%s foot' % side, 'K %.1f N m/rad, C %.2f N m s/rad' % (k, d))
    out.number('both feet', 'K %.1f (true %g) N m/rad, C %.2f (true %g) N m s/rad' % (k_sum, k_true, c_sum, c_true))
    crossings = [c['time'][i] for i in chosen[1:]
                 if (c['base/pitch'][i - 5] - median(angle)) * (c['base/pitch'][i] - median(angle)) < 0.0]
    if len(crossings) > 2:
        frequency = (len(crossings) - 1) / (2.0 * (crossings[-1] - crossings[0]))
        by_hand = math.sqrt((k_true - weight_moment) / inertia) / (2.0 * math.pi)
        out.number('frequency', '%.3f Hz; by hand sqrt((K - m g h) / I) / 2 pi = %.3f Hz' % (frequency, by_hand))
        out.claim('frequency within 15 %% of the hand calculation for one rigid body (%.3f, %.3f Hz)' % (frequency, by_hand),
                  abs(frequency / by_hand - 1.0) < 0.15)
    out.claim('K comes back within 5 %% (%+.2f %%)' % (100.0 * (k_sum / k_true - 1.0)), abs(k_sum / k_true - 1.0) < 0.05)
    out.claim('C comes back within 5 %% (%+.2f %%)' % (100.0 * (c_sum / c_true - 1.0)), abs(c_sum / c_true - 1.0) < 0.05)
    out.plots.append(run.plot(name, 'Ankle pitch torque', 'time [s]', 'torque [N m]', c['time'],
                              {'left': c['left_foot/ty'], 'right': c['right_foot/ty']}))
    return out


def fig4(run, runs):
    return fig4_of(run, runs, 'fig4', 0.11, 0.035, 2000.0, 50.0, 1015.0, 107.0)


def fig4_hrp2p(run, runs):
    return fig4_of(run, runs, 'fig4_hrp2p', 0.105, 0.015, 914.0, 22.0, 462.0, 45.5)


def fig5(run, runs):
    out = Outcome('Soft feet, no stabilizer: HRP-1S falls.')
    text = run.text('fig5')
    s, c = run.both('fig5', text)
    tell(run, out, s)
    out.claim('falls', s['fallen'])

    def survives(name, k):
        changed = re.sub(r'k_roll: 1000, k_pitch: 1000', 'k_roll: %g, k_pitch: %g' % (k, k), run.text(name))
        if name == 'fig4':  # at rest, the rubber right under the centre of mass: nothing but the stiffness decides
            changed = re.sub(r'pushes:\n.*\n', '', changed).replace('{kz:', '{center: [-0.004, 0, -0.11], kz:')
            changed = changed.replace('duration: 12}', 'duration: 30}')
        return upright(run.trial('fig5_k', changed)[0])

    walks = ['%g: %s' % (k, 'walks' if survives('fig5', k) else 'falls') for k in (1000, 2000, 4000, 8000, 16000, 32000)]
    out.number('walking without a stabilizer, by stiffness [N m/rad]', ', '.join(walks))
    low, high = 200.0, 1000.0  # standing on both feet, joints locked
    if survives('fig4', high) and not survives('fig4', low):
        while high / low > 1.005:
            middle = math.sqrt(low * high)
            low, high = (low, middle) if survives('fig4', middle) else (middle, high)
        ratio = 2.0 * math.sqrt(low * high) / 1015.0
        out.number('stiffness of both feet at which even a standing robot begins to fall', '%.0f N m/rad = %.3f m g h'
                   % (1015.0 * ratio, ratio))
        out.claim('that is m g h = 1015 N m/rad within 5 %% (%.3f)' % ratio, abs(ratio - 1.0) < 0.05)
    else:
        out.claim('a threshold between 200 and 1000 N m/rad a foot', False)
    robust(run, out, 'fig5', text, runs, lambda r: r['fallen'], 'falls')
    out.plots.append(foot_force_plot(run, 'fig5', c))
    return out


BAND = (25.0, 100.0)  # [Hz] above the landings' own frequencies, below the contact's


def calc_band(c, key, end):
    y = low_pass(high_pass(c[key], RATE, BAND[0]), RATE, BAND[1])
    return rms(y, [i for i, t in enumerate(c['time']) if 3.0 < t < end])


def find_plateaus(c, key, weight):
    """Medians of the force in swing, double and single support, told apart by the other foot."""
    other = RIGHT if key == LEFT else LEFT
    chosen = [i for i, t in enumerate(c['time']) if 3.0 < t < 11.0]
    swing = [c[key][i] for i in chosen if c[other][i] > 0.9 * weight]
    single = [c[key][i] for i in chosen if c[other][i] == 0.0]
    return (median(swing) if swing else float('nan')), (median(single) if single else float('nan'))


def fig6(run, runs):
    out = Outcome('Soft feet, stabilizer, joints that follow perfectly: HRP-1S walks, but the vertical foot force oscillates.')
    text = run.text('fig6')
    s, c = run.both('fig6', text)
    tell(run, out, s)
    out.claim('walks', upright(s))
    here, there = calc_band(c, LEFT, 11.0), calc_band(run.trial('fig7', run.text('fig7'), True)[1], LEFT, 11.0)
    out.number('foot force between %g and %g Hz' % BAND, '%.0f N rms; figure 7, with servos: %.0f N rms' % (here, there))
    out.claim('power of the oscillation at least ten times that of figure 7 (%.0f times)' % ((here / there) ** 2),
              (here / there) ** 2 > 10.0)
    robust(run, out, 'fig6', text, runs, upright, 'walks')
    out.plots.append(foot_force_plot(run, 'fig6', c))
    return out


def fig7(run, runs):
    out = Outcome('The same gains with joint servos and rotor inertia: the oscillation is gone; zero in swing, a middle plateau '
                  'in double support, a high one in single support.')
    text = run.text('fig7')
    s, c = run.both('fig7', text)
    tell(run, out, s)
    weight = 120.0 * 9.81
    out.claim('walks', upright(s))
    for key, foot in ((LEFT, 'left'), (RIGHT, 'right')):
        swing, single = find_plateaus(c, key, weight)
        standing = median([c[key][i] for i, t in enumerate(c['time']) if 13.0 < t < 14.0])
        out.number('%s foot' % foot, 'swing %.0f N, single support %.0f N, standing on both feet %.0f N' % (swing, single, standing))
        out.claim('%s foot: 0 N in swing (%.1f N)' % (foot, swing), abs(swing) < 1.0)
        out.claim('%s foot: about 1177 N in single support (%.0f N, within 10 %%)' % (foot, single), abs(single / weight - 1) < 0.1)
        out.claim('%s foot: about 590 N on both feet (%.0f N, within 10 %%)' % (foot, standing), abs(standing / (weight / 2) - 1) < 0.1)
    out.number('foot force between %g and %g Hz' % BAND, '%.0f N rms' % calc_band(c, LEFT, 11.0))
    robust(run, out, 'fig7', text, runs, upright, 'walks')
    out.plots.append(foot_force_plot(run, 'fig7', c))
    return out


def fig8(run, runs):
    out = Outcome('HRP-2P falls without the stabilizer.')
    text = run.text('fig8')
    s, c = run.both('fig8', text)
    tell(run, out, s)
    out.claim('falls', s['fallen'])
    robust(run, out, 'fig8', text, runs, lambda r: r['fallen'], 'falls')
    out.plots.append(foot_force_plot(run, 'fig8', c))
    return out


def fig9(run, runs):
    out = Outcome('HRP-2P walks with the stabilizer.')
    text = run.text('fig9')
    s, c = run.both('fig9', text)
    tell(run, out, s)
    out.claim('walks to the end', upright(s) and sum(s['landings']) >= 8)
    robust(run, out, 'fig9', text, runs, upright, 'walks')
    out.plots.append(foot_force_plot(run, 'fig9', c))
    return out


def fig10(run, runs):
    out = Outcome('Ankle roll torque at the force sensor: the body rolls inward; vibration at a step of 1 ms.')
    text = run.text('fig10')
    s, c = run.both('fig10', text)
    tell(run, out, s)
    inward = {}
    for side, key, sign in (('left', LEFT, 1.0), ('right', RIGHT, -1.0)):
        other = RIGHT if key == LEFT else LEFT
        chosen = [i for i, t in enumerate(c['time']) if 3.0 < t < 11.0 and c[other][i] == 0.0 and c[key][i] > 300.0]
        # A load inward of the ankle turns the left foot about -x, the right one about +x.
        inward[side] = -sign * sum(c[side + '_foot/tx'][i] for i in chosen) / max(1, len(chosen))
        out.number('%s ankle, mean roll torque in single support' % side, '%.1f N m inward' % inward[side])
    out.claim('inward on both sides', inward['left'] > 0.0 and inward['right'] > 0.0)
    vibration = []
    for step in (0.001, 0.0005, 0.00025):
        changed = text.replace('time_step: 0.001', 'time_step: %g' % step)
        columns = c if step == 0.001 else run.trial('fig10_step', changed, True)[1]
        keep = max(1, round(0.001 / step))
        total = [columns[LEFT][i] for i in range(keep - 1, len(columns['time']), keep)]
        times = [columns['time'][i] for i in range(keep - 1, len(columns['time']), keep)]
        y = high_pass(total, RATE, 50.0)
        vibration.append(rms(y, [i for i, t in enumerate(times) if 3.0 < t < 11.0]))
        out.number('foot force above 50 Hz at a step of %g ms' % (1000 * step), '%.2f N rms' % vibration[-1])
    out.claim('the vibration shrinks with the step', vibration[0] > vibration[1] > vibration[2])
    out.plots.append(run.plot('fig10', 'Ankle roll torque', 'time [s]', 'torque [N m]', c['time'],
                              {'left': c['left_foot/tx'], 'right': c['right_foot/tx']}))
    return out


def find_landings(c):
    """(time, peak, dip, full) of each landing in the steady walk: first 70 ms, the next 80 ms, the rest of 250 ms."""
    found = []
    for key in (LEFT, RIGHT):
        f, i, air = c[key], 1, 0
        while i < len(f) - 250:
            if f[i] > 5.0 and air > 150 and c['time'][i] > 2.5:
                w = f[i:i + 250]
                peak = max(range(70), key=lambda j: w[j])
                dip = min(range(peak, peak + 80), key=lambda j: w[j])
                found.append((c['time'][i], w[peak], w[dip], max(w[dip:])))
                i, air = i + 250, 0
                continue
            air = air + 1 if f[i] <= 5.0 else 0
            i += 1
    return sorted(found)[1:-1]  # not the first and the last step


def fig11(run, runs):
    out = Outcome('Landing: about 500 N, down to about 100 N, then about 550 N, within about 250 ms.')
    text = run.text('fig11')
    s, c = run.both('fig11', text)
    tell(run, out, s)
    landings = find_landings(c)
    names, goals = ('first peak', 'dip', 'full load'), (500.0, 100.0, 550.0)
    for k, (name, goal) in enumerate(zip(names, goals)):
        values = [l[k + 1] for l in landings]
        m = median(values)
        out.number(name, 'median %.0f N, %.0f to %.0f N over %d landings' % (m, min(values), max(values), len(values)))
        out.claim('%s within 20 %% of %.0f N (%.0f N)' % (name, goal, m), abs(m / goal - 1.0) <= 0.2)
    t0 = landings[len(landings) // 2][0]
    chosen = [i for i, t in enumerate(c['time']) if t0 - 0.05 < t < t0 + 0.3]
    key = LEFT if c[LEFT][chosen[80]] > 0 and c[LEFT][chosen[0]] == 0 else RIGHT
    out.plots.append(run.plot('fig11', 'Vertical force of a landing foot', 'time [s]', 'force [N]',
                              [c['time'][i] for i in chosen], {'landing foot': [c[key][i] for i in chosen]}))
    return out


def beyond(name, saw, judge):
    def experiment(run, runs):
        out = Outcome(saw)
        text = run.text(name)
        s, c = run.both(name, text)
        tell(run, out, s)
        out.number('turned', '%.2f rad' % s['turned'])
        out.claim('upright to the end', upright(s))
        words, good = judge(s)
        out.claim(words, good)
        robust(run, out, name, text, runs, lambda r: upright(r) and judge(r)[1], words)
        out.plots.append(foot_force_plot(run, name, c))
        return out
    return experiment


def push(run, runs):
    out = Outcome('Beyond the paper: the largest push to the chest that is survived while walking, in eight directions, '
                  '0.1 s long, at 6.0 s (single support) and at 6.45 s (the other part of the step).')
    text = run.text('beyond_push')
    directions = [45 * k for k in range(8)]
    least = []
    for angle in directions:
        a, found = math.radians(angle), []
        for start in (6.0, 6.45):
            def survives(impulse):
                force = '[%.3f, %.3f, 0]' % (10 * impulse * math.cos(a), 10 * impulse * math.sin(a))
                changed = re.sub(r'force: \[.*?\], start: [\d.]+', 'force: %s, start: %g' % (force, start), text)
                return upright(run.trial('push_try', changed)[0])
            low, high = 0.0, 32.0
            while high - low > 0.5:
                middle = 0.5 * (low + high)
                low, high = (middle, high) if survives(middle) else (low, middle)
            found.append(low)
        least.append(min(found))
        out.number('%d degrees from forward to the left' % angle, '%.1f N s' % min(found))
    out.claim('at least 8 N s in every direction (%.1f N s)' % min(least), min(least) >= 8.0)
    out.plots.append(run.plot('push', 'Largest push survived', 'direction from forward to the left [deg]', 'impulse [N s]',
                              directions + [360], {'survived': least + least[:1], 'wanted': [8.0] * 9}))
    return out


EXPERIMENTS = {
    'fig3': fig3, 'fig4': fig4, 'fig4_hrp2p': fig4_hrp2p, 'fig5': fig5, 'fig6': fig6, 'fig7': fig7, 'fig8': fig8,
    'fig9': fig9, 'fig10': fig10, 'fig11': fig11,
    'ten_metres': beyond('beyond_10m', 'Beyond the paper: ten metres forward.',
                         lambda s: ('walks 10 m, less than 0.5 m aside', s['travelled'][0] > 9.5 and abs(s['travelled'][1]) < 0.5)),
    'turn': beyond('beyond_turn', 'Beyond the paper: a whole turn on the spot.',
                   lambda s: ('turns by 2 pi within 0.2 rad', abs(s['turned'] - 2 * math.pi) < 0.2)),
    'sideways': beyond('beyond_sideways', 'Beyond the paper: a metre sideways.',
                       lambda s: ('walks 1 m to the left within 0.1 m', abs(s['travelled'][1] - 1.0) < 0.1)),
    'slope': beyond('beyond_slope', 'Beyond the paper: up a slope of 3 degrees.',
                    lambda s: ('climbs', s['travelled'][2] > 0.05)),
    'friction': beyond('beyond_friction', 'Beyond the paper: on a floor with friction 0.3.',
                       lambda s: ('walks 2 m within 0.2 m', abs(s['travelled'][0] - 2.0) < 0.2)),
    'push': push,
}
GROUPS = {'all': list(EXPERIMENTS), 'paper': [n for n in EXPERIMENTS if n.startswith('fig')],
          'beyond': [n for n in EXPERIMENTS if not n.startswith('fig')]}

STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}
@media(prefers-color-scheme:dark){body{color:#ddd;background:#181a1b}}
h2{margin-top:2.5rem}.pass{color:#18794e}.fail{color:#c62a2f}td{padding:.1rem 1rem .1rem 0;vertical-align:top}svg{max-width:100%;height:auto}"""


def make_page(results):
    rows = ''.join('<tr><td><a href="#%s">%s</a></td><td class="%s">%s</td></tr>'
                   % (n, n, 'pass' if o.passed() else 'fail', 'pass' if o.passed() else 'FAIL') for n, o in results)
    parts = ['<!doctype html><html lang="en"><meta charset="utf-8"><title>Experiments of Hirukawa et al. 2003</title>'
             '<style>%s</style><h1>Do the simulations correspond?</h1><p>Experiments of Hirukawa et al., ICRA 2003, and some '
             'beyond. All data are simulated.</p><table>%s</table>' % (STYLE, rows)]
    for name, o in results:
        claims = ''.join('<li class="%s">%s: %s</li>' % ('pass' if h else 'fail', 'holds' if h else 'DOES NOT HOLD', html.escape(t))
                         for t, h in o.claims)
        numbers = ''.join('<tr><td>%s</td><td>%s</td></tr>' % (html.escape(a), html.escape(b)) for a, b in o.numbers)
        parts.append('<h2 id="%s">%s</h2><p>%s</p><ul>%s</ul><table>%s</table>%s'
                     % (name, name, html.escape(o.saw), claims, numbers, ''.join(o.plots)))
    return '\n'.join(parts) + '</html>\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', default=['all'])
    parser.add_argument('--bin', default=os.path.join(ROOT, 'build', 'bin'))
    parser.add_argument('--out', default=os.path.join(ROOT, 'logs', 'experiments'))
    parser.add_argument('--dds', default='cyclone', choices=['cyclone', 'fast'])
    parser.add_argument('--runs', type=int, default=10)
    parser.add_argument('--list', action='store_true')
    options = parser.parse_args()
    if options.list:
        print('\n'.join(list(GROUPS) + list(EXPERIMENTS)))
        return 0
    names = [n for given in options.names for n in GROUPS.get(given, [given])]
    unknown = [n for n in names if n not in EXPERIMENTS]
    if unknown:
        sys.exit("no experiment '%s'; there are %s" % (unknown[0], ', '.join(list(GROUPS) + list(EXPERIMENTS))))
    run, results = Runner(options.bin, os.path.abspath(options.out), options.dds), []
    for number, name in enumerate(names, 1):
        begin = time.time()
        print('[%d/%d] %s ...' % (number, len(names), name), end=' ', flush=True)
        try:
            outcome = EXPERIMENTS[name](run, options.runs)
        except Exception as error:  # an experiment that cannot be run is a failed one, and the others go on
            outcome = Outcome('could not be run')
            outcome.claim(str(error), False)
        results.append((name, outcome))
        print('%s (%.0f s)' % ('pass' if outcome.passed() else 'FAIL', time.time() - begin), flush=True)
        for text, holds in outcome.claims:
            if not holds:
                print('        does not hold: ' + text, flush=True)
        with open(os.path.join(run.out, 'report.html'), 'w') as file:
            file.write(make_page(results))
    print('report: ' + os.path.join(run.out, 'report.html'))
    return 0 if all(o.passed() for _, o in results) else 1


if __name__ == '__main__':
    sys.exit(main())
