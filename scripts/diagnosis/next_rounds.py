# SPDX-License-Identifier: BSD-3-Clause
"""A dialogue with a simulated reality: diagnose, propose motions, play them, add the recordings, diagnose again.

Reality is SCENARIO.yaml, whose `effects` the diagnosis does not know, through the in-process simulator; or a program that
is called as PROGRAM COMMANDS.csv RECORDING.csv. OUT/experiment holds the experiment with all recordings, OUT/round_N each
report."""
import argparse
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import zlib

import resimulate


def call(words, quiet=False):
    run = subprocess.run([str(w) for w in words], capture_output=quiet, text=True)
    if run.returncode:
        sys.stderr.write((run.stdout or "") + (run.stderr or "") if quiet else "")
        sys.exit(run.returncode)


# [s]. Commands are held for a step, so a simulated drive is half a step late: with 0.5 ms a right model left a fifth of the
# noise, and the report widened its intervals for it.
STEP = 1e-4
REST = 1.0  # [s] that the robot stands before a motion, so that it has come to rest in its own weight


def shift(commands, shifted):
    """The commands REST later, and where they begin before that; returns their end [s]."""
    names, *rows = commands.read_text().strip().splitlines()
    rows = [row.split(",") for row in rows]
    first = float(rows[0][0])
    moved = [["0"] + rows[0][1:]] + [[f"{float(row[0]) - first + REST:.10g}"] + row[1:] for row in rows]
    shifted.write_text("\n".join([names] + [",".join(row) for row in moved]) + "\n")
    return float(moved[-1][0])


def hang(text, loads):
    """The scenario with what somebody hangs on the robot, as effects beside its own."""
    for load in loads:
        item = f"- {{effect: payload, where: {{link: {load['link']}}}, parameters: {{mass: {load['mass']}, com: {load['com']}}}}}\n"
        section = resimulate.get_section(text, "effects")
        indent = re.search(r"\n( *)-", section)
        line = (indent[1] if indent else "  ") + item
        text = text.replace(section, section.rstrip("\n") + "\n" + line, 1) if section else text.rstrip("\n") + "\neffects:\n" + line
    return text


def make_scenario(text, folder, commands, end):
    """The scenario as it plays these commands; the drives are told between them what a cubic through them says. Each motion
    has noise of its own: the same noise in a held-out recording would confirm what was fitted to it."""
    for key in ("controller", "steps", "interpolation", "recordings", "logging", "initial", "seed"):
        text = resimulate.drop_section(text, key)
    text = re.sub(r"(?m)^robot:\s*(\S+)", lambda m: f"robot: {(folder / m[1]).resolve()}", text)
    return (text.rstrip("\n") + f"\ncontroller: {{motion: {commands.resolve()}}}\n"
            f"steps: {{time_step: {STEP:g}, control_period: 0.004, duration: {end:.10g}}}\ninterpolation: hermite\n"
            f"seed: {zlib.crc32(commands.name.encode()) % 2**31}\n")


def drop_rest(table):
    first = next(k for k, t in enumerate(table["time"]) if t >= REST - 1e-9)
    origin = table["time"][first]
    return {name: [t - origin for t in column[first:]] if name == "time" else column[first:] for name, column in table.items()}


def play(options, commands, recording, stop=None, loads=()):
    """Writes `recording`; False when the robot was stopped."""
    if options.against.suffix not in (".yaml", ".yml"):
        call(shlex.split(str(options.against)) + [commands, recording])
        return True
    scenario, shifted = recording.with_suffix(".yaml"), recording.with_suffix(".commands.csv")
    end = shift(commands, shifted)
    scenario.write_text(make_scenario(hang(options.against.read_text(), loads), options.against.parent, shifted, end))
    log = recording.with_suffix(".mcap")
    call([options.bin / "hrp-simulate", scenario, "--in-process", "--log", log, "--force", "--no-plot", "--quiet"], quiet=True)
    table = drop_rest(resimulate.read_table(options.bin, log, recording.parent)[0])
    rows, whole = find_stop(table, stop or {}), len(table["time"])
    write_table(recording, {name: column[:rows] for name, column in table.items()}, read_names(options.experiment))
    for leftover in [scenario, shifted, log] + list(recording.parent.glob("*_as_table.csv")):
        leftover.unlink()
    return rows == whole


def find_stop(table, stop):
    """Rows until a joint is further from its command than the proposal allows: there somebody stops the robot."""
    rows = len(table["time"])
    for joint, most in stop.items():
        command, position = (table.get(f"/joint_{kind}/{joint}/position") for kind in ("commands", "states"))
        if command and position:
            rows = next((k for k in range(rows) if abs(command[k] - position[k]) > most), rows)
    return rows


def write_table(path, table, names):
    kept = [name for name in table if name == "time" or names is None or name in names]
    with open(path, "w") as out:
        out.write(",".join(kept) + "\n")
        for row in zip(*(table[name] for name in kept)):
            out.write(",".join("" if x != x else f"{x:.9g}" for x in row) + "\n")


def read_names(experiment):
    """Columns of the first recording that is a table: a simulation records no more than the robot did."""
    for file in re.findall(r"file:\s*([^,}\s]+)", resimulate.get_section(experiment.read_text(), "recordings")):
        if file.endswith(".csv"):
            return (experiment.parent / file).read_text().split("\n", 1)[0].strip().split(",")
    return None


def add_recording(experiment, name, line):
    text = experiment.read_text()
    section = resimulate.get_section(text, "recordings").rstrip("\n")
    if not section:
        sys.exit(f"next_rounds.py: {experiment} lists no recordings")
    indent = re.search(r"\n( *)-", section)
    line = re.sub(r"file: [^,]+", f"file: {name}", line)
    experiment.write_text(text.replace(section, section + "\n" + (indent[1] if indent else "  ") + line, 1))


def diagnose(options, experiment, out, propose):
    words = [options.bin / "hrp-diagnose", experiment, "--out", out] + options.options
    # A program has nobody to hang a load on the robot.
    alone = ["--limit", "load=0"] if options.against.suffix not in (".yaml", ".yml") else []
    call(words + (["--next"] + alone if propose else []))
    return json.loads((out / "next/next.json").read_text()) if propose else {}


def run_round(options, experiment, number):
    """False when nothing is proposed."""
    out = options.out / f"round_{number}"
    proposal = diagnose(options, experiment, out, True)
    if not proposal["motions"]:
        print(f"Round {number}: no motion. {proposal['nothing']}")
        return False
    for motion in proposal["motions"]:
        name = f"round_{number}_" + motion["file"]
        whole = play(options, out / "next" / motion["file"], experiment.parent / name, motion.get("stop"), motion["loads"])
        add_recording(experiment, name, motion["line"])
        print(f"Round {number}: played {motion['file']} ({motion['sentence']}), added as {name}"
              + ("" if whole else "; a joint left its command: stopped"), flush=True)
    return True


def refuse(why):
    print(f"diagnose.sh: {why}", file=sys.stderr)
    sys.exit(2)


def copy_experiment(options):
    """The experiment in OUT/experiment, in the place of an earlier dialogue's, and of nothing else."""
    given, folder = options.experiment.parent.resolve(), options.out.resolve() / "experiment"
    if given == folder or folder in given.parents:
        refuse(f"--out: {folder} holds the experiment itself; expected another folder")
    if folder.exists() and not (options.out / "round_1").is_dir():
        refuse(f"--out: {folder} is there already, and is of no earlier dialogue; expected another folder")
    # Each motion becomes a line of this list.
    if not re.search(r"\n *-", resimulate.get_section(options.experiment.read_text(), "recordings")):
        refuse(f"{options.experiment}: recordings: expected one recording a line, each behind '- '")
    # OUT may lie in the experiment's own folder.
    inside = lambda parent, names: [name for name in names if (pathlib.Path(parent) / name).resolve() == options.out.resolve()]
    try:
        (options.out / "round_1").mkdir(parents=True, exist_ok=True)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(given, folder, ignore=inside)
    except OSError as error:
        refuse(f"--out: {folder}: {error.strerror or error}")
    return folder / options.experiment.name


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("experiment", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("rounds", type=int)
    parser.add_argument("against", type=pathlib.Path)
    options, options.options = parser.parse_known_args()
    experiment = copy_experiment(options)
    for number in range(1, options.rounds + 1):
        if not run_round(options, experiment, number):
            return
    diagnose(options, experiment, options.out / "final", False)


if __name__ == "__main__":
    main()
