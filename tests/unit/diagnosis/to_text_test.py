#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""to_text_test.py BIN SOURCE: recordings of NumPy, MATLAB, HDF5, JSON and lists in cells become text with the same numbers, and a draft from it."""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

BIN, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
T = 0.002 * np.arange(400)
Q = np.stack([0.5 * np.sin(3 * T + i) for i in range(2)], axis=1)


class ToText(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="hrp-text-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def convert(self, name, *options):
        return subprocess.run([SOURCE / "scripts/diagnosis/to_text.py", self.folder / name, *options], capture_output=True, text=True)

    def read(self, name):
        """(comments, columns by name) of the text that was made."""
        done = self.convert(name)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = (self.folder / name).with_suffix(".csv").read_text().splitlines()
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
        table = np.array(rows[1:], dtype=float)
        return [line for line in lines if line.startswith("#")], dict(zip(rows[0], table.T)), done.stdout

    def check_motion(self, columns, time, q_names):
        self.assertTrue(np.array_equal(columns[time], T))  # 17 digits: the same bits
        for i, name in enumerate(q_names):
            self.assertTrue(np.array_equal(columns[name], Q[:, i]), name)

    def test_arrays_of_numpy_become_columns_whichever_way_they_lie(self):
        np.savez(self.folder / "run.npz", time=T, q=Q, tau=3 * Q.T, fs=500.0, gains=np.ones(3), names=np.array(["a", "b"]))
        comments, columns, said = self.read("run.npz")
        self.check_motion(columns, "time", ["q_0", "q_1"])
        self.assertTrue(np.array_equal(columns["tau_1"], 3 * Q[:, 1]))
        self.assertEqual(comments, ["# fs = 500"])
        self.assertIn("left out, because they have other lengths: gains (3)", said)

    def test_a_table_of_records_keeps_its_names(self):
        table = np.zeros(len(T), dtype=[("t", "f8"), ("knee", "f8")])
        table["t"], table["knee"] = T, Q[:, 0]
        np.save(self.folder / "run.npy", table)
        self.check_motion(self.read("run.npy")[1], "t", ["knee"])

    def test_json_is_read_as_arrays_as_rows_and_as_records(self):
        arrays = {"t": T.tolist(), "state": {"q": Q.tolist()}, "fs": 500.0, "names": ["a", "b"]}
        records = [{"t": t, "state": {"q": q}, "mode": "run"} for t, q in zip(T.tolist(), Q.tolist())]
        (self.folder / "arrays.json").write_text(json.dumps(arrays))
        (self.folder / "records.json").write_text(json.dumps(records, indent=1))
        (self.folder / "lines.jsonl").write_text("".join(json.dumps(record) + "\n" for record in records))
        for name in ("arrays.json", "records.json", "lines.jsonl"):
            self.check_motion(self.read(name)[1], "t", ["state.q_0", "state.q_1"])
        (self.folder / "tests.json").write_text(json.dumps({"fast": [[t, *q] for t, q in zip(T.tolist(), Q.tolist())], "slow": [[0, 0, 0]] * 20}))
        _, columns, said = self.read("tests.json")
        self.check_motion(columns, "fast_0", ["fast_1", "fast_2"])
        self.assertIn("other lengths: slow (", said)

    def test_lists_in_the_cells_of_a_text_become_columns(self):
        with open(self.folder / "run.csv", "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["type", "time", "positions", "torques"])
            writer.writerows(["STATE", t, q.tolist(), str(q)] for t, q in zip(T.tolist(), Q))  # of JSON, and as NumPy prints arrays
        robot = SOURCE / "models/test_robots/arm.urdf"
        refused = subprocess.run([BIN / "hrp-draft-experiment", robot, self.folder / "run.csv", "--out", self.folder / "draft.yaml"],
                                 capture_output=True, text=True)
        self.assertIn("its cells hold lists: scripts/diagnosis/to_text.py", refused.stderr)
        done = self.convert("run.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.reader((self.folder / "run.columns.csv").read_text().splitlines()))
        columns = dict(zip(rows[0], np.array(rows[1:], dtype=float).T))
        self.check_motion(columns, "time", ["positions_0", "positions_1"])
        self.assertLess(np.abs(columns["torques_1"] - Q[:, 1]).max(), 1e-7)  # NumPy prints eight digits
        self.assertIn("has no lists", self.convert("run.columns.csv").stderr)

    def test_structures_of_matlab_have_dots(self):
        try:
            import scipy.io
        except ImportError:
            self.skipTest("python3-scipy is not installed")
        scipy.io.savemat(self.folder / "run.mat", {"log": {"t": T, "q": Q, "config": {"kp": 100.0}}})
        comments, columns, _ = self.read("run.mat")
        self.check_motion(columns, "log.t", ["log.q_1", "log.q_2"])
        self.assertEqual(comments, ["# log.config.kp = 100"])

    def test_groups_of_hdf5_have_dots(self):
        try:
            import h5py
        except ImportError:
            self.skipTest("python3-h5py is not installed")
        with h5py.File(self.folder / "run.h5", "w") as file:
            file["robot/t"], file["robot/q"] = T, Q
        self.check_motion(self.read("run.h5")[1], "robot.t", ["robot.q_0", "robot.q_1"])

    def test_what_cannot_be_read_is_refused_with_the_reason(self):
        # MATLAB and HDF5: for damage, or because their libraries are not there.
        for name, content, reason in (("a.npz", b"PK\x03\x04abc", "cannot be read"), ("b.npy", b"\x93NUMPY\x01\x00", "header"),
                                      ("c.mat", b"MATLAB 5.0", "error"), ("d.h5", b"\x89HDF\r\n\x1a\nx", "error"), ("e.xyz", b"", "expected .npz")):
            (self.folder / name).write_bytes(content)
            done = self.convert(name)
            self.assertEqual(done.returncode, 1)
            self.assertNotIn("Traceback", done.stderr)
            self.assertIn(f"{name}: error: ", done.stderr)
            self.assertIn(reason, done.stderr)
        np.save(self.folder / "objects.npy", np.array([{}, None]), allow_pickle=True)
        self.assertIn("objects.npy: error: ", self.convert("objects.npy").stderr)
        self.assertIn("no such file", self.convert("missing.npz").stderr)

    def test_nothing_is_overwritten_unasked(self):
        np.savez(self.folder / "run.npz", time=T)
        (self.folder / "run.csv").write_text("mine")
        self.assertIn("--force", self.convert("run.npz").stderr)
        self.assertEqual((self.folder / "run.csv").read_text(), "mine")
        self.assertEqual(self.convert("run.npz", "--force").returncode, 0)

    def test_the_diagnosis_says_what_the_file_is_and_drafts_from_its_text(self):
        np.savez(self.folder / "run.npz", time=T, q=Q[:, 0], tau=Q[:, 1])
        robot = SOURCE / "models/test_robots/pendulum.urdf"
        draft = [BIN / "hrp-draft-experiment", robot, self.folder / "run.npz", "--out", self.folder / "draft.yaml"]
        refused = subprocess.run(draft, capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("scripts/diagnosis/to_text.py", refused.stderr)
        self.read("run.npz")
        draft[2] = self.folder / "run.csv"
        subprocess.run(draft, check=True, capture_output=True)
        self.assertIn("position: 'q'", (self.folder / "draft.yaml").read_text())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
