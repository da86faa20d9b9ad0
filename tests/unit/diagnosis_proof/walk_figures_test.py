# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of a walk from its curves, against curves whose numbers are known by hand. Run as: walk_figures_test.py SOURCE_DIR"""
import math
import pathlib
import sys
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else ".")
sys.path.insert(0, str(SOURCE / "scripts" / "diagnosis"))
import closed_loop  # noqa: E402
import resimulate  # noqa: E402
import walk_figures as figures  # noqa: E402
import walk_report  # noqa: E402

WEIGHT = 1000.0  # [N]


def make_steps(seconds=6.0):
    """Two feet in turn, 1 s each; a foot lands with 500 N, 100 N, then carries all."""
    times = figures.make_grid(seconds)

    def carry(t):
        s = t % 2.0
        if s >= 1.0:
            return 0.0
        for end, low, high in ((0.05, 0.0, 500.0), (0.12, 500.0, 100.0), (0.2, 100.0, WEIGHT)):
            begin = {0.05: 0.0, 0.12: 0.05, 0.2: 0.12}[end]
            if s < end:
                return low + (high - low) * (s - begin) / (end - begin)
        return WEIGHT
    left = [carry(t + 1.0) for t in times]
    right = [carry(t) for t in times]
    return {"time": times, "/wrench/left/force/z": left, "/wrench/right/force/z": right}


class Figures(unittest.TestCase):
    def test_a_landing_has_its_peak_and_its_dip(self):
        numbers = figures.measure(make_steps(), WEIGHT)["feet"]["left"]
        self.assertEqual(numbers["landings"], 3)
        # The grid of 5 ms meets corners of the curve within one step of it: 5.7 N/ms at the steepest.
        self.assertAlmostEqual(numbers["peak"], 500.0, delta=30.0)
        self.assertAlmostEqual(numbers["dip"], 100.0, delta=30.0)
        self.assertAlmostEqual(numbers["single_support"], WEIGHT, delta=1.0)
        self.assertAlmostEqual(numbers["swing"], 0.0, delta=1.0)

    def test_power_above_25_hz_is_that_of_the_shaking_not_of_the_steps(self):
        times = figures.make_grid(10.0)
        slow = [1000.0 * math.sin(2 * math.pi * 0.5 * t) for t in times]
        fast = [100.0 * math.sin(2 * math.pi * 60.0 * t) for t in times]
        shaking = math.sqrt(figures.calc_band_power([a + b for a, b in zip(slow, fast)]))
        # Two first-order filters let 60 Hz through by 0.9 (the bilinear rule makes tan(pi 60 / 200) of it); rms of a sine.
        self.assertAlmostEqual(shaking, 100.0 / math.sqrt(2.0), delta=12.0)
        self.assertLess(math.sqrt(figures.calc_band_power(slow)), 1.0)

    def test_a_fall_is_a_lean_beyond_sixty_degrees(self):
        times = [0.1 * k for k in range(31)]
        half = [0.5 * (0.0 if t < 1.0 else t - 1.0) for t in times]
        table = {"time": times, "/imu/trunk/orientation/w": [math.cos(a) for a in half], "/imu/trunk/orientation/x": [0.0] * 31,
                 "/imu/trunk/orientation/y": [math.sin(a) for a in half], "/imu/trunk/orientation/z": [0.0] * 31}
        figures.add_attitude(table)
        self.assertAlmostEqual(figures.find_fall(table), 1.0 + math.radians(60.0), delta=0.1)  # one sample
        self.assertAlmostEqual(table["trunk pitch"][20], 1.0, delta=1e-9)

    def test_a_recording_that_began_late_is_moved_back(self):
        times = figures.make_grid(8.0)
        joint = [math.sin(2.0 * t) * math.exp(-0.1 * t) for t in times]
        walk = {"time": times, "/joint_states/knee/position": joint}
        late = {"time": [t for t in times if t <= 6.0], "/joint_states/knee/position": joint[60:60 + 1201]}
        self.assertAlmostEqual(figures.find_shift(late, walk, 1.0), 0.3, delta=0.006)  # a step of the search

    def test_a_page_gets_the_pictures_once(self):
        import tempfile
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "report.html"
            page.write_text("<main>\n<section aria-labelledby='updated'></section></main>")
            section = walk_report.BEGIN + "<section>pictures</section>" + walk_report.END + "\n"
            walk_report.put_section(page, section)
            walk_report.put_section(page, section)
            self.assertEqual(page.read_text().count("pictures"), 1)

    def test_a_closed_loop_replays_nothing(self):
        text = "robot: r.urdf\ncontroller: {motion: motion.csv}\nsteps: {time_step: 0.001, control_period: 0.004, duration: 3}\ninterpolation: hermite\neffects:\n  - {a: b}"
        settings = "controller:\n  type: walk\n  walk:\n    left_foot: L\nsteps: {time_step: 0.001, control_period: 0.005, duration: 14}\n"
        closed = resimulate.make_closed(text, settings, {"/joint_states/knee/position": [0.25]}, 2.0)
        self.assertNotIn("motion.csv", closed)
        self.assertIn("controller:\n  type: walk\n  walk:\n    left_foot: L\n", closed)
        self.assertIn("control_period: 0.005, duration: 2}", closed)
        self.assertIn("initial: {joints: {knee: 0.25}}", closed)
        self.assertIn("effects:\n  - {a: b}\n", closed)

    def test_a_program_joins_the_domain_of_the_run(self):
        controller = closed_loop.Controller(f"{sys.executable} law.py --on={{domain}}", ".")
        self.assertEqual(controller.fill(7)[1:], ["law.py", "--on=7"])
        self.assertEqual(closed_loop.Controller(f"{sys.executable} law.py", ".").fill(7)[1:], ["law.py", "--domain", "7"])


if __name__ == "__main__":
    unittest.main()
