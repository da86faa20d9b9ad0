#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""sweep_test.py BIN SOURCE: a sweep gives the same table whoever does its runs, whatever dies, and however often it is
stopped."""
import csv
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

BIN, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
LIMIT = 240  # [s] only for what never ends
PYTHON = "/usr/bin/python3"
HAS_DASK = subprocess.run([PYTHON, "-c", "import distributed"], capture_output=True).returncode == 0

SWEEP = """
scenario: %s/models/scenarios/default.yaml
duration: 3
parameters:
  ground.friction: [0.02, 0.8]
  ground.pitch: {from: 0.0, to: 0.15, count: 3}
  variation.mass: 0.05
  servo.default.kd: {uniform: [8, 12]}
seeds: 4
""" % SOURCE


def find_children(parent):
    """Processes below one that this test has started."""
    children = []
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            words = (entry / "stat").read_text().rsplit(")", 1)[1].split()
            command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        if words[0] != "Z" and int(words[1]) == parent:
            children.append((int(entry.name), command))
    return children


class SweepTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="hrp_sweep_"))
        (cls.folder / "sweep.yaml").write_text(SWEEP)
        done = cls.start("quiet")
        assert done.wait(LIMIT) == 0, (cls.folder / "quiet.txt").read_text()
        cls.expected = (cls.folder / "quiet/table.csv").read_text()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    @classmethod
    def start(cls, out, *options):
        with open(cls.folder / (out + ".txt"), "a") as said:
            return subprocess.Popen([PYTHON, SOURCE / "scripts/sweep/main.py", cls.folder / "sweep.yaml", "--bin", BIN, "--jobs", "2",
                                     "--out", cls.folder / out, *options], stdout=said, stderr=said, cwd=cls.folder)

    def said(self, out):
        return (self.folder / (out + ".txt")).read_text()

    def kill_at_random(self, out, sweep, wanted, seed, most):
        """SIGKILL to children whose command has `wanted` in it, at random moments, until the sweep has ended."""
        source, kills, end = random.Random(seed), 0, time.monotonic() + LIMIT
        while sweep.poll() is None:
            self.assertLess(time.monotonic(), end, "the sweep does not end:\n" + self.said(out))
            time.sleep(source.uniform(0.02, 0.12))
            victims = [pid for pid, command in find_children(sweep.pid) if wanted in command]
            if not victims or kills >= most:
                continue
            try:
                os.kill(source.choice(victims), signal.SIGKILL)
                kills += 1
            except ProcessLookupError:
                pass
        return kills

    def count_results(self, out):
        journal = self.folder / out / "results.jsonl"
        return journal.read_text().count("\n") if journal.exists() else 0

    def setUp(self):
        self.sweeps = []
        self.addCleanup(lambda: [sweep.kill() for sweep in self.sweeps])

    def test_table_has_every_combination_and_what_happened(self):
        rows = list(csv.DictReader(self.expected.splitlines()))
        self.assertEqual(len(rows), 2 * 3 * 4)
        self.assertEqual({(row["ground.friction"], row["ground.pitch"], row["seed"]) for row in rows},
                         {(f, p, s) for f in ("0.02", "0.8") for p in ("0.0", "0.075", "0.15") for s in "1234"})
        self.assertEqual({row["status"] for row in rows}, {"ok"})
        # On the level all stand, on a slope of 0.15 rad none does; equal seeds draw equal values.
        self.assertEqual({row["fallen"] for row in rows if row["ground.pitch"] == "0.0"}, {"False"})
        self.assertEqual({row["fallen"] for row in rows if row["ground.pitch"] == "0.15"}, {"True"})
        self.assertEqual(len({(row["seed"], row["servo.default.kd"]) for row in rows}), 4)
        self.assertEqual(len({row["state_hash"] for row in rows}), len(rows), "seeds change the run")

    def test_a_row_is_the_run_of_the_program_itself(self):
        scenario = (SOURCE / "models/scenarios/default.yaml").read_text()
        row = next(row for row in csv.DictReader(self.expected.splitlines()) if row["ground.pitch"] == "0.0" and row["ground.friction"] == "0.8")
        scenario = scenario.replace("robot: ../", f"robot: {SOURCE}/models/").replace("duration: 12", "duration: 3")
        scenario = scenario.replace("default: {kp: 600, kd: 10}", "default: {kp: 600, kd: %s}" % row["servo.default.kd"])
        path = self.folder / "by_hand.yaml"
        path.write_text(scenario + "seed: %s\nvariation: {mass: 0.05, seed: %s}\n" % (row["seed"], row["seed"]))
        done = subprocess.run([BIN / "hrp-trial", path], capture_output=True, text=True)
        self.assertEqual(json.loads(done.stdout)["state_hash"], row["state_hash"], done.stderr)

    def test_runs_killed_at_random_are_done_again(self):
        sweep = self.start("killed")
        self.sweeps.append(sweep)
        kills = self.kill_at_random("killed", sweep, "hrp-trial", seed=1, most=12)
        self.assertEqual(sweep.returncode, 0, self.said("killed"))
        self.assertGreater(kills, 3)
        self.assertEqual((self.folder / "killed/table.csv").read_text(), self.expected)

    def test_a_sweep_that_is_killed_goes_on_where_it_was(self):
        source, done = random.Random(2), []
        for _ in range(3):
            known, sweep, end = self.count_results("resumed"), self.start("resumed"), time.monotonic() + LIMIT
            self.sweeps.append(sweep)
            while self.count_results("resumed") < known + 2:
                self.assertLess(time.monotonic(), end, self.said("resumed"))
                time.sleep(0.02)
            time.sleep(source.uniform(0.0, 0.2))
            sweep.kill()
            sweep.wait()
        with open(self.folder / "resumed/results.jsonl", "a") as journal:
            journal.write('{"key": "cut off in the mid')
        self.assertEqual(self.start("resumed").wait(LIMIT), 0, self.said("resumed"))
        for line in self.said("resumed").splitlines():
            if "done before" in line:
                done.append(int(line.split()[-3]))
        self.assertEqual(done, sorted(done), "no run is done twice")
        self.assertGreater(done[-1], 0)
        self.assertEqual((self.folder / "resumed/table.csv").read_text(), self.expected)

    @unittest.skipUnless(HAS_DASK, "NOT TESTED: no python3-distributed on this machine")
    def test_a_cluster_whose_workers_are_killed_gives_the_same_table(self):
        sweep = self.start("cluster", "--cluster", "local")
        self.sweeps.append(sweep)
        end = time.monotonic() + LIMIT  # a cluster is there once it has given a first result
        while sweep.poll() is None and not self.count_results("cluster"):
            self.assertLess(time.monotonic(), end, self.said("cluster"))
            time.sleep(0.05)
        kills = self.kill_at_random("cluster", sweep, "multiprocessing.spawn", seed=3, most=3)
        self.assertEqual(sweep.returncode, 0, self.said("cluster"))
        self.assertGreater(kills, 0)
        self.assertEqual((self.folder / "cluster/table.csv").read_text(), self.expected)

    def test_as_many_runs_at_a_time_as_cores_that_the_process_may_use(self):
        asked = [PYTHON, "-c", "import os, workers; os.sched_setaffinity(0, [min(os.sched_getaffinity(0))]); print(workers.count_cores())"]
        self.assertEqual(subprocess.check_output(asked, cwd=SOURCE / "scripts/sweep", text=True), "1\n")

    def test_page_plots_every_parameter(self):
        page = (self.folder / "quiet/report.html").read_text()
        for name in ("ground.friction", "ground.pitch", "servo.default.kd"):
            self.assertIn(f">{name}</text>", page)
        self.assertEqual(page.count("<svg"), 6)  # three curves, three maps


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[3:]])
