# SPDX-License-Identifier: BSD-3-Clause
"""A diagnosed walk is walked again with the controller in the loop: the model with soft soles, which walked, repeats the
recording, the rigid one does not; and what is said of controllers that are not there, die or are silent.
Run as: closed_loop_test.py BIN_DIR SOURCE_DIR"""
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 2 else ".").resolve()
BIN = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else "build/bin")
sys.path.insert(0, str(SOURCE / "scripts" / "diagnosis"))
import closed_loop  # noqa: E402

SECONDS = 3.6  # the weight is shifted, one foot swings and lands
CUT = 0.4      # [s] of the recording that its logger missed at the beginning


def call(*words, expected=0):
    run = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=120)
    if run.returncode != expected:
        raise AssertionError(f"{words}: status {run.returncode}\n{run.stdout}{run.stderr}")
    return run.stdout + run.stderr


def resimulate(out, *options, expected=0):
    return call(sys.executable, SOURCE / "scripts" / "diagnosis" / "resimulate.py", BIN, out, "servers", *options, expected=expected)


class ClosedLoop(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """A walk on soft soles, recorded, and what a diagnosis would have written about it."""
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = folder = pathlib.Path(cls.temporary.name)
        text = (SOURCE / "models" / "scenarios" / "paper_a" / "fig7.yaml").read_text()
        text = re.sub(r"(?m)^robot: .*", f"robot: {SOURCE}/models/hrp1s_like/hrp1s_like.urdf", text)
        text = text.replace("duration: 14", f"duration: {SECONDS}")
        cls.scenario = folder / "walk.yaml"
        cls.scenario.write_text(text)
        call(BIN / "hrp-simulate", cls.scenario, "--in-process", "--no-plot", "--quiet", "--log", folder / "walk.mcap")
        call(BIN / "hrp-log", "csv", folder / "walk.mcap", "--out", folder / "whole.csv")
        lines = (folder / "whole.csv").read_text().splitlines()
        kept = [line for line in lines[1:] if float(line.split(",", 1)[0]) >= CUT]
        (folder / "walk.csv").write_text("\n".join(lines[:1] + kept) + "\n")
        (folder / "updated").mkdir()
        updated = text[:text.index("controller:")] + "controller: {type: hold}\n"
        (folder / "updated" / "scenario.yaml").write_text(updated)
        (folder / "updated" / "nominal.yaml").write_text(re.sub(r"foot_bush:\n.*\n", "", updated))
        (folder / "series.json").write_text(json.dumps({"updated": {"replays": str(folder / "walk.csv")}}))
        (folder / "report.json").write_text('{"verdict": "explained"}')
        (folder / "report.html").write_text("<main></main>")

    def test_the_model_that_walked_walks_the_recording_again_and_the_rigid_one_does_not(self):
        said = resimulate(self.folder, "--controller", self.scenario)
        result = json.loads((self.folder / "report.json").read_text())["resimulated"]
        self.assertEqual(result["loop"], "closed loop")
        self.assertAlmostEqual(result["shift"], CUT, delta=0.006)  # the search's step
        force = [d for d in result["walk"]["differences"] if d["kind"] == "vertical force"]
        self.assertEqual(len(force), 2)
        for difference in force:
            # The same model and the same controller: what remains is the table's digits.
            self.assertLess(difference["updated"], 1.0)
            self.assertGreater(difference["nominal"], 10.0)
        self.assertIsNone(result["walk"]["numbers"]["updated"]["fall"])
        self.assertGreater(result["walk"]["numbers"]["updated"]["feet"]["left_foot"]["single_support"], 1100.0)
        self.assertIn("plateau, single support", said)
        page = (self.folder / "report.html").read_text()
        self.assertEqual(page.count("<svg"), 8)  # two forces, roll, pitch, two torques each
        self.assertIn("curve before", page)

    def test_a_program_that_is_not_there_is_named(self):
        said = resimulate(self.folder, "--controller", "no-such-law --gain 3", expected=2)
        self.assertIn("no program no-such-law", said)

    def test_a_scenario_that_is_not_there_is_named(self):
        self.assertIn("no file gone.yaml", resimulate(self.folder, "--controller", "gone.yaml", expected=2))

    def test_our_controller_wants_to_know_how_to_walk(self):
        said = resimulate(self.folder, "--controller", "hrp-controller", expected=2)
        self.assertIn("no section `controller:`", said)

    def test_a_program_that_dies_is_told_with_its_status_and_last_words(self):
        law = "import sys; print('out of oil', flush=True); sys.exit(3)"
        said = resimulate(self.folder, "--controller", f"{sys.executable} -c {shlex.quote(law)} {{domain}}", expected=2)
        self.assertIn("ended with status 3 at t = 0.000 s", said)
        self.assertIn("out of oil", said)

    def test_a_program_that_never_answers_is_told(self):
        law = "import time; time.sleep(600)"
        said = resimulate(self.folder, "--wait", "2", "--controller", f"{sys.executable} -c {shlex.quote(law)} {{domain}}", expected=2)
        self.assertIn("never answered", said)
        self.assertIn("hrp/sensor_data", said)

    def test_a_set_that_closes_its_log_after_the_controller_has_gone_has_run_to_its_end(self):
        """As on a busy machine: the controller heard of the end two seconds before hrp-simulate ended."""
        programs = self.folder / "busy"
        programs.mkdir()
        for name, does in (("hrp-simulate", "echo 'the place of controller is free, on DDS domain 3'; sleep 2.5"),
                           ("hrp-run", "echo 'step 100 t = 0.5'")):
            (programs / name).write_text(f"#!/bin/sh\n{does}\n")
            (programs / name).chmod(0o755)
        controller = closed_loop.Controller("true {domain}", programs)
        status, _ = closed_loop.run(programs, self.scenario, self.folder / "busy.mcap", controller, 10.0)
        self.assertEqual(status, 0)


if __name__ == "__main__":
    unittest.main()
