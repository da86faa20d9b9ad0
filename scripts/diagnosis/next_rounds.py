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

import resimulate


def call(words, quiet=False):
    run = subprocess.run([str(w) for w in words], capture_output=quiet, text=True)
    if run.returncode:
        sys.stderr.write((run.stdout or "") + (run.stderr or "") if quiet else "")
        sys.exit(run.returncode)


def find_end(commands):
    return float(commands.read_text().strip().splitlines()[-1].split(",")[0])


def make_scenario(text, folder, commands):
    """The scenario as it plays these commands from its first frame on."""
    for key in ("controller", "steps", "recordings", "logging", "initial"):
        text = resimulate.drop_section(text, key)
    text = re.sub(r"(?m)^robot:\s*(\S+)", lambda m: f"robot: {(folder / m[1]).resolve()}", text)
    return (text.rstrip("\n") + f"\ncontroller: {{motion: {commands.resolve()}}}\n"
            f"steps: {{time_step: 0.001, control_period: 0.004, duration: {find_end(commands):.10g}}}\n")


def play(options, commands, recording):
    """Writes `recording`; its suffix says what it is."""
    if options.against.suffix not in (".yaml", ".yml"):
        call(shlex.split(str(options.against)) + [commands, recording])
        return
    scenario = recording.with_suffix(".yaml")
    scenario.write_text(make_scenario(options.against.read_text(), options.against.parent, commands))
    log = recording.with_suffix(".mcap")
    call([options.bin / "hrp-simulate", scenario, "--in-process", "--log", log, "--force", "--no-plot", "--quiet"], quiet=True)
    table = resimulate.read_table(options.bin, log, recording.parent)[0]
    write_table(recording, table, read_names(options.experiment))
    for leftover in [scenario, log] + list(recording.parent.glob("*_as_table.csv")):
        leftover.unlink()


def read_names(experiment):
    """Columns of the first recording that is a table: a simulation records no more than the robot did."""
    for file in re.findall(r"file:\s*([^,}\s]+)", resimulate.get_section(experiment.read_text(), "recordings")):
        if file.endswith(".csv"):
            return (experiment.parent / file).read_text().split("\n", 1)[0].strip().split(",")
    return None


def write_table(path, table, names):
    kept = [name for name in table if name == "time" or names is None or name in names]
    with open(path, "w") as out:
        out.write(",".join(kept) + "\n")
        for row in zip(*(table[name] for name in kept)):
            out.write(",".join("" if x != x else f"{x:.9g}" for x in row) + "\n")



def add_recording(experiment, name, role):
    text = experiment.read_text()
    section = resimulate.get_section(text, "recordings").rstrip("\n")
    if not section:
        sys.exit(f"next_rounds.py: {experiment} lists no recordings")
    indent = re.search(r"\n( *)-", section)
    line = f"{indent[1] if indent else '  '}- {{file: {name}, role: {role}}}"
    experiment.write_text(text.replace(section, section + "\n" + line, 1))


def diagnose(options, experiment, out, propose):
    words = [options.bin / "hrp-diagnose", experiment, "--out", out] + options.options
    call(words + (["--next"] if propose else []))
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
        play(options, out / "next" / motion["file"], experiment.parent / name)
        add_recording(experiment, name, motion["role"])
        print(f"Round {number}: played {motion['file']} ({motion['sentence']}), added as {name}")
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("experiment", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("rounds", type=int)
    parser.add_argument("against", type=pathlib.Path)
    options, options.options = parser.parse_known_args()
    if options.against.suffix in (".yaml", ".yml") and not options.against.is_file():
        print(f"diagnose.sh: --against: no file {options.against}", file=sys.stderr)
        sys.exit(2)
    folder = options.out / "experiment"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(options.experiment.parent, folder)
    experiment = folder / options.experiment.name
    for number in range(1, options.rounds + 1):
        if not run_round(options, experiment, number):
            return
    diagnose(options, experiment, options.out / "final", False)


if __name__ == "__main__":
    main()
