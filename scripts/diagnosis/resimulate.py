# SPDX-License-Identifier: BSD-3-Clause
"""Runs DIR/updated/nominal.yaml and DIR/updated/scenario.yaml of a diagnosis and compares both with the recording whose
commands they replay: normalised error (root mean square over the recording's standard deviation) of every signal that
both have. With --controller the controller closes the loop instead of the recorded commands. For robots on their feet
also the papers' figures: vertical forces, roll and pitch, ankle torques, with numbers. Writes DIR/resimulated.json, the
part `resimulated` of DIR/report.json, and pictures into DIR/report.html. `mujoco`: the same on MuJoCo's dynamics server,
with what of the model that server holds (DIR/updated/export/mujoco.yaml)."""
import argparse
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import closed_loop
import walk_figures
import walk_report

# [s] Both runs begin at rest in the recording's first pose: what comes of that when it starts in mid-motion, or on soles
# that give, fades within about so long, and would be most of the error. Not more than a quarter of the recording.
SETTLE = 1.0
CONTROL_PERIOD, TIME_STEP = 0.005, 0.001  # [s] of a closed loop, where no scenario states them
LATE = 1.0  # [s] by which a recording may have begun before or after the controller, beside what its clock says
OWN_CLOCK = 5.0  # [s] a first stamp within so many seconds counts from the controller's start


def read_table(bin_folder, path, folder):
    """Columns by name, times from 0, and the first stamp; a log of ours is turned into a table first."""
    path = pathlib.Path(path)
    if path.suffix == ".mcap":
        table = pathlib.Path(folder) / (path.stem + "_as_table.csv")
        call(bin_folder / "hrp-log", "csv", path, "--out", table)
        path = table
    with open(path, encoding="utf-8-sig") as file:
        rows = csv.reader(line for line in file if line.strip() and not line.startswith(("#", "%")))
        names = [name.strip() for name in next(rows)]
        columns = {name: [] for name in names}
        for row in rows:
            for name, cell in zip(names, row):
                columns[name].append(float(cell) if cell.strip() else math.nan)
    origin = columns["time"][0]
    columns["time"] = [t - origin for t in columns["time"]]
    return columns, origin


def call(*words):
    run = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"resimulate.py: {words[0]} ends with status {run.returncode}:\n{run.stderr or run.stdout}")


def simulate(bin_folder, scenario, way, folder):
    log = pathlib.Path(folder) / (scenario.stem + ".mcap")
    options = {"process": ["--in-process"], "mujoco": ["--program", "dynamics=hrp-dynamics-mujoco"]}.get(way, [])
    call(bin_folder / "hrp-simulate", scenario, "--log", log, "--no-plot", "--quiet", *options)
    return read_table(bin_folder, log, folder)[0]


def get_section(text, key):
    """A top-level key of a scenario with all that belongs to it, or ''."""
    found = re.search(rf"(?m)^{key}:.*\n?(?:(?:[ \t#-].*|\s*)(?:\n|\Z))*", text)
    return found[0].rstrip("\n ") + "\n" if found else ""


def drop_section(text, key):
    section = get_section(text, key)
    return text.replace(section, "", 1) if section else text


def find_settings(controller, experiment):
    """The scenario that tells the controller what to do: the one that was named, else the experiment itself."""
    if controller.settings:
        return controller.settings.read_text(), str(controller.settings)
    return (pathlib.Path(experiment).read_text() if experiment else ""), str(experiment)


def make_closed(text, settings, recorded, duration):
    """A scenario of the updated model in which nobody replays commands."""
    for key in ("controller", "steps", "interpolation"):
        text = drop_section(text, key)
    text = text.rstrip("\n") + "\n"
    # The controller begins where it began then, which need not be where the recording does.
    start = get_section(settings, "initial")
    text = drop_section(text, "initial") + start if start else text
    steps = get_section(settings, "steps")
    step, period = (read_number(steps, key, default) for key, default in (("time_step", TIME_STEP), ("control_period", CONTROL_PERIOD)))
    if not get_section(text, "initial"):
        names = [n for n in recorded if n.startswith("/joint_states/") and n.endswith("/position")]
        pose = {n.split("/")[2]: recorded[n][0] for n in names if math.isfinite(recorded[n][0])}
        text += "initial: {joints: {%s}}\n" % ", ".join("%s: %.8g" % item for item in pose.items())
    duration = period * math.ceil(duration / period - 1e-9)
    return (text + (get_section(settings, "controller") or "controller: {type: hold}\n") +
            (get_section(settings, "interpolation") or "interpolation: hermite\n") +
            f"steps: {{time_step: {step:.10g}, control_period: {period:.10g}, duration: {duration:.10g}}}\n")


def read_number(section, key, default):
    found = re.search(rf"\b{key}:\s*([-+\d.eE]+)", section)
    return float(found[1]) if found else default


def simulate_closed(options, controller, scenario, settings, recorded, duration, folder):
    """(table, note): note where the run ended before its time."""
    path = scenario.with_name(scenario.stem + "_closed.yaml")
    path.write_text(make_closed(scenario.read_text(), settings, recorded, duration))
    log = pathlib.Path(folder) / (path.stem + ".mcap")
    status, words = closed_loop.run(options.bin, path, log, controller, options.wait)
    if not log.exists() or status == 2:
        raise closed_loop.LoopError(f"the server set refuses {path}:\n{words}")
    try:
        table = read_table(options.bin, log, folder)[0]
    except StopIteration:
        raise closed_loop.LoopError(f"{scenario.stem}: nothing was simulated:\n{words}") from None
    why = next((line for line in words.splitlines() if line.startswith("hrp-simulate:")), words.strip())
    return table, (f"{scenario.stem}: the run ended at {table['time'][-1]:.2f} s: {why}" if status else "")


def close_loop(options, controller, recorded, origin, folder):
    """Both runs on the recording's clock."""
    settings, _ = find_settings(controller, options.experiment)
    early = origin if 0.0 <= origin <= OWN_CLOCK else 0.0
    duration = recorded["time"][-1] + early + LATE
    runs, notes = [], []
    for name in ("nominal.yaml", "scenario.yaml"):
        table, note = simulate_closed(options, controller, options.out / "updated" / name, settings, recorded, duration, folder)
        runs.append(table)
        notes += [note] if note else []
    for table in [recorded] + runs:
        walk_figures.add_attitude(table)
    shift = walk_figures.find_shift(recorded, runs[1], early + LATE)
    return [walk_figures.shift_time(run, shift, recorded["time"][-1]) for run in runs], shift, notes


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


def list_errors(recorded, runs):
    errors = {}
    for name in recorded:
        if name == "time" or not name.startswith("/") or name.startswith("/joint_commands") or any(name not in run for run in runs):
            continue
        before, after = (compare(recorded, run, name) for run in runs)
        if before is not None and after is not None:
            errors[name] = {"before": before, "after": after}
    return errors


def save(out, result, pictures):
    (out / "resimulated.json").write_text(json.dumps(result, indent=1) + "\n")
    path = out / "report.json"
    if path.exists():
        report = json.loads(path.read_text())
        report["resimulated"] = {key: value for key, value in result.items() if key != "per_signal"}
        path.write_text(json.dumps(report, indent=1) + "\n")
    if pictures and (out / "report.html").exists():
        walk_report.put_section(out / "report.html", walk_report.make_section(result, pictures))


def read_options():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("way", choices=["servers", "process", "mujoco"])
    parser.add_argument("--controller", help="a program with its arguments, or a scenario with a walk's settings")
    parser.add_argument("--experiment", help="the experiment.yaml, which may have a section `controller:`")
    parser.add_argument("--wait", type=float, default=30.0, help="[s] without an answer after which a controller counts as silent")
    parser.add_argument("--only-check", action="store_true", help="only looks whether the controller can be started")
    return parser.parse_args()


def make_controller(options):
    """Or None. Refuses one that cannot be started, and ours without a plan of its walk."""
    if options.controller is None:
        return None
    controller = closed_loop.Controller(options.controller, options.bin)
    settings, where = find_settings(controller, options.experiment)
    if controller.name() == "hrp-controller" and not get_section(settings, "controller"):
        raise closed_loop.LoopError(f"--controller hrp-controller: {where} has no section `controller:` that says how to walk; "
                                    "name a scenario that has one: --controller SCENARIO.yaml")
    return controller


def run(options, folder=None):
    """The result; logs stay in the folder, where one is named."""
    if folder is None:
        with tempfile.TemporaryDirectory() as temporary:
            return run(options, temporary)
    controller = make_controller(options)
    updated = json.loads((options.out / "series.json").read_text())["updated"]
    if updated.get("limp") and not controller:
        sys.exit("resimulate.py: 'drive: effort' has no servo that follows the recorded positions, so nothing can be replayed; "
                 "expected --resimulate servers --controller PROGRAM, a controller that sends torques")
    replays = updated["replays"]
    result = {"recording": replays, "way": options.way, "loop": "closed loop" if controller else "recorded commands"}
    recorded, origin = read_table(options.bin, replays, folder)
    if controller:
        result["controller"] = options.controller
        runs, result["shift"], result["notes"] = close_loop(options, controller, recorded, origin, folder)
    else:
        found = "export/mujoco.yaml" if options.way == "mujoco" else "scenario.yaml"
        runs = [simulate(options.bin, options.out / "updated" / name, options.way, folder) for name in ("nominal.yaml", found)]
    result["per_signal"] = list_errors(recorded, runs)
    pictures = []
    if any(walk_figures.list_feet(run) for run in runs):
        result["walk"] = walk_report.make_walk(recorded, *runs)
        pictures = walk_report.draw_all(recorded, *runs)
    save(options.out, result, pictures)
    return result


def say(result):
    how = f"{result['way']}, {result.get('controller') or 'recorded commands'}"
    print(f"{result['recording']} simulated again ({how}): error over the recording's own spread")
    print("  nominal  with findings")
    for name, e in sorted(result["per_signal"].items(), key=lambda item: -item[1]["before"])[:20]:
        print(f"{e['before']:9.4f} {e['after']:14.4f}  {name}")
    if "walk" in result:
        print("\n" + walk_report.say_walk(result))
    for note in result.get("notes", []):
        print(note)


def main():
    options = read_options()
    if options.controller is not None and options.way != "servers":
        sys.exit("resimulate.py: --controller needs --resimulate servers: it joins the server set over DDS")
    try:
        if options.only_check:
            make_controller(options)
            return
        say(run(options))
    except closed_loop.LoopError as error:
        print(f"resimulate.py: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
