# SPDX-License-Identifier: BSD-3-Clause
"""What experiments measure, on data whose answer is known; and how they are judged."""
import math
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), '..', '..', '..', 'scripts', 'experiments'))
import hrp2p  # noqa: E402
import main  # noqa: E402
import measure  # noqa: E402
import swing as tilting  # noqa: E402
from experiment import Experiment, Outcome  # noqa: E402
from report import make_page, make_table  # noqa: E402
from walk_views import LEFT, RIGHT  # noqa: E402


def make_swing(frequency, ratio, stiffness, damping):
    """Pitch and sensed torques of a damped swing, 12 s at 1 kHz; frequency [Hz] undamped."""
    w = 2.0 * math.pi * frequency
    wd, c = w * math.sqrt(1.0 - ratio * ratio), {key: [] for key in ('time', 'trunk/pitch')}
    for side in ('left', 'right'):
        c.update({'%s_foot/%s' % (side, part): [] for part in ('ty', 'fx', 'fz')})
    for i in range(12000):
        t = (i + 1) / 1000.0
        decay = 0.03 * math.exp(-ratio * w * t)
        angle = decay * math.cos(wd * t)
        rate = -ratio * w * angle - wd * decay * math.sin(wd * t)
        c['time'].append(t)
        c['trunk/pitch'].append(round(angle, 6))  # as the table has it
        for side in ('left', 'right'):
            c[side + '_foot/ty'].append(-0.5 * (stiffness * angle + damping * rate) - 3.0)
            c[side + '_foot/fx'].append(0.0)
            c[side + '_foot/fz'].append(0.0)
    return c


class Measures(unittest.TestCase):
    def test_a_swing_gives_back_its_stiffness_damping_and_frequency(self):
        swing = tilting.Swing('trunk', 0.11, 0.035, 1015.0, 107.0, 5e5, 0.09, {'pitch': (2000.0, 50.0)})
        found, frequency, ratio = tilting.measure_swing(make_swing(0.48, 0.08, 2000.0, 50.0), swing, 'pitch', 2.7, 11.5)
        k, d = tilting.calc_errors(found, swing)
        # Differences over 20 ms flatten a 0.48 Hz rate by (w h)^2 / 6 = 0.06 %, and six digits add about as much.
        self.assertLess(abs(k), 0.002)
        self.assertLess(abs(d), 0.005)
        self.assertLess(abs(frequency / 0.48 - 1.0), 0.002)
        self.assertLess(abs(ratio / 0.08 - 1.0), 0.01)

    def test_a_landing_is_read_as_its_peak_its_dip_and_its_full_load(self):
        def force(t):  # [N] of a foot that lands at t = 0
            return 0.0 if t < 0 else 510.0 if t < 0.03 else 120.0 if t < 0.08 else 560.0 if t < 0.6 else 0.0
        times = [i / 1000.0 for i in range(1, 14001)]
        left = [force((t % 1.8) - 0.9) for t in times]
        right = [force((t % 1.8) - 0.0) for t in times]
        landings = hrp2p.find_landings({'time': times, LEFT: left, RIGHT: right})
        self.assertGreater(len(landings), 8)
        for landing in landings:
            self.assertEqual(landing[2:], (510.0, 120.0, 560.0))

    def test_filters_let_half_the_power_through_at_their_cutoff_and_none_or_all_far_from_it(self):
        def calc_gain(filtered, frequency):
            wave = [math.sin(2 * math.pi * frequency * i / 1000.0) for i in range(8000)]
            return measure.rms(filtered(wave, 1000.0, 50.0), range(3000, 8000)) * math.sqrt(2.0)
        for filtered, slow, fast in ((measure.high_pass, 0.0, 1.0), (measure.low_pass, 1.0, 0.0)):
            self.assertAlmostEqual(calc_gain(filtered, 50.0), 0.5, delta=0.005)  # two filters of 1 / sqrt(2)
            self.assertAlmostEqual(calc_gain(filtered, 2.0), slow, delta=0.005)  # (2 / 50)^2
            self.assertAlmostEqual(calc_gain(filtered, 450.0), fast, delta=0.005)


class Judging(unittest.TestCase):
    def test_nothing_claimed_is_no_pass(self):
        self.assertEqual(Outcome().verdict(), 'FAIL')

    def test_one_claim_that_fails_fails_the_experiment(self):
        outcome = Outcome()
        outcome.claim('this', True)
        self.assertEqual(outcome.verdict(), 'pass')
        outcome.claim('that', False)
        self.assertEqual(outcome.verdict(), 'FAIL')

    def test_what_could_not_be_run_is_neither(self):
        outcome = Outcome()
        outcome.skipped = 'no robot'
        self.assertEqual(outcome.verdict(), 'skipped')
        self.assertIn('not run', make_table([(Experiment('a', 'A', '', None), outcome)]))

    def test_the_page_needs_no_other_file_and_says_what_fails(self):
        outcome = Outcome()
        outcome.claim('x < 1', False)
        outcome.figure('a "plot"', '<svg viewBox="0 0 1 1"></svg>')
        page = make_page([(Experiment('fig3', 'A & B', 'saw', None), outcome)], '')
        self.assertIn('x &lt; 1', page)
        self.assertIn('A &amp; B', page)
        self.assertIn('does not hold', page)
        for word in ('src=', 'url(', '<link', '<script', 'http://', 'https://'):
            self.assertNotIn(word, page)

    def test_names_and_groups_choose_experiments_once(self):
        experiments = main.load_experiments()
        self.assertEqual(main.choose(['all', 'fig3'], experiments), experiments)
        self.assertEqual(len({e.name for e in experiments}), len(experiments))
        self.assertTrue(all(e.name.startswith('fig') or e.name in ('laws', 'terms') for e in main.choose(['paper'], experiments)))
        with self.assertRaises(SystemExit):
            main.choose(['fig99'], experiments)


if __name__ == '__main__':
    unittest.main()
