#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""several_machines_test.py BIN SOURCE: the commands of docs/tutorials/several_machines.md on two machines.

The machines are network namespaces with a cable between them (veth), and a private folder each. Claims: the run ends by
itself, and its log holds the same states as the log of the same run in one process. Needs root."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
PAGE = SOURCE / "docs/tutorials/several_machines.md"
DURATION = "0.5"  # [s] simulated: a hundred control periods over the cable
LIMIT = 60        # [s] for all servers to end
ADDRESS = {"a": "192.168.1.10", "b": "192.168.1.11"}


def run(*command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


class Cable:
    """Two namespaces and a veth pair between them; gone at the end."""

    def __init__(self):
        self.names = {m: f"hrp-{os.getpid()}-{m}" for m in ADDRESS}

    def __enter__(self):
        for name in self.names.values():
            run("ip", "netns", "add", name)
        a, b = self.names["a"], self.names["b"]
        run("ip", "link", "add", "veth0", "netns", a, "type", "veth", "peer", "name", "veth0", "netns", b)
        for machine, name in self.names.items():
            for words in (["addr", "add", ADDRESS[machine] + "/24", "dev", "veth0"], ["link", "set", "veth0", "up"],
                          ["link", "set", "lo", "up"], ["route", "add", "224.0.0.0/4", "dev", "veth0"]):
                run("ip", "-n", name, *words)
        return self

    def __exit__(self, *_):
        for name in self.names.values():
            subprocess.run(["ip", "netns", "del", name], check=False)


def list_commands(vendor):
    """(machine, words) of the page's commands, with programs of this build."""
    text = PAGE.read_text()
    commands = re.findall(r"^([ab])\$ (build/bin/.*)$", text[text.index("## Servers on two machines"):], re.M)
    for machine, command in commands:
        words = shlex.split(command.replace("--dds cyclone", f"--dds {vendor}"))
        words[0] = str(BIN / pathlib.Path(words[0]).name)
        yield machine, [str(SOURCE / w) if w.startswith("models/") else w for w in words]


class SeveralMachines(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="hrp_machines_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def start(self, cable, machine, words):
        private = self.folder / machine
        private.mkdir(exist_ok=True, mode=0o700)
        environment = dict(os.environ, XDG_RUNTIME_DIR=str(private), HOME=str(private), TMPDIR=str(private))
        if pathlib.Path(words[0]).name == "hrp-scheduler":
            words = words + ["--duration", DURATION]
        output = open(self.folder / f"{pathlib.Path(words[0]).name}.txt", "w")
        self.addCleanup(output.close)
        return subprocess.Popen(["ip", "netns", "exec", cable.names[machine], *words], cwd=self.folder, env=environment,
                                stdout=output, stderr=subprocess.STDOUT)

    def said(self):
        return "\n".join(f"{f.name}: {f.read_text()[-600:]}" for f in self.folder.glob("*.txt"))

    def check(self, vendor):
        with Cable() as cable:
            servers = [self.start(cable, machine, words) for machine, words in list_commands(vendor)]
            self.assertEqual(len(servers), 6, "commands of the page")
            try:
                ends = [server.wait(timeout=LIMIT) for server in servers]
            except subprocess.TimeoutExpired:
                self.fail("the run did not end\n" + self.said())
            finally:
                for server in servers:
                    server.kill()
        self.assertEqual(ends, [0] * 6, self.said())
        scenario = str(SOURCE / "models/scenarios/squat.yaml")
        run(str(BIN / "hrp-simulate"), scenario, "--in-process", "--duration", DURATION, "--log", str(self.folder / "here.mcap"))
        compared = subprocess.run([str(BIN / "hrp-log"), "compare", str(self.folder / "run.mcap"), str(self.folder / "here.mcap")],
                                  capture_output=True, text=True)
        self.assertEqual(compared.returncode, 0, compared.stdout + compared.stderr)

    def test_cyclone_run_over_a_cable_has_the_states_of_a_run_in_one_process(self):
        self.check("cyclone")

    def test_fast_run_over_a_cable_has_the_states_of_a_run_in_one_process(self):
        self.check("fast")


if __name__ == "__main__":
    if os.geteuid() != 0 or not shutil.which("ip"):
        print("SKIPPED: network namespaces need root and the program ip (package iproute2)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
