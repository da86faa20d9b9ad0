# SPDX-License-Identifier: BSD-3-Clause
"""Runs DIR/updated/nominal.yaml and DIR/updated/scenario.yaml of a diagnosis and compares both with the recording whose
commands they replay: normalised error (root mean square over the recording's standard deviation) of every signal that
both have. Writes DIR/resimulated.json. `mujoco`: the same on MuJoCo's dynamics server, with what of the model that server
holds (DIR/updated/export/mujoco.yaml). Usage: resimulate.py BIN_DIR DIR servers|process|mujoco"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

# [s] Both runs begin at rest in the recording's first pose: what comes of that when it starts in mid-motion, or on soles
# that give, fades within about so long, and would be most of the error. Not more than a quarter of the recording.
SETTLE = 1.0


def read_table(bin_folder, path, folder):
    """Columns by name, times from 0; a log of ours is turned into a table first."""
    path = pathlib.Path(path)
    if path.suffix == ".mcap":
        table = pathlib.Path(folder) / (path.stem + "_as_table.csv")
        call(bin_folder / "hrp-log", "csv", path, "--out", table)
        path = table
    with open(path) as file:
        rows = csv.reader(line for line in file if line.strip() and not line.startswith("#"))
        names = [name.strip() for name in next(rows)]
        columns = {name: [] for name in names}
        for row in rows:
            for name, cell in zip(names, row):
                columns[name].append(float(cell) if cell.strip() else math.nan)
    origin = columns["time"][0]
    columns["time"] = [t - origin for t in columns["time"]]
    return columns


def call(*words):
    run = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"resimulate.py: {words[0]} ends with status {run.returncode}:\n{run.stderr or run.stdout}")


def simulate(bin_folder, scenario, way, folder):
    log = pathlib.Path(folder) / (scenario.stem + ".mcap")
    options = {"process": ["--in-process"], "mujoco": ["--program", "dynamics=hrp-dynamics-mujoco"]}.get(way, [])
    call(bin_folder / "hrp-simulate", scenario, "--log", log, "--no-plot", "--quiet", *options)
    return read_table(bin_folder, log, folder)


def compare(recorded, simulated, name):
    """Normalised error; None where the recording stands still or one of the two has no numbers."""
    times, values, k, pairs = simulated["time"], simulated[name], 0, []
    begin = min(SETTLE, recorded["time"][-1] / 4.0)
    for t, r in zip(recorded["time"], recorded[name]):
        while k + 2 < len(times) and times[k + 1] <= t:
            k += 1
        if t < begin or t > times[-1] or not math.isfinite(r):
            continue
        s = (t - times[k]) / (times[k + 1] - times[k])
        v = values[k] + s * (values[k + 1] - values[k])
        if math.isfinite(v):
            pairs.append((r, v))
    if len(pairs) < 2:
        return None
    mean = sum(r for r, _ in pairs) / len(pairs)
    spread = math.sqrt(sum((r - mean) ** 2 for r, _ in pairs) / len(pairs))
    return math.sqrt(sum((r - v) ** 2 for r, v in pairs) / len(pairs)) / spread if spread > 0 else None


def main():
    if len(sys.argv) != 4 or sys.argv[3] not in ("servers", "process", "mujoco"):
        sys.exit(__doc__)
    bin_folder, out, way = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    updated = json.loads((out / "series.json").read_text())["updated"]
    with tempfile.TemporaryDirectory() as folder:
        recorded = read_table(bin_folder, updated["replays"], folder)
        found = "export/mujoco.yaml" if way == "mujoco" else "scenario.yaml"
        runs = [simulate(bin_folder, out / "updated" / name, way, folder) for name in ("nominal.yaml", found)]
    errors = {}
    for name in recorded:
        if name == "time" or name.startswith("/joint_commands") or any(name not in run for run in runs):
            continue
        before, after = (compare(recorded, run, name) for run in runs)
        if before is not None and after is not None:
            errors[name] = {"before": before, "after": after}
    (out / "resimulated.json").write_text(json.dumps({"recording": updated["replays"], "way": way, "per_signal": errors}, indent=1) + "\n")
    print(f"{updated['replays']} simulated again ({way}): error over the recording's own spread")
    print("  nominal  with findings")
    for name, e in sorted(errors.items(), key=lambda item: -item[1]["before"])[:20]:
        print(f"{e['before']:9.4f} {e['after']:14.4f}  {name}")


if __name__ == "__main__":
    main()
