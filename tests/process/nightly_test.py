#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""nightly_test.py BIN ROOT: scripts/nightly.sh reports steps that find something, cannot run or do not end."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv.pop()).resolve()
BIN = pathlib.Path(sys.argv.pop()).resolve()
sys.path.insert(0, str(ROOT / "scripts/robustness"))
import attack  # noqa: E402
import nightly  # noqa: E402

# Stands for hrp-simulate: counts how often it is called, and ends with a hash.
# A line a call: runs side by side add theirs at the same time.
SIMULATE = '#!/bin/sh\necho called >> "{0}/calls"\ncalls=$(wc -l < "{0}/calls")\n{1}\n'
SAME = "echo state hash 17"
CHANGES = "echo state hash $calls"
# Stands for hrp-log: every log is whole.
LOG = f"#!/bin/sh\necho hrp/robot_state RobotState 1 cdr 0 {round(attack.DURATION / attack.STEP)}\n"


class Nightly(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def make_programs(self, script):
        (self.folder / "bin").mkdir(exist_ok=True)
        for name, text in (("hrp-simulate", SIMULATE.format(self.folder, script)), ("hrp-log", LOG)):
            program = self.folder / "bin" / name
            program.write_text(text)
            program.chmod(0o755)

    def run_nightly(self, *options, build=None):
        run = subprocess.run([ROOT / "scripts/nightly.sh", "--out", self.folder / "out", "--tries", "1", *options], capture_output=True,
                             text=True, timeout=200, env={**os.environ, "HRP_BUILD_DIR": str(build or self.folder)})
        store = self.folder / "out/results.json"
        return run, json.loads(store.read_text()) if store.is_file() else {}

    def count_calls(self):
        return len((self.folder / "calls").read_text().splitlines())

    def test_a_good_build_survives_one_of_each_kill(self):
        run, results = self.run_nightly("--only", "kills", build=BIN.parent)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertRegex(run.stdout, r"\| kills \| ok \| 5 \| 0 \|")
        self.assertIn("| launcher | 1 | 0 |", pathlib.Path(results["kills"]["log"]).read_text())

    def test_a_run_that_ends_otherwise_is_a_finding(self):
        self.make_programs(CHANGES)
        run, results = self.run_nightly("--only", "kills")
        self.assertEqual(run.returncode, 1, run.stdout)
        # Nobody asks a run whose launcher died for its hash.
        self.assertRegex(run.stdout, r"\| kills \| finding \| 5 \| 4 \|")
        self.assertIn("kills: finding, see", run.stderr)
        self.assertIn("another hash", pathlib.Path(results["kills"]["log"]).read_text())

    def test_a_step_that_cannot_run_fails_and_the_next_one_is_still_done(self):
        self.make_programs("echo no robot >&2; exit 1")
        run, results = self.run_nightly("--only", "kills,soak")
        self.assertEqual(run.returncode, 1, run.stdout)
        self.assertEqual([results[name]["result"] for name in ("kills", "soak")], ["could not run"] * 2)
        self.assertIn("no robot", run.stderr)

    def test_a_step_that_does_not_end_is_ended_with_its_children(self):
        self.make_programs('echo $$ > "%s/process"; exec sleep 1000' % self.folder)
        # 9 s are enough for two shells and Python to start on a busy machine; attack.sh alone would wait for 90 s.
        run, results = self.run_nightly("--only", "kills", "--limit", "0.15")
        self.assertEqual((run.returncode, results["kills"]["result"]), (1, "did not end"))
        self.assertFalse(pathlib.Path("/proc", (self.folder / "process").read_text().strip(), "exe").exists())

    def test_what_went_well_is_not_done_again(self):
        self.make_programs(SAME)
        self.assertEqual(self.run_nightly("--only", "kills")[0].returncode, 0)
        calls = self.count_calls()
        run, _ = self.run_nightly("--only", "kills", "--resume")
        self.assertIn("| kills | ok | 5 | 0 |", run.stdout)
        self.assertEqual(self.count_calls(), calls)
        self.run_nightly("--only", "kills")
        self.assertGreater(self.count_calls(), calls)

    def test_an_unknown_step_is_refused_with_the_names_of_all(self):
        run, _ = self.run_nightly("--only", "kils")
        self.assertEqual(run.returncode, 2)
        self.assertIn("there is no step kils: fuzz, kills, faults, soak, sanitize, threads, tidy, long, mutations", run.stderr)


class Counts(unittest.TestCase):
    """What each script prints, read into tries and failures."""

    def test_fuzz_counts_a_target_that_ended_early(self):
        text = "| target | executions | seconds | inputs kept | finding |\n|---|---|---|---|---|\n"
        text += "| cdr | 1000 | 3 | 20 | none |\n| csv |  |  | 4 | see csv.log |\n"
        self.assertEqual(nightly.count_fuzz(text), (1000, 1))

    def test_soak_counts_servers_that_grow(self):
        text = "| program | memory, middle third | last third | threads | open files |\n|---|---|---|---|---|\n"
        text += "| hrp-logger | 20.0 MB | 30.0 MB grows | 4, 4 | 9, 9 |\n| hrp-dynamics | 20.0 MB | 20.0 MB | 4, 4 | 9, 9 |\n"
        self.assertEqual(nightly.count_soak(text), (1, 1))

    def test_sanitized_tests_count_as_ctest_does(self):
        self.assertEqual(nightly.count_tests("67% tests passed, 1 tests failed out of 3\n"), (3, 1))

    def test_a_mutation_that_passes_its_test_is_a_failure(self):
        text = "H03 eq. 1          fails          a.cpp: x -> y\nH03 eq. 2          passes         b.cpp: x -> y\n"
        self.assertEqual(nightly.count_mutations(text), (2, 1))


if __name__ == "__main__":
    unittest.main()
