# SPDX-License-Identifier: BSD-3-Clause
"""Looks at the servers of a long run; scripts/soak.sh says how to call it."""
import argparse
import csv
import os
import re
import subprocess
import sys
import time

from attack import SERVERS, find_program, list_children

STEP = 1e-3          # [s] of the scenario
GROWTH = 0.02        # share of the memory: what an allocator may still take from the system late
LEAST_GROWTH = 1024  # [kB] below which a share says nothing
INDEX = 16           # [B] that a step may cost the logger: the places of its chunks, which the log's end lists


def read_status(pid):
    """Memory that is held [kB], threads, open files; None when the process is gone."""
    try:
        with open(f"/proc/{pid}/status", encoding="ascii", errors="replace") as file:
            text = file.read()
        files = len(os.listdir(f"/proc/{pid}/fd"))
    except OSError:
        return None
    memory, threads = re.search(r"VmRSS:\s+(\d+)", text), re.search(r"Threads:\s+(\d+)", text)
    return (int(memory.group(1)), int(threads.group(1)), files) if memory and threads else None


def look(launcher, bin_folder, start):
    """A row for each server, with the step that the run has reached."""
    status = subprocess.run([os.path.join(bin_folder, "hrp-run"), "--run", str(launcher.pid), "status"], capture_output=True, text=True)
    found = re.search(r"step\D+(\d+)", status.stdout)
    rows = []
    for pid in list_children(launcher.pid) + [launcher.pid]:
        program, state = find_program(pid), read_status(pid)
        if state and (program in SERVERS or pid == launcher.pid):
            rows.append({"seconds": round(time.monotonic() - start, 1), "step": int(found.group(1)) if found else "",
                         "program": program, "memory_kB": state[0], "threads": state[1], "files": state[2]})
    return rows


def mean(values):
    return sum(values) / len(values)


def judge(rows):
    """Table of the middle and the last third of the looks. Returns how many servers grow."""
    times = sorted({row["seconds"] for row in rows})
    if len(times) < 9:
        sys.exit("soak.sh: too few looks to compare: more --steps, or a smaller --every")
    middle, last = times[len(times) // 3], times[2 * len(times) // 3]
    grown = 0
    steps = [mean([row["step"] for row in rows if row["step"] != "" and begin <= row["seconds"] < end]) for begin, end in
             ((middle, last), (last, 1e18))]
    print("| program | memory, middle third | last third | threads | open files |\n|---|---|---|---|---|")
    for program in sorted({row["program"] for row in rows}):
        def values(key, begin, end):
            return [row[key] for row in rows if row["program"] == program and begin <= row["seconds"] < end]
        before, after = mean(values("memory_kB", middle, last)), mean(values("memory_kB", last, 1e18))
        threads, files = ([max(values(key, *part)) for part in ((middle, last), (last, 1e18))] for key in ("threads", "files"))
        index = INDEX * (steps[1] - steps[0]) / 1024 if program == "hrp-logger" else 0
        grows = after - before - index > max(LEAST_GROWTH, GROWTH * before) or threads[1] > threads[0] or files[1] > files[0]
        grown += grows
        print(f"| {program} | {before / 1024:.1f} MB | {after / 1024:.1f} MB{' grows' if grows else ''} | "
              f"{threads[0]}, {threads[1]} | {files[0]}, {files[1]} |")
    return grown


def print_rate(rows):
    known = sorted({(row["seconds"], row["step"]) for row in rows if row["step"] != ""})
    third = len(known) // 3
    for name, (begin, end) in {"first": (0, third), "middle": (third, 2 * third), "last": (2 * third, len(known) - 1)}.items():
        (t0, s0), (t1, s1) = known[begin], known[end]
        print(f"{name} third: {(s1 - s0) / max(1e-9, t1 - t0):.0f} steps/s")


def watch(launcher, options, start):
    rows = []
    while launcher.poll() is None:
        time.sleep(options.every)
        rows += look(launcher, options.bin, start)
        if rows and rows[-1]["step"] != "" and sys.stderr.isatty():
            done = rows[-1]["step"] / options.steps
            left = (time.monotonic() - start) * (1 - done) / max(1e-9, done)
            sys.stderr.write(f"\r\x1b[Kstep {rows[-1]['step']} of {options.steps}, about {left:.0f} s left")
    return rows


def main():
    parser = argparse.ArgumentParser(prog="soak.sh")
    parser.add_argument("bin")
    parser.add_argument("scenario")
    parser.add_argument("--steps", type=int, default=10_000_000)
    parser.add_argument("--dds", default="cyclone", choices=["cyclone", "fast"])
    parser.add_argument("--every", type=float, default=5.0)
    parser.add_argument("--out")
    options = parser.parse_args()
    start = time.monotonic()
    launcher = subprocess.Popen([os.path.join(options.bin, "hrp-simulate"), options.scenario, "--duration", str(options.steps * STEP),
                                 "--dds", options.dds, "--log", "/dev/null", "--no-plot", "--quiet"], stdout=subprocess.DEVNULL)
    try:
        rows = watch(launcher, options, start)
    finally:
        launcher.terminate()
    rows = [row for row in rows if launcher.returncode == 0 and row["seconds"] < time.monotonic() - start]
    if launcher.returncode != 0:
        sys.exit(f"soak.sh: the run ended with status {launcher.returncode}")
    if options.out:
        with open(options.out, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, fieldnames=list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    print_rate(rows)
    return 1 if judge(rows) else 0


if __name__ == "__main__":
    sys.exit(main())
