# SPDX-License-Identifier: BSD-3-Clause
"""Attacks runs of the server set; scripts/attack.sh says how to call it."""
import argparse
import csv
import math
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

from attacked_run import DURATION, LONGEST, SERVERS, STEP, Run, find_program, is_there, list_children

FIRST_ALLOCATION = 1  # of main(): what libraries need before it nobody can answer for
MOST_ALLOCATIONS = 300000  # that are counted until one fails: about as many as a run makes
LOST_AT_MOST = 32    # steps that are not in the log when the logger dies
MOST_READS = 9       # of scenario and robot, by one program: about as many as there are
GRACE = 15.0         # [s] until servers without a launcher are gone
SIDE_BY_SIDE = 3     # runs at the same time: eighteen servers
# Where junk is written: what the loop of steps and those who steer read. The first one half of the time.
JUNK_TOPICS = ["hrp/contact_set", "hrp/joint_commands", "hrp/robot_state", "hrp/sensor_data", "hrp/contact_forces", "hrp/log_samples",
               "hrp/server_status", "hrp/step_grant", "hrp/run_control", "hrp/run_status"]


def draw_vendors(draw):
    """Options for Cyclone, Fast, or a mix."""
    kind = draw.choice(["cyclone", "fast", "mix"])
    if kind != "mix":
        return kind, ["--dds", kind]
    chosen = draw.sample(sorted(SERVERS.values()), 2)
    return kind, [word for role in chosen for word in ("--dds-for", f"{role}=fast")]


def send(pid, number):
    try:
        os.kill(pid, number)
        return True
    except ProcessLookupError:
        return False


class Attacker:
    def __init__(self, bin_folder, scenario, seed):
        self.bin, self.scenario = bin_folder, scenario
        self.draw = random.Random(seed)
        self.undisturbed = None

    def run(self, kind):
        """(what was done, complaint or "")"""
        vendor, options = draw_vendors(self.draw)
        with tempfile.TemporaryDirectory(prefix="hrp-attack-") as folder:
            what, complaint = getattr(self, kind)(folder, options)
        return f"{vendor}: {what}", complaint

    def find_undisturbed(self):
        """Hash of a run that nobody attacks, and how long it takes [s]."""
        if self.undisturbed is None:
            with tempfile.TemporaryDirectory(prefix="hrp-attack-") as folder:
                run = Run(self.bin, self.scenario, folder, [])
                if not run.finish() or run.process.returncode != 0:
                    sys.exit(f"attack.py: a run that nobody attacks fails:\n{run.output}")
                self.undisturbed = run.hash(), time.monotonic() - run.start
        return self.undisturbed

    def draw_moment(self):
        time.sleep(self.draw.uniform(0.0, 1.2 * self.find_undisturbed()[1]))

    def pick(self, run):
        servers = run.wait_for_servers()
        role = self.draw.choice(sorted(SERVERS.values()))
        self.draw_moment()
        return role, servers.get(role)

    def judge_end(self, run, role, hit):
        """Of a run in which a server died."""
        if not run.finish():
            return "it hangs"
        if run.process.returncode == 0:
            return run.judge_hash(self.find_undisturbed()[0])
        if not hit:
            return f"failed by itself: {run.output.strip()[-200:]}"
        if role not in run.output and f"hrp-{role}".replace("_", "-") not in run.output:
            return f"does not name {role}: {run.output.strip()[-200:]}"
        last, end = run.read_log(), run.step_of_end()
        if os.path.exists(run.log) and last is None and end:
            return "the log cannot be read"
        if last is not None and end is not None and end - last > LOST_AT_MOST:
            return f"the log ends {end - last} steps early"
        return ""

    def kill(self, folder, options):
        run = Run(self.bin, self.scenario, folder, options)
        role, pid = self.pick(run)
        hit = pid is not None and send(pid, signal.SIGKILL)
        return f"SIGKILL to {role}", self.judge_end(run, role, hit)

    def stop(self, folder, options):
        run = Run(self.bin, self.scenario, folder, options)
        role, pid = self.pick(run)
        pause = self.draw.uniform(0.0, 0.5)
        if pid is not None and send(pid, signal.SIGSTOP):
            time.sleep(pause)
            send(pid, signal.SIGCONT)
        what = f"{role} stands still for {pause:.2f} s"
        if not run.finish():
            return what, "it hangs"
        same = run.process.returncode == 0 and run.hash() == self.find_undisturbed()[0]
        return what, "" if same else f"status {run.process.returncode}, hash {run.hash()}: {run.output.strip()[-200:]}"

    def launcher(self, folder, options):
        run = Run(self.bin, self.scenario, folder, options)
        if self.draw.random() < 0.5:
            run.wait_for_servers()
        self.draw_moment()
        left = list_children(run.process.pid)
        send(run.process.pid, signal.SIGKILL)
        run.process.communicate()
        end = time.monotonic() + GRACE
        while any(is_there(p) and find_program(p) in SERVERS for p in left) and time.monotonic() < end:
            time.sleep(0.01)
        orphans = [find_program(p) for p in left if is_there(p) and find_program(p) in SERVERS]
        return "SIGKILL to the launcher", f"left behind: {' '.join(orphans)}" if orphans else ""

    def disk(self, folder, options):
        size = self.draw.randrange(0, 1500000)
        run = Run(self.bin, self.scenario, folder, options, file_limit=size)
        what = f"the log may have {size} bytes"
        if not run.finish():
            return what, "it hangs"
        if run.process.returncode == 0:
            return what, "status 0"
        if "run.mcap" not in run.output:
            return what, f"does not name the log: {run.output.strip()[-200:]}"
        said = re.search(r"ends with step (\d+)", run.output)
        last = run.read_log()
        if said and last != int(said.group(1)):
            return what, f"says step {said.group(1)}, the log ends with {last}"
        return what, ""

    def judge_junk(self, run):
        """Whoever writes junk may end a run, with words; nothing dies of it, and no other run comes out."""
        if not run.finish():
            return "it hangs"
        if run.process.returncode == 0:
            return run.judge_hash(self.find_undisturbed()[0])
        if run.process.returncode < 0 or "SIG" in run.output:
            return f"status {run.process.returncode}: {run.output.strip()[-400:]}"
        if not any(role in run.output for role in SERVERS.values()):
            return f"names nobody: {run.output.strip()[-200:]}"
        return "the log cannot be read" if os.path.exists(run.log) and run.read_log() is None and run.step_of_end() else ""

    def junk(self, folder, options):
        topics = JUNK_TOPICS[:1] if self.draw.random() < 0.5 else self.draw.sample(JUNK_TOPICS, 2)
        vendor = options[1] if options[0] == "--dds" else self.draw.choice(["cyclone", "fast"])
        run = Run(self.bin, self.scenario, folder, options + ["--realtime"])
        domain, seed = run.find_domain(), self.draw.randrange(1 << 30)
        what = f"junk on {' '.join(topics)} of {vendor}, seed {seed}"
        if domain is None:
            return what, self.judge_junk(run)
        writer = os.path.join(self.bin, "../tests/junk_writer")
        if not os.path.exists(writer):
            sys.exit("attack.py: scripts/build.sh --tests makes tests/junk_writer")
        with subprocess.Popen([writer, vendor, domain, str(seed), *topics], stdout=subprocess.DEVNULL) as junk:
            complaint = self.judge_junk(run)
            status = junk.poll()
            junk.kill()
        return what, complaint or ("" if status is None else f"junk_writer ended with status {status}")

    def together(self, folder, options):
        runs = []
        for number in range(SIDE_BY_SIDE):
            place = os.path.join(folder, str(number))
            os.mkdir(place)
            runs.append(Run(self.bin, self.scenario, place, options))
        complaints = [self.judge_same(run) for run in runs]
        return f"{SIDE_BY_SIDE} runs side by side", "; ".join(filter(None, complaints))

    def draw_memory_fault(self):
        n = int(math.exp(self.draw.uniform(math.log(FIRST_ALLOCATION), math.log(MOST_ALLOCATIONS))))
        return str(n) + self.draw.choice(["", "+"])

    def judge_same(self, run):
        """Of a run whose fault may cost time and nothing else."""
        if not run.finish():
            return "it hangs"
        if run.process.returncode == 0 and run.hash() == self.find_undisturbed()[0]:
            return "" if run.read_log() == round(DURATION / STEP) else f"the log ends with step {run.read_log()}"
        return f"status {run.process.returncode}, hash {run.hash()}: {run.output.strip()[-200:]}"

    def memory(self, folder, options):
        """The system's own libraries end a process without memory by abort(): of servers that is enough, the launcher names them."""
        role, fault = self.draw.choice(sorted(SERVERS.values())), self.draw_memory_fault()
        program = next(p for p, r in SERVERS.items() if r == role)
        run = Run(self.bin, self.scenario, folder, options, faults={"MALLOC": fault, "PROGRAM": program})
        return f"allocation {fault} of {role} fails", self.judge_end(run, role, True)

    def memory_here(self, folder, _):
        """In one process nothing but our own code runs out of memory: it says so and ends with a status."""
        fault = self.draw_memory_fault()
        run = Run(self.bin, self.scenario, folder, ["--in-process"], faults={"MALLOC": fault, "PROGRAM": "hrp-simulate"})
        what = f"allocation {fault} of hrp-simulate --in-process fails"
        if not run.finish():
            return what, "it hangs"
        status, hash_ = run.process.returncode, run.hash()
        if status < 0:
            return what, f"ended by signal {-status}: {run.output.strip()[-200:]}"
        if status == 0:
            return what, "" if not hash_ else run.judge_hash(self.find_undisturbed()[0])
        if "error" not in run.output and "hrp-simulate:" not in run.output:
            return what, f"does not say why: {run.output.strip()[-200:]}"
        last, end = run.read_log(), run.step_of_end()
        if last is not None and end is not None and end - last > LOST_AT_MOST:
            return what, f"the log ends {end - last} steps early"
        return what, ""

    def clock(self, folder, options):
        if self.draw.random() < 0.3:
            return "the wall clock jumps at each look, one process", self.judge_same(Run(self.bin, self.scenario, folder, ["--in-process"], faults={"CLOCK": "jumps"}))
        return "the wall clocks of the processes are up to an hour apart", self.judge_same(Run(self.bin, self.scenario, folder, options, faults={"CLOCK": "apart"}))

    def slow(self, folder, options):
        delay = self.draw.randrange(1000, 60000)
        return f"each write into the log takes {delay} us more", self.judge_same(Run(self.bin, self.scenario, folder, options, faults={"SLOW": str(delay)}))

    def reads(self, folder, options):
        """The start of a file is never taken for all of it."""
        program, number = self.draw.choice(["hrp-simulate", "hrp-model-parser", "one process"]), self.draw.randrange(1, MOST_READS)
        faults = {"READ": str(number), "PROGRAM": program.replace("one process", "hrp-simulate")}
        run = Run(self.bin, self.scenario, folder, ["--in-process"] if program == "one process" else options, faults=faults)
        what = f"read {number} of {program} and all later ones fail"
        if not run.finish():
            return what, "it hangs"
        if run.process.returncode == 0:
            return what, run.judge_hash(self.find_undisturbed()[0])
        said = re.search(r"\.(yaml|urdf): error: cannot be read", run.output)
        return what, "" if said else f"does not name the file: {run.output.strip()[-200:]}"

    def read_only(self, folder, options):
        run = Run(self.bin, self.scenario, folder, options, faults={"READ_ONLY": "1"})
        what = "the log's file system is read-only"
        if not run.finish():
            return what, "it hangs"
        if run.process.returncode != 2 or "Read-only" not in run.output or "run.mcap" not in run.output:
            return what, f"status {run.process.returncode}: {run.output.strip()[-200:]}"
        return what, f"leaves {os.path.getsize(run.log)} bytes there" if os.path.exists(run.log) else ""


def show_progress(kind, done, tries, failures, start):
    left = (time.monotonic() - start) / done * (tries - done)
    text = f"{kind}: {done} of {tries}, {failures} failed, about {left:.0f} s left"
    sys.stderr.write(f"\r\x1b[K{text}" if sys.stderr.isatty() else "")
    sys.stderr.flush()


def attack(attacker, kind, tries, rows):
    failures, start = 0, time.monotonic()
    for i in range(tries):
        what, complaint = attacker.run(kind)
        rows.append({"kind": kind, "try": i + 1, "what": what, "failed": complaint})
        if complaint:
            failures += 1
            print(f"{kind} {i + 1}: {what}: {complaint}", file=sys.stderr)
        show_progress(kind, i + 1, tries, failures, start)
    if sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K")
    print(f"| {kind} | {tries} | {failures} | {time.monotonic() - start:.0f} |", flush=True)
    return failures


def main():
    kinds = ["kill", "stop", "launcher", "together", "junk", "disk", "slow", "reads", "read_only", "clock", "memory", "memory_here"]
    parser = argparse.ArgumentParser(prog="attack.sh")
    parser.add_argument("bin")
    parser.add_argument("scenario")
    parser.add_argument("kind", nargs="*", choices=[[], *kinds], default=[])
    parser.add_argument("--tries", type=int, default=25)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--patience", type=float, default=LONGEST)
    parser.add_argument("--out")
    options = parser.parse_args()
    Run.longest = options.patience
    attacker, rows = Attacker(options.bin, options.scenario, options.seed), []
    attacker.find_undisturbed()  # alone: beside an attacked run it would take longer than those it is a measure for
    print("| attack | tries | failures | seconds |\n|---|---|---|---|")
    failures = sum(attack(attacker, kind, options.tries, rows) for kind in options.kind or kinds)
    if options.out:
        with open(options.out, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, fieldnames=["kind", "try", "what", "failed"])
            writer.writeheader()
            writer.writerows(rows)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
