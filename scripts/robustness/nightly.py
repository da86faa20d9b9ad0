# SPDX-License-Identifier: BSD-3-Clause
"""The long checks one after the other; scripts/nightly.sh says how to call it."""
import argparse
import dataclasses
import datetime
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCRIPTS = ROOT / "scripts"
TARGETS = sorted(path.stem for path in (ROOT / "tests/fuzz").glob("*.cpp"))
FAULTS = ["disk", "slow", "reads", "read_only", "clock", "memory", "memory_here"]
NO_LIMIT = 1_000_000_000  # executions: the time ends a target


def read_cells(text):
    """Rows of the tables in a text, without heads."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]
    return [row for row in rows if len(row) > 2 and row[1].isdigit()]


def count_fuzz(text):
    """A target that found something may not say how many executions it made."""
    rows = [line.strip("|").split("|") for line in text.splitlines() if re.match(r"\| *\w+ *\|[\d ]*\|", line)]
    return sum(int(row[1]) for row in rows if row[1].strip()), sum(row[-1].strip() != "none" for row in rows)


def count_rows(text):
    rows = read_cells(text)
    return sum(int(row[1]) for row in rows), sum(int(row[2]) for row in rows)


def count_soak(text):
    """One try: a run. Its failures are the servers that grow."""
    rows = re.findall(r"^\| (hrp-\S+) \|.*", text, re.M)
    return int(bool(rows)), len(re.findall(r"^\| hrp-\S+ \|.* grows \|", text, re.M))


def count_tests(text):
    found = re.findall(r"tests passed, (\d+) tests? failed out of (\d+)", text)
    return sum(int(tests) for _, tests in found), sum(int(failed) for failed, _ in found)


def count_mutations(text):
    """A broken equation whose test does not fail is a failure."""
    lines = [line for line in text.splitlines() if " -> " in line]
    return len(lines), sum(not re.match(r".{18} fails ", line) for line in lines)


@dataclasses.dataclass
class Step:
    name: str
    command: list
    count: object  # text of the log -> (tries, failures)


def make_steps(options):
    seconds = max(1, round(60 * options.minutes / len(TARGETS)))
    tries = ["--tries", options.tries, "--seed", options.seed]
    steps = [
        Step("fuzz", [SCRIPTS / "fuzz.sh", "--runs", NO_LIMIT, "--seconds", seconds, "--seed", options.seed], count_fuzz),
        Step("kills", [SCRIPTS / "attack.sh", "kill", "stop", "launcher", "together", "junk", *tries, "--out", options.out / "kills.csv"], count_rows),
        Step("faults", [SCRIPTS / "attack.sh", *FAULTS, *tries, "--out", options.out / "faults.csv"], count_rows),
        Step("soak", [SCRIPTS / "soak.sh", "--steps", options.steps, "--out", options.out / "soak.csv"], count_soak),
        Step("sanitize", [SCRIPTS / "sanitize.sh", "address,undefined"], count_tests),
        Step("threads", [SCRIPTS / "sanitize.sh", "thread"], count_tests),
        Step("tidy", [SCRIPTS / "tidy.sh", "--all"], count_rows),
        Step("long", [SCRIPTS / "test.sh", "-C", "nightly", "-L", "nightly"], count_tests),
        Step("mutations", [SCRIPTS / "mutate_equations.py"], count_mutations),
    ]
    return [Step(step.name, [str(word) for word in step.command], step.count) for step in steps]


def call(command, log, limit):
    """Status of a command, None when it did not end within `limit` [s]: it and its children are gone then."""
    with open(log, "w", encoding="utf-8") as file:
        process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, start_new_session=True)
        try:
            return process.wait(timeout=limit)
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


def judge(status, tries, failures):
    if status is None:
        return "did not end"
    if failures:
        return "finding"
    if status or not tries:
        return "could not run"
    return "ok"


def run_step(step, options):
    log, start = options.out / f"{step.name}.log", time.monotonic()
    status = call(step.command, log, 60 * options.limit)
    text = log.read_text(encoding="utf-8", errors="replace")
    tries, failures = step.count(text)
    result = {"command": step.command, "result": judge(status, tries, failures), "tries": tries, "failures": failures,
              "seconds": round(time.monotonic() - start), "log": str(log)}
    if result["result"] != "ok":
        last = [line for line in text.splitlines() if line.strip()][-3:]
        print(f"{step.name}: {result['result']}, see {log}", *last, sep="\n  ", file=sys.stderr, flush=True)
    return result


def print_table(results):
    print("| step | result | tries | failures | seconds | log |\n|---|---|---|---|---|---|")
    for name, result in results.items():
        print(f"| {name} | {result['result']} | {result['tries']} | {result['failures']} | {result['seconds']} | {os.path.relpath(result['log'])} |")


def run(steps, options):
    """Results by step. They are in results.json after each one, for --resume."""
    store = options.out / "results.json"
    before = json.loads(store.read_text(encoding="utf-8")) if options.resume and store.is_file() else {}
    results = {}
    for step in steps:
        known = before.get(step.name, {})
        if known.get("result") == "ok":
            results[step.name] = known
            continue
        print(f"{step.name}: {' '.join(step.command)}", file=sys.stderr, flush=True)
        results[step.name] = run_step(step, options)
        store.write_text(json.dumps({**before, **results}, indent=1) + "\n", encoding="utf-8")
    return results


def read_options():
    names = [step.name for step in make_steps(argparse.Namespace(minutes=1, tries=1, steps=1, seed=1, out=pathlib.Path()))]
    parser = argparse.ArgumentParser(prog="nightly.sh")
    parser.add_argument("--only", type=lambda text: text.split(","), default=names)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--tries", type=int, default=100)
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=int(datetime.date.today().strftime("%Y%m%d")))
    parser.add_argument("--limit", type=float, default=240.0)
    parser.add_argument("--out", type=lambda text: pathlib.Path(text).resolve(), default=ROOT / "out/nightly")
    parser.add_argument("--resume", action="store_true")
    options = parser.parse_args()
    unknown = sorted(set(options.only) - set(names))
    if unknown:
        parser.error(f"there is no step {unknown[0]}: {', '.join(names)}")
    return options


def main():
    options = read_options()
    options.out.mkdir(parents=True, exist_ok=True)
    results = run([step for step in make_steps(options) if step.name in options.only], options)
    print_table(results)
    return 1 if any(result["result"] != "ok" for result in results.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
