# SPDX-License-Identifier: BSD-3-Clause
"""hrp-diagnose on broken experiments: exit status 2 with file, line and column, or a verdict; never a crash, never a
status of its own. Run as: malformed_experiment_test.py BIN_DIR. Makes its experiments itself (a pendulum by explicit
steps), so that no other program is needed."""
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else "build/bin")
URDF = """<?xml version="1.0"?>
<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/><inertia ixx="0.03" iyy="0.03" izz="0.005" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="one" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
</robot>
"""
YAML = """robot: robot.urdf
base: fixed
servo:
  joints:
    one: {kp: 200, kd: 8, effort_limit: 50}
initial:
  joints: {one: 0}
recordings:
  - {file: train_1.csv, role: train}
  - {file: validate_1.csv, role: validate}
"""
HEAD = ["time", "/joint_commands/one/position", "/joint_commands/one/velocity", "/joint_states/one/position",
        "/joint_states/one/velocity", "/joint_states/one/effort"]


DEG = 57.29578


def make_rows(phase, seconds=2.0, step=0.004, kp=200, kd=8, pace=3.0):
    """A servoed pendulum, semi-implicit steps of 0.1 ms, with a ripple of 1e-5 in place of noise."""
    inertia, moment = 0.03 + 2 * 0.2 * 0.2, 2 * 9.81 * 0.2
    q = v = t = 0.0
    rows = []
    for k in range(int(seconds / step)):
        w = 1e-5 * math.sin(1e4 * (k * 0.37 + phase) ** 2)
        c, cd = 0.4 * math.sin(pace * t + phase) - 0.4 * math.sin(phase), 0.4 * pace * math.cos(pace * t + phase)
        effort = kp * (c - q) + kd * (cd - v)
        rows.append([t, c, cd, q + w, v + 100 * w, effort + 500 * w])
        for _ in range(int(step / 1e-4)):
            c, cd = 0.4 * math.sin(pace * t + phase) - 0.4 * math.sin(phase), 0.4 * pace * math.cos(pace * t + phase)
            v += 1e-4 * (kp * (c - q) + kd * (cd - v) - moment * math.sin(q)) / inertia
            q += 1e-4 * v
            t += 1e-4
    return rows


ROWS = {"train_1.csv": make_rows(0.3), "validate_1.csv": make_rows(1.7)}
ROWS_TWO = {"train_1.csv": make_rows(0.9, kp=120, kd=5, pace=4.1), "validate_1.csv": make_rows(2.6, kp=120, kd=5, pace=4.1)}
URDF_TWO = URDF.replace("</robot>", "").replace('"upper"', '"first"') + re.sub("\"one\"", "\"two\"", URDF[URDF.index('  <link name="upper"'):]).replace('"upper"', '"second"')
YAML_TWO = YAML.replace("    one: {kp: 200, kd: 8, effort_limit: 50}", "    one: {kp: 200, kd: 8, effort_limit: 50}\n    two: {kp: 120, kd: 5, effort_limit: 50}")


def make_csv(rows, head=HEAD):
    return "\n".join([",".join(head)] + [",".join(f"{x:.9g}" if isinstance(x, float) else str(x) for x in r) for r in rows]) + "\n"


class Malformed(unittest.TestCase):
    def run_tool(self, change=None, yaml=YAML, urdf=URDF):
        """change(files) edits a dictionary file name -> text. Returns status, terminal text, report text."""
        files = {name: make_csv(rows) for name, rows in ROWS.items()}
        files.update({"experiment.yaml": yaml, "robot.urdf": urdf})
        if change:
            change(files)
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                (pathlib.Path(folder) / name).write_bytes(text if isinstance(text, bytes) else text.encode())
            run = subprocess.run([BIN / "hrp-diagnose", f"{folder}/experiment.yaml", "--out", f"{folder}/out"], capture_output=True, text=True, timeout=110)
            report = pathlib.Path(folder, "out", "report.json")
            return run.returncode, run.stdout + run.stderr, report.read_text() if report.exists() else ""

    def refused(self, *words, **arguments):
        status, text, _ = self.run_tool(**arguments)
        self.assertEqual(status, 2, text)
        for word in words:
            self.assertRegex(text, word)

    def answered(self, **arguments):
        """A verdict, or a refusal that names file and line: which of the two is the tool's choice."""
        status, text, report = self.run_tool(**arguments)
        self.assertIn(status, (0, 2), text)
        if status == 2:
            self.assertRegex(text, r"\.(csv|yaml|urdf):\d+")
        else:
            self.assertIn('"verdict"', report)
        return status, text, report

    def test_a_sound_experiment_is_answered(self):
        self.assertEqual(self.run_tool()[0], 0)

    def test_a_missing_recording_is_named(self):
        self.refused("train_1.csv", change=lambda f: f.pop("train_1.csv"))

    def test_an_empty_recording_is_named(self):
        self.refused("train_1.csv", change=lambda f: f.update({"train_1.csv": ""}))

    def test_a_header_without_rows_is_named(self):
        self.refused("train_1.csv", change=lambda f: f.update({"train_1.csv": ",".join(HEAD) + "\n"}))

    def test_a_missing_time_column_is_named(self):
        self.refused("train_1.csv:1", "time", change=lambda f: f.update({"train_1.csv": f["train_1.csv"].replace("time,", "clock,", 1)}))

    def test_text_among_numbers_is_named_with_line_and_column(self):
        def change(f):
            lines = f["train_1.csv"].split("\n")
            lines[7] = lines[7].replace(",", ",oops", 1)
            f["train_1.csv"] = "\n".join(lines)
        self.refused(r"train_1.csv:8:2:", change=change)

    def test_an_empty_cell_is_named_with_line_and_column(self):
        def change(f):
            lines = f["train_1.csv"].split("\n")
            cells = lines[7].split(",")
            cells[3] = ""
            lines[7] = ",".join(cells)
            f["train_1.csv"] = "\n".join(lines)
        status, text, _ = self.answered(change=change)
        self.assertRegex(text, r"train_1.csv:8:4: warning: /joint_states/one/position: no number here")

    def test_a_folder_stands_for_the_experiment_in_it(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "experiment.yaml").write_text(YAML)
            pathlib.Path(folder, "robot.urdf").write_text(URDF)
            run = subprocess.run([BIN / "hrp-diagnose", folder, "--out", f"{folder}/out"], capture_output=True, text=True, timeout=110)
            self.assertEqual(run.returncode, 2)
            self.assertIn("train_1.csv", run.stderr, "read as far as the recordings, which are not there")

    def test_a_missing_joint_column_is_named(self):
        def change(f):
            for name in ("train_1.csv", "validate_1.csv"):
                f[name] = f[name].replace("/joint_states/one/position", "/joint_states/one/pos", 1)
        _, text, _ = self.answered(change=change)
        self.assertRegex(text, r"train_1.csv has no column /joint_states/one/position")

    def test_time_that_runs_backwards_is_named(self):
        def change(f):
            lines = f["train_1.csv"].split("\n")
            lines[20], lines[21] = lines[21], lines[20]
            f["train_1.csv"] = "\n".join(lines)
        self.refused(r"train_1.csv:2[12]", "time", change=change)

    def test_a_truncated_recording_is_answered(self):
        self.answered(change=lambda f: f.update({"train_1.csv": f["train_1.csv"][: len(f["train_1.csv"]) // 2 + 7]}))

    def test_cells_of_nan_are_answered(self):
        rows = [[x if k % 17 else float("nan") if i == 3 else x for i, x in enumerate(r)] for k, r in enumerate(ROWS["train_1.csv"])]
        self.answered(change=lambda f: f.update({"train_1.csv": make_csv(rows)}))

    def test_a_column_of_nan_is_answered(self):
        rows = [r[:5] + [float("nan")] for r in ROWS["train_1.csv"]]
        self.answered(change=lambda f: f.update({"train_1.csv": make_csv(rows)}))

    def test_a_constant_column_is_answered(self):
        rows = [r[:3] + [0.0] + r[4:] for r in ROWS["train_1.csv"]]
        self.answered(change=lambda f: f.update({"train_1.csv": make_csv(rows)}))

    def test_no_effort_or_velocity_is_answered(self):
        self.answered(change=lambda f: f.update({n: make_csv([r[:4] for r in ROWS[n]], HEAD[:4]) for n in ROWS}))

    def scaled(self, *factors):
        """Every column times its factor."""
        return lambda f: f.update({n: make_csv([[x * k for x, k in zip(r, factors)] for r in ROWS[n]]) for n in ROWS})

    def test_positions_in_degrees_are_suspected_with_their_column(self):
        self.refused(r"train_1.csv:1:4:", "degrees", change=self.scaled(1, 1, 1, DEG, DEG, 1))

    def test_commands_in_degrees_are_suspected(self):
        self.refused(r"train_1.csv:1:4:", "command in degrees", change=self.scaled(1, DEG, DEG, 1, 1, 1))

    def test_degrees_everywhere_are_suspected_from_the_effort(self):
        self.refused(r"train_1.csv:1:", "degrees", change=self.scaled(1, DEG, DEG, DEG, DEG, 1))

    def test_a_velocity_in_degrees_is_suspected(self):
        self.refused(r"train_1.csv:1:5:", "degrees", change=self.scaled(1, 1, 1, 1, DEG, 1))

    def test_an_effort_in_millinewtonmetres_is_suspected(self):
        self.refused(r"train_1.csv:1:6:", "mN m", change=self.scaled(1, 1, 1, 1, 1, 1000))

    def test_an_effort_of_the_other_sign_is_suspected(self):
        self.refused(r"train_1.csv:1:6:", "sign", change=self.scaled(1, 1, 1, 1, 1, -1))

    def test_a_missing_command_is_named(self):
        self.refused("train_1.csv", "/joint_commands/one/position", "missing",
                     change=lambda f: f.update({n: make_csv([r[:1] + r[3:] for r in ROWS[n]], HEAD[:1] + HEAD[3:]) for n in ROWS}))

    def test_an_encoder_that_stands_still_is_named(self):
        rows = [r[:3] + [0.1] + r[4:] for r in ROWS["train_1.csv"]]
        self.refused(r"train_1.csv:1:4:", "throughout", change=lambda f: f.update({"train_1.csv": make_csv(rows)}))

    def test_an_effort_that_is_always_zero_is_taken_as_not_recorded(self):
        rows = {n: make_csv([r[:5] + [0.0] for r in ROWS[n]]) for n in ROWS}
        status, text, _ = self.run_tool(change=lambda f: f.update(rows))
        self.assertEqual(status, 0, text)
        self.assertIn("taken as not recorded", text)

    def test_repeated_stamps_are_dropped_and_counted(self):
        rows = [r for k, r in enumerate(ROWS["train_1.csv"]) for _ in range(2 if k % 50 == 0 else 1)]
        status, text, _ = self.run_tool(change=lambda f: f.update({"train_1.csv": make_csv(rows)}))
        self.assertEqual(status, 0, text)
        self.assertIn("repeat the last time stamp", text)

    def two(self, order, yaml=None):
        """A robot of two pendulums whose recorded columns are those of `order` under the header's names."""
        def change(f):
            for n in ROWS:
                table = [a + b[1:] for a, b in zip(ROWS[n], ROWS_TWO[n])]
                f[n] = make_csv([[r[i] for i in order] for r in table], HEAD + [h.replace("/one/", "/two/") for h in HEAD[1:]])
        return {"change": change, "urdf": URDF_TWO, "yaml": yaml or YAML_TWO}

    def test_positions_of_two_joints_exchanged_are_suspected(self):
        self.refused(r"train_1.csv:1:4:", "of joint two rather than its own", "exchanged", **self.two([0, 1, 2, 8, 4, 5, 6, 7, 3, 9, 10]))

    def test_velocities_of_two_joints_exchanged_are_suspected(self):
        self.refused(r"train_1.csv:1:5:", "exchanged", **self.two([0, 1, 2, 3, 9, 5, 6, 7, 8, 4, 10]))

    def test_two_joints_exchanged_altogether_are_suspected_from_their_gains(self):
        self.refused(r"train_1.csv:1:6:", "gains of joint two", "exchanged", **self.two([0, 6, 7, 8, 9, 10, 1, 2, 3, 4, 5]))

    def test_milliseconds_are_not_taken_for_seconds_silently(self):
        status, text, report = self.answered(change=lambda f: f.update({n: make_csv([[1000 * r[0]] + r[1:] for r in ROWS[n]]) for n in ROWS}))
        self.assertFalse(status == 0 and '"no_mismatch"' in report, text)

    def test_a_joint_of_another_robot_is_named(self):
        self.refused("train_1.csv:1", "won", change=lambda f: f.update({"train_1.csv": f["train_1.csv"].replace("/one/", "/won/")}))

    def test_bad_yaml_is_named_with_its_line(self):
        self.refused(r"experiment.yaml:\d+", yaml=YAML.replace("base: fixed", "base: [fixed"))

    def test_an_unknown_role_is_named(self):
        self.refused(r"experiment.yaml:\d+", "role", yaml=YAML.replace("role: validate", "role: exam"))

    def test_an_unknown_base_is_named(self):
        self.refused(r"experiment.yaml:2", "base", yaml=YAML.replace("base: fixed", "base: hovering"))

    def test_a_negative_gain_is_named(self):
        self.refused(r"experiment.yaml:5", "kp", yaml=YAML.replace("kp: 200", "kp: -200"))

    def test_a_missing_robot_is_named(self):
        self.refused("nobody.urdf", yaml=YAML.replace("robot.urdf", "nobody.urdf"))

    def test_a_broken_urdf_is_named(self):
        self.refused("robot.urdf", urdf=URDF[:200])

    def test_no_recordings_at_all_are_named(self):
        self.refused("experiment.yaml", "recordings", yaml=YAML.split("recordings")[0])

    def test_bytes_of_another_kind_are_refused(self):
        self.refused("train_1.csv", change=lambda f: f.update({"train_1.csv": bytes(range(256)) * 40}))


if __name__ == "__main__":
    if not (BIN / "hrp-diagnose").exists():
        sys.exit(f"{BIN}/hrp-diagnose is not built: nothing to test")
    unittest.main()
