#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_table_test.py SOURCE: the table has the medians of what was measured, a dash for what was not, and no sum of
Google Benchmark's own."""
import json
import pathlib
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(sys.argv[1])


def make(name, times, unit="ns", **counters):
    runs = [dict({"name": name, "run_type": "iteration", "cpu_time": t, "time_unit": unit}, **counters) for t in times]
    return runs + [{"name": name + "_mean", "run_type": "aggregate", "cpu_time": 1e9, "time_unit": unit}]


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    (folder / "multibody.json").write_text(json.dumps({"benchmarks":
        make("g1/forward_dynamics/ours", [3000, 1000, 2500]) + make("g1/forward_dynamics/mujoco", [9000])}))
    (folder / "step.json").write_text(json.dumps({"benchmarks":
        make("our_step/8", [12400], contacts=8, solves=1.98) + make("our_batch/process_time", [150], "ms", robot_steps=53096.4) +
        make("our_joints/25/13", [7900]) + make("our_joints/200/13", [42400]) + make("mujoco_joints/25/1000/1", [25800]) +
        [{"name": "mujoco_step/0", "run_type": "iteration", "error_occurred": True}]}))
    (folder / "server_set.txt").write_text("cyclone   14.0 x real time\nfast   6.6 x real time\ncyclone   16.0 x real time\n")
    said = subprocess.run([sys.executable, SOURCE / "scripts/benchmark_table.py", folder], capture_output=True, text=True)
assert said.returncode == 0, said.stderr
for row in ("| forward dynamics | 2.50 | 9.00 | - |", "| mass matrix | - | - | - |", "| ours, contacts given | 8 | 2.0 | 12.40 |",
            "| MuJoCo, default, with search | - |  | - |", "| ours | 53096 |", "| ours, limbs of 13 joints | 7.9 | - | - | 42.4 |",
            "| MuJoCo, default, one limb | 25.8 | - | - | - |", "| cyclone | 15.0 | 14, 16 |", "| fast | 6.6 | 6.6 |"):
    assert row in said.stdout, f"no row '{row}' in\n{said.stdout}"
print("every row is there")
