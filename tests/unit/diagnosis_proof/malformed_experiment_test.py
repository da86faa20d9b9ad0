# SPDX-License-Identifier: BSD-3-Clause
"""hrp-diagnose on broken experiments: exit status 2 with file, line and column, or a verdict; never a crash, never a
status of its own. Run as: malformed_experiment_test.py BIN_DIR."""
import gzip
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

from pendulum_experiment import URDF, YAML, HEAD, ROWS, ROWS_TWO, URDF_TWO, YAML_TWO, make_rows, make_csv

BIN = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else "build/bin")
DEG = 57.29578  # [degrees/rad]


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
            run = subprocess.run([BIN / "hrp-diagnose", f"{folder}/experiment.yaml", "--out", f"{folder}/out"], capture_output=True, text=True, errors="replace", timeout=110)
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

    def test_an_effort_of_the_other_sign_is_named(self):
        status, text, _ = self.answered(change=self.scaled(1, 1, 1, 1, 1, -1))
        self.assertEqual(status, 0, text)
        self.assertIn("one: the recorded effort has the opposite sign", text)

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

    def train(self, change):
        """Another text of train_1.csv."""
        return lambda f: f.update({"train_1.csv": change(f["train_1.csv"])})

    def test_bytes_of_another_kind_are_refused(self):
        for bad in (bytes(range(256)) * 40, bytes(100000), random.Random(1).randbytes(200000), make_csv(ROWS["train_1.csv"]).encode("utf-16")):
            self.refused(r"train_1.csv:1: error: is no text: byte \d+ at place \d+ of its header", change=self.train(lambda _: bad))
        packed = gzip.compress(make_csv(ROWS["train_1.csv"]).encode())
        self.refused("train_1.csv: error: is packed with gzip, expected comma-separated values: gunzip it", change=self.train(lambda _: packed))

    def test_names_in_another_encoding_make_a_report(self):
        rows = make_csv([r + [float(k)] for k, r in enumerate(ROWS["train_1.csv"])], HEAD + ["/joint_states/kn\xe9/position"]).encode("latin-1")
        status, text, report = self.run_tool(change=self.train(lambda _: rows))
        self.assertEqual(status, 0, text)
        self.assertIn("joints that the model does not have were left out: kn\ufffd", json.dumps(json.loads(report), ensure_ascii=False))

    def test_an_experiment_in_another_encoding_is_named_with_its_line(self):
        self.refused("experiment.yaml:11:17: error: byte 233 is not UTF-8", yaml=(YAML + "description: caf\xe9\n").encode("latin-1"))

    def test_cells_that_semicolons_or_tabs_separate_say_the_same(self):
        expected = self.run_tool()[2]
        for separator in (";", "\t"):
            status, text, report = self.run_tool(change=self.train(lambda t: t.replace(",", separator)))
            self.assertEqual(status, 0, text)
            self.assertEqual(json.loads(report)["fit"], json.loads(expected)["fit"])

    def test_lines_that_end_with_a_carriage_return_alone_are_named(self):
        self.refused("train_1.csv:1: error: its lines end with CR alone", change=self.train(lambda t: t.replace("\n", "\r")))

    def test_a_missing_header_is_named(self):
        self.refused("train_1.csv:1:1: error: '0' stands where a header is expected", change=self.train(lambda t: t.split("\n", 1)[1]))

    def test_a_header_of_very_many_columns_is_read_in_time(self):
        self.refused("train_1.csv:1: error: holds no samples", change=self.train(lambda _: ",".join(f"c{i}" for i in range(60000)) + "\n"))

    def with_cell(self, column, value, row=100):
        rows = [list(r) for r in ROWS["train_1.csv"]]
        rows[row][column] = value
        return self.train(lambda _: make_csv(rows))

    def test_numbers_that_no_sensor_reads_are_named_with_line_and_value(self):
        for column in range(1, 6):
            for value in (1e300, -1.7e308):
                self.refused(rf"train_1.csv:102:{column + 1}: error: {HEAD[column]}: is {re.escape(f'{value:.4g}')}: expected at most 1e\+12", change=self.with_cell(column, value))

    def test_a_strange_column_of_huge_numbers_is_left_out(self):
        rows = [r + [1e300] for r in ROWS["train_1.csv"]]
        _, _, report = self.answered(change=self.train(lambda _: make_csv(rows, HEAD + ["/imu/waist/gyro/x"])))
        self.assertIn("train_1.csv:2:7: warning: /imu/waist/gyro/x: is 1e+300: expected at most 1e+12 in SI units; the column is left out", report)

    def test_a_command_far_beyond_the_limits_is_named_with_its_time(self):
        _, _, report = self.answered(change=self.with_cell(1, 1e6))
        self.assertIn("/joint_commands/one/position is 1e+06 at 0.4 s, far beyond the joint's limits of 3 rad", report)

    def test_traces_of_numbers_are_no_readings(self):
        self.refused("train_1.csv:1:4:", "throughout", change=self.scaled(1, 1, 1, 1e-300, 1, 1))
        _, _, report = self.answered(change=self.scaled(1, 1, 1, 1, 1e-300, 1e-300))
        for quantity in ("velocity", "effort"):
            self.assertIn(f"/joint_states/one/{quantity} never changes: taken as not recorded", report)

    def test_times_in_another_unit_are_named_with_what_was_expected(self):
        for factor, words in ((1e3, "4 s apart.*milliseconds"), (1e6, "4000 s apart.*microseconds"), (1e9, r"4e\+06 s apart.*nanoseconds"),
                              (1e-6, "4e-09 s apart.*in which unit"), (1e-300, "4e-303 s apart.*in which unit"), (1e300, r"4e\+297 s apart")):
            self.refused("train_1.csv:3:1: error: time: samples stand " + words, change=self.scaled(factor, 1, 1, 1, 1, 1))

    def test_a_clock_that_is_set_within_a_recording_is_named_with_its_line(self):
        for jump in (86400, 1e9):
            rows = [[r[0] + (jump if k > 250 else 0)] + r[1:] for k, r in enumerate(ROWS["train_1.csv"])]
            self.refused("train_1.csv:253:1: error: time: jumps from 1 to ", change=self.train(lambda _: make_csv(rows)))
        self.refused(r"train_1.csv:103:1: error: time: goes back from 1e\+300 to 0.404 s", change=self.with_cell(0, 1e300))

    def test_a_gap_turns_no_commanded_velocity_into_a_separate_one(self):
        rows = ROWS["train_1.csv"][:100] + ROWS["train_1.csv"][400:]
        _, _, report = self.answered(change=self.train(lambda _: make_csv(rows)))
        self.assertNotIn("not the derivative of the commanded positions", report)

    def test_a_gap_of_the_clock_explains_nothing(self):
        def lose(f):
            for name, phase in (("train_1.csv", 0.3), ("validate_1.csv", 1.7)):
                f[name] = make_csv([r for r in make_rows(phase, seconds=6.0) if not 2.0 < r[0] < 4.0])
        status, text, report = self.run_tool(change=lose)
        self.assertEqual((status, json.loads(report)["verdict"]), (0, "no_mismatch"), text)
        self.assertIn("train_1.csv: a gap without samples from 2 to 4 s: nothing is carried across", report)

    def test_recordings_of_a_moment_are_answered_with_a_warning(self):
        self.refused("train_1.csv:1:1: error: time: has 7 different stamps, expected at least 8", change=self.train(lambda t: "\n".join(t.split("\n")[:8]) + "\n"))
        _, _, report = self.answered(change=self.train(lambda t: "\n".join(t.split("\n")[:9]) + "\n"))
        self.assertIn("train_1.csv: lasts 0.028 s (8 samples): too short", report)

    def test_noise_that_is_misspelt_or_drowns_everything_is_named(self):
        self.refused("experiment.yaml:11:9: error: noise.postion: expected position, velocity, effort", yaml=YAML + "noise: {postion: 1e-3}\n")
        _, _, report = self.answered(yaml=YAML + "noise: {position: 1e9, /imu/waist: 1e-3}\n")
        self.assertIn("/joint_states/one/position: the stated noise of 1e+09 is more than all its changes, 0.", report)
        self.assertIn("noise./imu/waist: no recording has such a column or sensor", report)

    def test_a_rate_that_cannot_be_is_named(self):
        for rate in ("0", "-5", ".nan", "1e300", "often"):
            self.refused("experiment.yaml:11:14: error: sample_rate: expected a rate of more than 0 Hz", yaml=YAML + f"sample_rate: {rate}\n")

    def test_pushes_beyond_a_recording_are_named(self):
        for push in ("link: upper, force: [1, 0, 0], start: 100, duration: 1", "start: -5, duration: 1"):
            _, _, report = self.answered(yaml=YAML.replace("role: train}", "role: train, pushes: [{" + push + "}]}"))
            self.assertIn("lies beyond the recording's 1.996 s", report)

    def test_a_link_at_the_end_of_the_world_is_named_with_its_line(self):
        self.refused(r"robot.urdf:4: error: link 'upper' .*is further away than 10 km", urdf=URDF.replace("0 0 -0.2", "0 0 -1e300"))

    def test_the_mesh_of_a_foot_that_cannot_be_read_is_named(self):
        mesh = '<collision><geometry><mesh filename="sole.stl"/></geometry></collision></link>'
        def change(f):
            f.update({"sole.stl": bytes(range(256)) * 4, "robot.urdf": f["robot.urdf"].replace("</inertial></link>", "</inertial>" + mesh)})
        self.refused(r"sole.stl: error: is no mesh", change=change, yaml=YAML + "feet: [upper]\n")

    def test_options_that_are_no_numbers_are_refused(self):
        for option in ("--patience", "--seconds"):
            run = subprocess.run([BIN / "hrp-diagnose", "none.yaml", "--out", "none", "--next", option, "nan"], capture_output=True, text=True, timeout=60)
            self.assertEqual(run.returncode, 2)
            self.assertIn(f"{option}: Value nan is no number", run.stderr)


if __name__ == "__main__":
    if not (BIN / "hrp-diagnose").exists():
        sys.exit(f"{BIN}/hrp-diagnose is not built: nothing to test")
    unittest.main()
