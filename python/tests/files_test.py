# SPDX-License-Identifier: BSD-3-Clause
"""Logs as arrays, recordings that the diagnosis reads, reports as objects, plots."""
import pathlib
import tempfile
import unittest

import numpy as np

import openhrp_dds
from places import ROOT, SCENARIOS, simulate

ARM_EXPERIMENT = ROOT / "models" / "experiments" / "arm"


class Logs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = str(pathlib.Path(cls.folder.name) / "run.mcap")
        run = simulate(SCENARIOS / "hrp2p_stand.yaml", "--in-process", "--duration", "0.5", log=cls.path)
        assert run.returncode == 0, run.stderr
        cls.log = openhrp_dds.read_log(cls.path)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_columns_are_views_of_one_table(self):
        self.assertEqual(self.log.columns[0], "time")
        column = self.log["/joint_states/R_KNEE/position"]
        self.assertTrue(np.shares_memory(column, self.log.values))
        self.assertEqual(self.log.joint_array().shape, (len(self.log), len(self.log.joints)))

    def test_an_unknown_column_is_named(self):
        with self.assertRaisesRegex(KeyError, "no column '/joint_states/NOSE/position'"):
            self.log["/joint_states/NOSE/position"]

    def test_forces_of_a_log_have_causes_that_add_up(self):
        forces = self.log.contact_forces()
        self.assertEqual({pair[1] for pair in forces}, {"ground"})
        for pair in forces.values():
            np.testing.assert_array_equal(pair["spring"] + pair["damper"] + pair["friction"], pair["total"])

    def test_encoders_without_errors_read_the_state(self):
        states = self.log.states()
        first = self.log.joints[0]
        rows = np.searchsorted(states["time"], self.log.time)
        np.testing.assert_array_equal(self.log[f"/joint_states/{first}/position"], states["q"][rows, 0])

    def test_a_log_that_was_cut_short_is_read_with_a_warning(self):
        cut = pathlib.Path(self.folder.name) / "cut.mcap"
        whole = pathlib.Path(self.path).read_bytes()
        cut.write_bytes(whole[: len(whole) * 6 // 10])
        with self.assertWarnsRegex(RuntimeWarning, "cut.mcap: "):
            log = openhrp_dds.read_log(str(cut))
        self.assertLess(len(log), len(self.log))
        self.assertGreater(len(log), 0)
        with self.assertWarnsRegex(RuntimeWarning, "cut.mcap: "):
            log.states()

    def test_a_data_frame_has_the_columns(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("no pandas")
        frame = self.log.to_pandas()
        self.assertEqual(list(frame.columns), self.log.columns[1:])
        np.testing.assert_array_equal(frame.to_numpy(), self.log.values[:, 1:])

    def test_plots_draw_what_they_are_given(self):
        try:
            from openhrp_dds import plots
        except ImportError:
            self.skipTest("no matplotlib")
        axes = plots.plot_joints(self.log, ["R_KNEE"])
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), self.log["/joint_states/R_KNEE/position"])
        self.assertEqual(len(plots.plot_contact_forces(self.log).lines), 2)
        axes = plots.plot_comparison(self.log, {"nominal": self.log, "updated": self.log}, "/joint_states/R_KNEE/position")
        self.assertEqual([line.get_label() for line in axes.lines], ["recorded", "nominal", "updated"])
        with self.assertRaisesRegex(ValueError, "quantity must be one of position"):
            plots.plot_joints(self.log, quantity="smell")

    def test_what_is_no_log_is_an_error_with_its_name(self):
        with self.assertRaisesRegex(RuntimeError, "default.yaml"):
            openhrp_dds.read_log(str(SCENARIOS / "default.yaml"))


def read_csv(path):
    with open(path, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    values = np.genfromtxt(path, delimiter=",", skip_header=1)
    return {name: values[:, i] for i, name in enumerate(names)}


class Recordings(unittest.TestCase):
    def test_a_recording_reads_back_to_the_bit(self):
        columns = {"time": np.arange(50) / 3.0, "/joint_states/knee/position": np.random.default_rng(1).normal(size=50)}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "r.csv"
            openhrp_dds.write_recording(str(path), columns)
            back = read_csv(path)
        for name, values in columns.items():
            np.testing.assert_array_equal(back[name], values)

    def test_bad_columns_are_named(self):
        time = np.arange(3.0)
        for columns, words in (({"/joint_states/a/position": time}, "must have 'time'"),
                               ({"time": time, "/joint_states/a/position": time[:2]}, r"'/joint_states/a/position' must have shape \(3,\).*\(2,\)"),
                               ({"time": time[::-1]}, "must rise"), ({"time": time, "knee": time}, "'knee' must be named as a signal")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                openhrp_dds.write_recording("unused.csv", columns)

    def test_roles_are_checked(self):
        recording = openhrp_dds.Recording("a", {"time": np.arange(3.0)}, role="test")
        with self.assertRaisesRegex(ValueError, "role must be 'train' or 'validate'"):
            openhrp_dds.write_experiment("unused", "robot.urdf", [recording])

    def test_the_diagnosis_finds_what_is_hidden_in_recordings_written_here(self):
        # The experiment of the repository, written anew: friction at axis2 is what its answer says.
        with tempfile.TemporaryDirectory() as folder:
            settings = {"base": "fixed", "servo": {"joints": {
                "axis1": {"kp": 264, "kd": 7.13, "effort_limit": 72}, "axis2": {"kp": 51.6, "kd": 1.63, "effort_limit": 15},
                "axis3": {"kp": 20, "kd": 0.738, "effort_limit": 5.1}, "axis4": {"kp": 2.92, "kd": 0.0751, "effort_limit": 0.75}}},
                "noise": {"position": 4.996381842e-05, "velocity": 0.004996381842, "effort": 0.016488}, "sample_rate": 250,
                "initial": {"joints": {"axis1": 0.5579, "axis2": 0, "axis3": 0, "axis4": 0.2454}}}
            recordings = [openhrp_dds.Recording(name, read_csv(ARM_EXPERIMENT / (name + ".csv")), name.split("_")[0])
                          for name in ("train_1", "train_2", "train_3", "validate_1")]
            experiment = openhrp_dds.write_experiment(folder, str(ARM_EXPERIMENT / "robot.urdf"), recordings, settings)
            progress = []
            report = openhrp_dds.diagnose(experiment, str(pathlib.Path(folder) / "out"), jobs=1, on_progress=progress.append)
            self.assertTrue(progress)
            self.assertEqual(report.verdict, "explained")
            finding = report.findings[0]
            self.assertEqual((finding.effect, finding.where), ("coulomb_friction", {"joint": "axis2"}))
            low, high = finding.parameters["level"]["ci95"]
            self.assertTrue(low < finding.value("level") < high)
            with self.assertRaisesRegex(ValueError, "parameter must be one of level"):
                finding.value("size")
            openhrp_dds.Simulation(report.updated_scenario).step(100)

    def test_what_the_program_says_is_the_error(self):
        with self.assertRaisesRegex(openhrp_dds.ProgramError, "(?s)hrp-diagnose ended with status 2.*nowhere.yaml"):
            openhrp_dds.diagnose("nowhere.yaml", "unused", on_progress=None)
        with self.assertRaisesRegex(FileNotFoundError, "no report of a diagnosis"):
            openhrp_dds.DiagnosisReport("nowhere")


if __name__ == "__main__":
    unittest.main()
