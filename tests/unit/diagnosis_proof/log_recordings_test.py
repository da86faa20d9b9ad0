# SPDX-License-Identifier: BSD-3-Clause
"""Logs of our own runs as recordings: the same run as MCAP and as CSV gets the same verdict, and the updated scenario
that comes out of it runs as it is. Run as: log_recordings_test.py BIN_DIR SOURCE_DIR"""
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 2 else ".")
BIN = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else "build/bin")
SERVO = "servo:\n  joints: {JOINT: {kp: 200, kd: 8, effort_limit: 60}}\n"
TRUTH = 0.9  # [N m s/rad]


def call(*words, expected=0):
    run = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=120)
    if run.returncode != expected:
        raise AssertionError(f"{words}: status {run.returncode}\n{run.stdout}{run.stderr}")
    return run.stdout + run.stderr


def write_motion(path, joint, phase, seconds=3.0):
    rows = ["time," + joint]
    for k in range(int(seconds * 100) + 1):
        t = k / 100
        fade = min(1.0, t) ** 3 * (10 - 15 * min(1.0, t) + 6 * min(1.0, t) ** 2)
        rows.append("%.2f,%.9f" % (t, fade * (0.5 * math.sin(4 * t + phase) + 0.25 * math.sin(9 * t))))
    path.write_text("\n".join(rows) + "\n")


class Logs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Two runs of a pendulum with viscous friction, logged; an experiment without it."""
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = folder = pathlib.Path(cls.temporary.name)
        urdf = (SOURCE / "models" / "test_robots" / "pendulum.urdf").read_text()
        cls.joint = joint = re.search(r'<joint name="([^"]+)" type="(?:revolute|continuous)"', urdf)[1]
        (folder / "robot.urdf").write_text(urdf)
        head = "robot: robot.urdf\nbase: fixed\n" + SERVO.replace("JOINT", joint)
        for name, phase in (("train", 0.3), ("validate", 1.9)):
            write_motion(folder / f"{name}_motion.csv", joint, phase)
            (folder / f"{name}.yaml").write_text(
                head + f"joint_laws: {{{joint}: {{viscous_friction: {{coefficient: {TRUTH}}}}}}}\n"
                "sensors: {encoders: {position_noise: 2.0e-5, velocity_noise: 2.0e-3, effort_noise: 0.02}}\n"
                "steps: {time_step: 0.0005, control_period: 0.004, duration: 3}\ninterpolation: hermite\n"
                f"controller: {{motion: {name}_motion.csv}}\n")
            call(BIN / "hrp-simulate", folder / f"{name}.yaml", "--in-process", "--no-plot", "--quiet", "--force", "--log", folder / f"{name}.mcap")
            call(BIN / "hrp-log", "csv", folder / f"{name}.mcap", "--out", folder / f"{name}.csv")
        cls.report = {}
        for kind in ("mcap", "csv"):
            (folder / f"{kind}.yaml").write_text(head + f"recordings:\n  - {{file: train.{kind}, role: train}}\n"
                                                 f"  - {{file: validate.{kind}, role: validate}}\n")
            call(BIN / "hrp-diagnose", folder / f"{kind}.yaml", "--out", folder / kind, "--jobs", 1)
            cls.report[kind] = json.loads((folder / kind / "report.json").read_text().replace("." + kind, ""))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_friction_of_a_logged_run_is_found(self):
        findings = self.report["mcap"]["findings"]
        self.assertEqual([f["effect"] for f in findings], ["viscous_friction"], self.report["mcap"])
        # The design's bar for a parameter.
        self.assertAlmostEqual(findings[0]["parameters"]["coefficient"]["value"], TRUTH, delta=0.05 * TRUTH)

    def test_the_same_run_as_mcap_and_as_csv_gets_the_same_report(self):
        self.assertEqual(self.report["mcap"], self.report["csv"])

    def test_a_log_that_is_none_is_named(self):
        (self.folder / "broken.mcap").write_bytes(b"no log")
        (self.folder / "broken.yaml").write_text((self.folder / "mcap.yaml").read_text().replace("train.mcap", "broken.mcap"))
        self.assertIn("broken.mcap", call(BIN / "hrp-diagnose", self.folder / "broken.yaml", "--out", self.folder / "no", expected=2))

    def answer_log(self, name, content):
        """Exit status and words of the tool when the training log holds `content`."""
        (self.folder / f"{name}.mcap").write_bytes(content)
        text = (self.folder / "mcap.yaml").read_text().replace("train.mcap", f"{name}.mcap")
        (self.folder / f"{name}.yaml").write_text(text)
        run = subprocess.run([str(BIN / "hrp-diagnose"), str(self.folder / f"{name}.yaml"), "--out", str(self.folder / name)],
                             capture_output=True, text=True, timeout=120)
        return run.returncode, run.stdout + run.stderr

    def test_a_log_that_ends_early_is_answered_or_named(self):
        content = (self.folder / "train.mcap").read_bytes()
        for share in (0.9, 0.5, 0.2, 0.15, 0.1, 0.05):
            status, words = self.answer_log("cut", content[:int(share * len(content))])
            self.assertIn(status, (0, 2), words)
            if status == 2:
                self.assertIn("cut.mcap", words)

    def test_a_log_with_damaged_bytes_is_answered_or_named(self):
        content = bytearray((self.folder / "train.mcap").read_bytes())
        for at in range(len(content) // 3, len(content) // 3 + 4000):
            content[at] ^= 0x5a
        status, words = self.answer_log("damaged", bytes(content))
        self.assertIn(status, (0, 2), words)
        if status == 2:
            self.assertIn("damaged.mcap", words)

    def test_the_server_set_and_one_process_come_equally_near_the_recording(self):
        again = {}
        for way in ("servers", "process"):
            call(sys.executable, SOURCE / "scripts" / "diagnosis" / "resimulate.py", BIN.resolve(), self.folder / "csv", way)
            again[way] = json.loads((self.folder / "csv" / "resimulated.json").read_text())["per_signal"]
        self.assertEqual(again["servers"], again["process"])
        error = again["servers"][f"/joint_states/{self.joint}/position"]
        # The friction is found within 5 %: as much of what it did to the motion may stay.
        self.assertLess(error["after"], 0.05 * error["before"])

    def test_the_updated_scenario_runs_as_it_is_and_repeats_the_recording(self):
        updated = self.folder / "mcap" / "updated" / "scenario.yaml"
        self.assertIn("effects:", updated.read_text())
        log = self.folder / "again.mcap"
        call(BIN / "hrp-simulate", updated, "--in-process", "--no-plot", "--quiet", "--force", "--log", log)
        call(BIN / "hrp-log", "csv", log, "--out", self.folder / "again.csv")

        def position(name):
            lines = (self.folder / name).read_text().split("\n")
            column = lines[0].split(",").index(f"/joint_states/{self.joint}/position")
            return [float(line.split(",")[column]) for line in lines[1:] if line]
        pairs = list(zip(position("validate.csv"), position("again.csv")))
        self.assertGreater(len(pairs), 700)
        # Encoder noise is 2e-5 rad; a thousandth of the swing is what the friction's own error would leave at most.
        self.assertLess(max(abs(a - b) for a, b in pairs), 1e-3)


if __name__ == "__main__":
    for program in ("hrp-diagnose", "hrp-simulate", "hrp-log"):
        if not (BIN / program).exists():
            sys.exit(f"{BIN}/{program} is not built: nothing to test")
    unittest.main()
