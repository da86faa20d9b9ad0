# SPDX-License-Identifier: BSD-3-Clause
"""Where tests find the tree and its programs, and scenarios that several of them run."""
import os
import pathlib
import subprocess

ROOT = pathlib.Path(os.environ.get("HRP_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
BIN = pathlib.Path(os.environ.get("HRP_BIN_DIR", ROOT / "build" / "bin"))
SCENARIOS = ROOT / "models" / "scenarios"
ARM = ROOT / "models" / "test_robots" / "arm.urdf"


def write_arm(folder, duration=0.5, period=0.001, drive="drive: effort", more=""):
    """An arm on a fixed base that efforts move, 1 kHz."""
    path = pathlib.Path(folder) / "arm.yaml"
    path.write_text(f"""robot: {ARM}
base: fixed
{drive}
steps: {{time_step: 0.001, control_period: {period}, duration: {duration}}}
controller: {{on_fault: stop}}
{more}
""", encoding="utf-8")
    return str(path)


def simulate(scenario, *options, log):
    """A run of the server set; returns the finished process."""
    words = [str(BIN / "hrp-simulate"), str(scenario), "--log", str(log), "--force", "--no-plot", "--quiet", *map(str, options)]
    return subprocess.run(words, capture_output=True, text=True, timeout=120)
