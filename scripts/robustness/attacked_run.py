# SPDX-License-Identifier: BSD-3-Clause
"""A run of the server set that is to be attacked: its processes, its log, and faults of the system under it."""
import functools
import os
import re
import resource
import signal
import subprocess
import tempfile
import time

SERVERS = {"hrp-scheduler": "scheduler", "hrp-logger": "logger", "hrp-dynamics": "dynamics",
           "hrp-collision-checker": "collision_checker", "hrp-controller": "controller",
           "hrp-model-parser": "model_parser"}
DURATION = 2.0       # [s] simulated
STEP = 1e-3          # [s] of the scenario
LONGEST = 90.0       # [s] a run may take before it hangs, unless --patience says otherwise


def list_children(pid):
    try:
        with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
            return [int(word) for word in file.read().split()]
    except OSError:
        return []


def read_command(pid):
    """Words of its command line; none when it is gone."""
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            return file.read().decode(errors="replace").split("\0")[:-1]
    except OSError:
        return []


def find_program(pid):
    """Name of the program without its folder; empty when it is gone."""
    return os.path.basename((read_command(pid) or [""])[0])


def is_there(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@functools.lru_cache(maxsize=None)
def build_faulty_system():
    """The library that faulty_system.c describes; its folder goes with this program."""
    folder = tempfile.TemporaryDirectory(prefix="hrp-attack-")
    library = os.path.join(folder.name, "faulty_system.so")
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "faulty_system.c")
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, source, "-lpthread"], check=True)
    return folder, library


def make_faults(faults):
    """Environment of a run with such faults: {"CLOCK": "apart"}."""
    return {"LD_PRELOAD": build_faulty_system()[1], **{f"HRP_FAULT_{name}": value for name, value in faults.items()}}


class Run:
    """A run of the server set, started with its log in `folder`."""

    longest = LONGEST

    def __init__(self, bin_folder, scenario, folder, options, file_limit=None, faults=None):
        self.bin = bin_folder
        self.log = os.path.join(folder, "run.mcap")
        self.start = time.monotonic()
        command = [os.path.join(bin_folder, "hrp-simulate"), scenario, "--duration", str(DURATION), "--log", self.log,
                   "--force", "--no-plot", "--quiet"] + options

        def limit():
            if file_limit is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (file_limit, file_limit))

        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, preexec_fn=limit,
                                        env={**os.environ, **make_faults(faults)} if faults else None)
        self.output = ""

    def servers(self):
        return {SERVERS[find_program(p)]: p for p in list_children(self.process.pid) if find_program(p) in SERVERS}

    def wait_for_servers(self):
        while self.process.poll() is None and len(self.servers()) < len(SERVERS):
            if time.monotonic() - self.start > self.longest:
                break
            time.sleep(0.002)
        return self.servers()

    def finish(self):
        """False when it hangs; it is gone then."""
        try:
            self.output, _ = self.process.communicate(timeout=self.longest)
            return True
        except subprocess.TimeoutExpired:
            for pid in list(self.servers().values()) + [self.process.pid]:
                os.kill(pid, signal.SIGKILL)
            self.output, _ = self.process.communicate()
            return False

    def find_domain(self):
        """Of the servers, from a command line; None when the run is over before it has any."""
        while self.process.poll() is None:
            for pid in list_children(self.process.pid):
                words = read_command(pid)
                if "--domain" in words:
                    return words[words.index("--domain") + 1]
            time.sleep(0.002)
        return None

    def read_log(self):
        """Last step in the log, None where it cannot be read."""
        info = subprocess.run([os.path.join(self.bin, "hrp-log"), "info", self.log], capture_output=True, text=True)
        found = re.search(r"hrp/robot_state +\S+ +\d+ +\S+ +\d+ +(\d+)", info.stdout)
        return int(found.group(1)) if found else None

    def judge_hash(self, wanted):
        """Of a run that ended with status 0."""
        return "" if self.hash() == wanted else f"status 0 with another hash ({self.hash() or 'none'}): {self.output.strip()[-400:]}"

    def hash(self):
        found = re.search(r"state hash (\w+)", self.output)
        return found.group(1) if found else ""

    def step_of_end(self):
        """The step at which the launcher says that the run ended, None where it does not say."""
        found = re.search(r"\(at step (\d+)\)", self.output)
        return int(found.group(1)) if found else None
