#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""run_commands_test.py SOURCE BUILD DOCUMENT ...: runs every command that the documents tell their readers to run.

Each command works as it stands there, or with the change that rules.py shows. One that nobody has said how to run is a
failure.
"""
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

import commands
import fixtures
import rules

PATIENCE = 120  # [s] only for what never ends


class Failure(Exception):
    pass


class Started:
    """A command in a process group of its own, with its output in a file."""

    def __init__(self, command, session):
        self.command = command
        self.output_file = session.folder / f"output-{session.count}.txt"
        session.count += 1
        with open(self.output_file, "wb") as output:
            self.process = subprocess.Popen(["bash", "-c", "\n".join(session.environment + [command])], cwd=session.folder,
                                            stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True)

    def output(self):
        return self.output_file.read_text(errors="replace")

    def wait_for(self, said):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            found = re.search(said, self.output())
            if found:
                return found
            if self.process.poll() is not None:
                break
            time.sleep(0.02)
        raise Failure(f"'{self.command}' did not print '{said}':\n{self.output()}")

    def finish(self, status=0):
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.end()
            raise Failure(f"'{self.command}' does not end:\n{self.output()}") from None
        if self.process.returncode != status:
            raise Failure(f"'{self.command}' ended with status {self.process.returncode}:\n{self.output()}")

    def interrupt(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGINT)

    def end(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGTERM)
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(self.process.pid, signal.SIGKILL)


class Session:
    """The reader's terminals: what is set, what runs."""

    def __init__(self, folder, source):
        self.folder = folder
        self.source = source
        self.environment = []
        self.count = 0
        self.offered = None  # waits for a joiner
        self.beside = None   # goes on while others look

    def start(self, command):
        fixtures.provide(command, self.folder, self.source)
        return Started(command, self)

    def start_run(self):
        """A run that goes on, for those who look or steer."""
        if self.beside and self.beside.process.poll() is None:
            return self.beside
        scenario = self.source / "models/scenarios/hrp2p_stand.yaml"
        self.beside = Started(f"exec build/bin/hrp-simulate {scenario} --duration 0 --realtime --no-plot --log beside-{self.count}.mcap", self)
        self.beside.wait_for(r"running")
        return self.beside

    def end_run(self):
        if self.beside:
            self.beside.interrupt()
            self.beside.finish()
        self.beside = None

    def run(self, command):
        rule = rules.find_rule(command)
        if not rule:
            raise Failure(f"'{command}': no rule says how to run it; add one to tests/documents/rules.py")
        changed = rules.change(rule, command)
        if changed != command:
            print(f"    as: {changed}", flush=True)
        getattr(self, "run_" + rule.how)(changed)

    def run_environment(self, command):
        self.environment.append(command)

    def run_runs(self, command):
        self.start(command).finish()

    def run_beside(self, command):
        self.start_run()
        self.start(command).finish()

    def run_watches(self, command):
        self.end_run()  # a fresh one, that is not paused
        self.start_run()
        watcher = self.start(command)
        try:
            watcher.wait_for(r"\n")
            self.end_run()
            watcher.finish()
        finally:
            watcher.end()

    def run_serves(self, command):
        if not re.search(r"mcap|experiment", command):
            self.start_run()
        server = self.start(command)
        try:
            address = server.wait_for(r"http://\S+").group(0)
            with urllib.request.urlopen(address, timeout=PATIENCE) as page:
                if page.status != 200:
                    raise Failure(f"'{command}': {address} answers {page.status}")
            server.interrupt()
            server.finish()
        finally:
            server.end()

    def run_offers(self, command):
        self.end_run()
        self.offered = self.start(command)
        self.offered.wait_for(r"To join")

    def run_joins(self, command):
        if not self.offered:
            raise Failure(f"'{command}': no run waits for it")
        joiner = self.start(command)
        try:
            self.offered.finish()
            joiner.finish()
        finally:
            joiner.end()
        self.offered = None

    def close(self):
        if self.offered:
            self.offered.end()
        if self.beside:
            self.beside.end()


def run_document(path, folder, source):
    session = Session(folder, source)
    failures = []
    for name, text in commands.find_files(path):
        (folder / name).write_text(text)
    try:
        for number, command in commands.find_commands(path):
            start = time.monotonic()
            print(f"{path.name}:{number}: {command}", flush=True)
            try:
                session.run(command)
            except Failure as failure:
                failures.append(f"{path.name}:{number}: {failure}")
            print(f"    {time.monotonic() - start:.1f} s", flush=True)
        if session.offered:
            failures.append(f"{path.name}: '{session.offered.command}' waits for a joiner that the document does not start")
    finally:
        session.close()
    return failures


def main():
    source, build = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    failures = []
    for document in sys.argv[3:]:
        with tempfile.TemporaryDirectory(prefix="hrp-documents-") as parent:
            os.makedirs(f"{parent}/runtime", mode=0o700)
            os.environ["XDG_RUNTIME_DIR"] = f"{parent}/runtime"  # runs of others on this machine are not seen
            os.environ.pop("HRP_BUILD_DIR", None)
            os.makedirs(f"{parent}/tree")
            failures += run_document(source / document, fixtures.make_folder(f"{parent}/tree", source, build), source)
    print("\n".join(failures) if failures else "every command works")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
