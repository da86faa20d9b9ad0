# SPDX-License-Identifier: BSD-3-Clause
"""hrp-diagnose where its results cannot go, or are cut short: exit status, words, and no half of a file. Run as:
output_places_test.py BIN_DIR."""
import json
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import unittest

from pendulum_experiment import URDF, YAML, ROWS, make_csv

BIN = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else "build/bin")


class Places(unittest.TestCase):
    """Where results cannot go."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        for name, text in {**{name: make_csv(rows) for name, rows in ROWS.items()}, "experiment.yaml": YAML, "robot.urdf": URDF}.items():
            (self.root / name).write_text(text)

    def tearDown(self):
        self.folder.cleanup()

    def run_tool(self, out, *options, **arguments):
        run = subprocess.run([BIN / "hrp-diagnose", self.root, "--out", out, *options], capture_output=True, text=True, timeout=110, **arguments)
        return run.returncode, run.stderr

    def test_a_place_that_cannot_be_written_is_refused_before_the_work(self):
        (self.root / "file").write_text("mine")
        for out, words in ((self.root / "file", "cannot be made"), ("/proc/none", "cannot be made"), ("/proc/self", "nothing can be written in it"),
                           (self.root / ("y" * 300), "File name too long")):
            status, text = self.run_tool(out)
            self.assertEqual(status, 2, text)
            self.assertRegex(text, f"{out}: error: .*{words}")
            self.assertNotIn(" s  ", text, "something was computed first")
        self.assertEqual((self.root / "file").read_text(), "mine")

    def test_a_limit_that_nobody_can_mean_is_refused_before_the_work(self):
        limits = self.root / "limits.yaml"
        limits.write_text("joints:\n  one: {speed: fast}\n")
        for limit, words in (("speed=nan", "speed=nan: expected"), ("speed=5cm", "speed=5cm: expected"), ("ground=inf", "ground=inf: expected"),
                             ("two.speed=1", "has no joint two"), (limits, "limits.yaml:2")):
            status, text = self.run_tool(self.root / "out", "--next", "--limit", limit)
            self.assertEqual(status, 2, text)
            self.assertIn(words, text)
            self.assertNotIn(" s  ", text, "something was computed first")

    @staticmethod
    def make_limit(size):  # no file may become larger, as on a full disk
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        return limit

    def test_a_full_disk_is_refused_before_the_work(self):
        status, text = self.run_tool(self.root / "out", preexec_fn=self.make_limit(4000))
        self.assertEqual(status, 2, text)
        self.assertRegex(text, "out: error: nothing can be written in it: .*: File too large")
        self.assertNotIn(" s  ", text, "something was computed first")

    def test_a_full_standard_output_is_named(self):
        for words in (["--check"], ["--out", self.root / "out", "--quiet"]):
            with open("/dev/full", "w") as full:
                run = subprocess.run([BIN / "hrp-diagnose", self.root, *words], stdout=full, stderr=subprocess.PIPE, text=True, timeout=110)
            self.assertEqual((run.returncode, run.stderr), (1, "hrp-diagnose: standard output cannot be written: No space left on device\n"))

    def test_a_disk_that_is_full_by_then_is_named_and_leaves_no_half_of_a_file(self):
        status, text = self.run_tool(self.root / "out", preexec_fn=self.make_limit(40000))
        self.assertEqual(status, 1, text)
        self.assertRegex(text, r"out/\S+: cannot be written: File too large")
        self.assertEqual(list((self.root / "out").rglob("*.part")), [])
        for file in (self.root / "out").rglob("*.json"):
            json.loads(file.read_text())

    def test_what_was_killed_leaves_whole_files_and_can_be_run_again(self):
        for delay in (0.02, 0.05, 0.1, 0.15, 0.2, 0.3):
            process = subprocess.Popen([BIN / "hrp-diagnose", self.root, "--out", self.root / "out", "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                process.wait(delay)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            for file in (self.root / "out").rglob("*.json"):
                json.loads(file.read_text())
        status, text = self.run_tool(self.root / "out")
        self.assertEqual(status, 0, text)


if __name__ == "__main__":
    if not (BIN / "hrp-diagnose").exists():
        sys.exit(f"{BIN}/hrp-diagnose is not built: nothing to test")
    unittest.main()
