# SPDX-License-Identifier: BSD-3-Clause
"""Runs a scenario through the server set, with a controller that somebody else starts in the place of ours. The program
joins over DDS as it would join a robot: it gets `--domain N`, or N in the place of {domain} in its arguments."""
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import threading
import time

POLL = 0.1  # [s] between two looks at programs that run
ORDERLY = 10.0  # [s] in which a program may end by itself when it is asked to


class LoopError(Exception):
    """The loop cannot be closed; says why in words for people."""


class Controller:
    """What closes the loop: a program with its arguments, and the `controller:` section that it may read."""

    def __init__(self, words, bin_folder):
        """words: "PROGRAM ARGUMENT ...", or a scenario: our walking controller with that scenario's settings."""
        self.settings = None
        if words.endswith((".yaml", ".yml")):
            self.settings = pathlib.Path(words)
            if not self.settings.is_file():
                raise LoopError(f"--controller: no file {words}")
            words = "hrp-controller"
        try:
            self.words = shlex.split(words)
        except ValueError as error:
            raise LoopError(f"--controller: cannot be split into words: {words} ({error})") from error
        if not self.words:
            raise LoopError("--controller wants a program with its arguments, or a scenario")
        self.words[0] = find_program(self.words[0], bin_folder)

    def name(self):
        return pathlib.Path(self.words[0]).name

    def fill(self, domain):
        if any("{domain}" in word for word in self.words):
            return [word.replace("{domain}", str(domain)) for word in self.words]
        return self.words + ["--domain", str(domain)]


def find_program(name, bin_folder):
    """Of this tree, of the path, or where it says; and it must be a program."""
    own = pathlib.Path(bin_folder) / name
    found = str(own) if "/" not in name and own.is_file() else shutil.which(name)
    if found:
        return found
    if pathlib.Path(name).exists():
        raise LoopError(f"--controller: {name} is there but is no program that can be started (chmod +x?)")
    raise LoopError(f"--controller: no program {name}, neither as a path nor in {bin_folder} nor in PATH")


def stop(process):
    """Asks a program that we started to end, and ends it when it does not."""
    if process.poll() is not None:
        return
    process.terminate()
    try:
        process.wait(ORDERLY)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def say_end(status):
    return f"was ended by signal {-status}" if status < 0 else f"ended with status {status}"


def read_tail(path, count=5):
    lines = pathlib.Path(path).read_text(errors="replace").strip().splitlines()[-count:]
    return "".join("\n    " + line for line in lines) if lines else " It said nothing."


class ServerSet:
    """hrp-simulate that leaves the controller's place free."""

    def __init__(self, bin_folder, scenario, log):
        self.bin, self.output, self.domain = pathlib.Path(bin_folder), [], None
        self.process = subprocess.Popen(
            [str(self.bin / "hrp-simulate"), str(scenario), "--without", "controller", "--log", str(log), "--force", "--no-plot", "--quiet"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.output.append(line.rstrip())
            found = re.search(r"place of controller is free, on DDS domain (\d+)", line)
            if found:
                self.domain = int(found[1])

    def wait_for_place(self):
        while self.domain is None and self.process.poll() is None:
            time.sleep(POLL)
        if self.domain is None:
            self.reader.join(ORDERLY)
            raise LoopError("the server set did not start:\n" + "\n".join(self.output))
        return self.domain

    def ends_within(self, seconds):
        """A controller hears of the run's end before the set has closed its log, which takes long on a busy machine."""
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            return False
        return True

    def find_step(self):
        """Of the physics, 0 while nobody has answered, None when the run does not tell."""
        try:
            status = subprocess.run([str(self.bin / "hrp-run"), "status", "--domain", str(self.domain)],
                                    capture_output=True, text=True, timeout=ORDERLY).stdout
        except subprocess.TimeoutExpired:
            return None
        found = re.search(r"step (\d+) t = ([\d.]+)", status)
        return (int(found[1]), float(found[2])) if found else None


def watch(servers, program, controller, words, patience):
    """Until the run has ended; raises when the controller dies or gives no answer for `patience` seconds."""
    step, since, looked = None, time.monotonic(), 0.0
    while servers.process.poll() is None:
        if program.poll() is not None:
            if not servers.ends_within(ORDERLY if program.returncode == 0 else 10 * POLL):
                at = step[1] if step else 0.0
                raise LoopError(f"controller {controller.name()} {say_end(program.returncode)} at t = {at:.3f} s, "
                                f"before the run had ended. It said last:{read_tail(words)}")
        now = time.monotonic()
        if now - looked > 1.0:
            looked, found = now, servers.find_step()
            if found != step:
                step, since = found, now
        if now - since > patience:
            at = step[1] if step else 0.0
            what = "never answered" if at == 0.0 else f"gave no answer any more at t = {at:.3f} s"
            raise LoopError(f"controller {controller.name()} runs but {what} (waited {patience:g} s): it must read "
                            f"hrp/sensor_data on DDS domain {servers.domain} and answer each sample with hrp/joint_commands "
                            f"(docs/client_in_c.md). It said last:{read_tail(words)}")
        time.sleep(POLL)


def run(bin_folder, scenario, log, controller, patience):
    """The run's last words. The log is there, up to the end or up to where a server gave up."""
    with tempfile.NamedTemporaryFile("w+", suffix=".txt") as words:
        servers, program = ServerSet(bin_folder, scenario, log), None
        try:
            domain = servers.wait_for_place()
            program = subprocess.Popen(controller.fill(domain), stdout=words, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
            watch(servers, program, controller, words.name, patience)
        except OSError as error:
            raise LoopError(f"controller {controller.name()} cannot be started: {error}") from error
        finally:
            if program:
                stop(program)
            stop(servers.process)
        servers.reader.join(ORDERLY)
        return servers.process.returncode, "\n".join(servers.output)
