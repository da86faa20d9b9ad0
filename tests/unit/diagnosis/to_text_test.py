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
        self.assertIn("left out: names (words, or lists of several lengths), gains (3)", said)

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
        self.assertIn("left out: slow (20 x 3)", said)

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

    def test_what_is_left_out_is_named(self):
        (self.folder / "run.json").write_text(json.dumps({"t": T.tolist(), "q": [[1.0]] + [[1.0, 2.0]] * 399, "mode": ["run"] * 400, "q.x": T.tolist(),
                                                          "q,x": Q[:, 0].tolist(), "q;x": T.tolist()}))
        _, columns, said = self.read("run.json")
        self.assertEqual(list(columns), ["t", "q.x", "q_x"])
        self.assertTrue(np.array_equal(columns["q_x"], Q[:, 0]))
        for name in ("q (words", "mode (words", "q;x (this name stands twice)"):
            self.assertIn(name, said)

    def test_a_name_with_a_separator_shifts_no_column(self):
        np.savez(self.folder / "run.npz", **{"time": T, "q [rad, joint]": Q[:, 0], "#tau": Q[:, 1]})
        self.check_motion(self.read("run.npz")[1], "time", ["q_[rad__joint]", "tau"])

    def test_names_that_are_numbers_stay_a_header(self):
        (self.folder / "run.json").write_text(json.dumps({"0": T.tolist(), "1": Q[:, 0].tolist(), "2": Q[:, 1].tolist()}))
        self.check_motion(self.read("run.json")[1], "column_0", ["column_1", "column_2"])

    def test_a_recorder_that_was_killed_costs_its_last_line_only(self):
        lines = [json.dumps({"t": t, "q": q}) for t, q in zip(T.tolist(), Q.tolist())]
        (self.folder / "run.jsonl").write_text("\n".join(lines + lines[-1:])[:-5], encoding="utf-8-sig")
        _, columns, said = self.read("run.jsonl")
        self.check_motion(columns, "t", ["q_0", "q_1"])
        self.assertIn("left out: line 401 (cut off)", said)
        (self.folder / "hole.jsonl").write_text("\n".join(lines[:5] + ["{"] + lines[5:]))
        self.assertIn("line 6 is no JSON", self.convert("hole.jsonl").stderr)
        for end in ("1,\"[0.1, 0.", "1,\"[0.1", "1"):  # within the last list, and before it
            text = "t,q\n" + "".join(f'{t},"{q}"\n' for t, q in zip(T.tolist(), Q.tolist())) + end
            (self.folder / "lists.csv").write_text(text)
            done = self.convert("lists.csv", "--force")
            self.assertIn("400 samples of 3 signals", done.stdout)
            self.assertIn("left out: the last line (cut off)", done.stdout)

    def test_a_sample_without_a_value_is_empty_and_costs_no_signal(self):
        records = [{"t": t, "state": {"q": q}, "u": 1.0} for t, q in zip(T.tolist(), Q.tolist())]
        records[7] = {"t": records[7]["t"]}
        (self.folder / "run.json").write_text(json.dumps(records))
        (self.folder / "run.txt").write_text("t,state.q,u\n" + "".join(f'{r["t"]},"{r["state"]["q"] if "state" in r else ""}",{r.get("u", "")}\n' for r in records))
        self.assertEqual(self.convert("run.txt").returncode, 0)
        text = list(csv.reader((self.folder / "run.columns.csv").read_text().splitlines()))
        for columns in (self.read("run.json")[1], dict(zip(text[0], np.array(text[1:], dtype=float).T))):
            for name, values in (("state.q_0", Q[:, 0]), ("state.q_1", Q[:, 1]), ("u", np.ones(400))):
                self.assertEqual(np.flatnonzero(np.isnan(columns[name])).tolist(), [7])
                self.assertTrue(np.array_equal(np.delete(columns[name], 7), np.delete(values, 7)), name)

    def test_dates_beside_lists_become_seconds(self):
        text = "t,q\n" + "".join(f'2026-11-28 14:36:{19 + t:06.3f}+01:00,"{q}"\n' for t, q in zip(T.tolist(), Q.tolist()))
        (self.folder / "run.csv").write_text(text)
        self.assertEqual(self.convert("run.csv").returncode, 0)
        time = np.loadtxt(self.folder / "run.columns.csv", delimiter=",", skiprows=1)[:, 0]
        self.assertLess(np.abs(time - time[0] - T).max(), 1e-6)  # a double resolves 2.4e-7 s of 1.8e9 s

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
        np.savez(self.folder / "run.npz", time=T)
        full = self.convert("run.npz", "--out", "/dev/full", "--force")
        self.assertIn("/dev/full cannot be written: No space left", full.stderr)
        self.assertNotIn("Traceback", full.stderr)

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
