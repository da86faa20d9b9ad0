#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""several_machines_test.py BIN SOURCE: the commands of docs/tutorials/several_machines.md on two machines.

The machines are network namespaces with a cable between them (veth), and a private folder each. Claims: the run ends by
itself, and its log holds the same states as the log of the same run in one process; what is wrong is said with the names
of server and host; a cable that is cut ends the run, and the log is whole. Needs root. A command that enters the other
namespace stands in for ssh."""
import ctypes
import fcntl
import heapq
import os
import pathlib
import random
import re
import select
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

BIN, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
PAGE = SOURCE / "docs/tutorials/several_machines.md"
DURATION = "0.5"  # [s] simulated: a hundred control periods over the cable
LIMIT = 60        # [s] for all servers to end
ADDRESS = {"a": "192.168.1.10", "b": "192.168.1.11"}
SCENARIO = str(SOURCE / "models/scenarios/squat.yaml")
DELAY, LOSS = 0.020, 0.02  # [s] one way; share of packets


def run(*command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


class Cable:
    """Two namespaces and a veth pair between them; gone at the end."""

    count = 0

    def __init__(self):
        Cable.count += 1
        self.names = {m: f"hrp-{os.getpid()}-{Cable.count}-{m}" for m in ADDRESS}

    def __enter__(self):
        for name in self.names.values():
            run("ip", "netns", "add", name)
        self.connect(self.names["a"], self.names["b"])
        for machine, name in self.names.items():
            for words in (["addr", "add", ADDRESS[machine] + "/24", "dev", "veth0"], ["link", "set", "veth0", "up"],
                          ["link", "set", "lo", "up"], ["route", "add", "224.0.0.0/4", "dev", "veth0"]):
                run("ip", "-n", name, *words)
        self.hosts_folder = pathlib.Path("/etc/netns", self.names["a"])  # ip netns exec puts its files over those of /etc
        self.hosts_folder.mkdir(parents=True)
        (self.hosts_folder / "hosts").write_text(f"127.0.0.1 localhost\n{ADDRESS['b']} desk\n")
        return self

    def connect(self, a, b):
        run("ip", "link", "add", "veth0", "netns", a, "type", "veth", "peer", "name", "veth0", "netns", b)

    def cut(self):
        run("ip", "-n", self.names["b"], "link", "set", "veth0", "down")

    def __exit__(self, *_):
        shutil.rmtree(self.hosts_folder, ignore_errors=True)
        for name in self.names.values():
            subprocess.run(["ip", "netns", "del", name], check=False)


def open_tun(namespace):
    """A file that holds the far end of an interface veth0 in the namespace: each read or write is a packet."""
    libc = ctypes.CDLL(None, use_errno=True)
    with open("/proc/thread-self/ns/net") as home, open(f"/run/netns/{namespace}") as there:
        if libc.setns(there.fileno(), 0) != 0:
            raise OSError(ctypes.get_errno(), "setns")
        try:
            tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
            fcntl.ioctl(tun, 0x400454CA, struct.pack("16sH22x", b"veth0", 0x1001))  # TUNSETIFF, IFF_TUN | IFF_NO_PI
        finally:
            libc.setns(home.fileno(), 0)
    return tun


class SlowCable(Cable):
    """The same with delay and loss, of our own: not every kernel has netem."""

    def connect(self, a, b):
        self.tuns = [open_tun(a), open_tun(b)]
        self.stop, self.lost, self.passed = threading.Event(), 0, 0
        self.thread = threading.Thread(target=self.carry)
        self.thread.start()

    def carry(self):
        dice, waiting, order = random.Random(1), [], 0
        while not self.stop.is_set():
            for tun in select.select(self.tuns, [], [], 0.001)[0]:
                try:
                    packet = os.read(tun, 65536)
                except OSError:  # not up yet, or gone
                    continue
                order += 1
                if dice.random() < LOSS:
                    self.lost += 1
                else:
                    heapq.heappush(waiting, (time.monotonic() + DELAY, order, self.tuns[tun == self.tuns[0]], packet))
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, tun, packet = heapq.heappop(waiting)
                try:
                    os.write(tun, packet)
                    self.passed += 1
                except OSError:
                    pass

    def __exit__(self, *words):
        self.stop.set()
        self.thread.join()
        for tun in self.tuns:
            os.close(tun)
        super().__exit__(*words)


def list_commands(vendor):
    """(machine, words) of the page's commands, with programs of this build."""
    text = PAGE.read_text()
    commands = re.findall(r"^([ab])\$ (build/bin/.*)$", text[text.index("## Servers on two machines, by hand"):], re.M)
    for machine, command in commands:
        words = shlex.split(command.replace("--dds cyclone", f"--dds {vendor}"))
        words[0] = str(BIN / pathlib.Path(words[0]).name)
        yield machine, [str(SOURCE / w) if w.startswith("models/") else w for w in words]


def list_launches():
    """Words of the page's commands that let the launcher spread a run; and its file of hosts."""
    text = PAGE.read_text()
    commands = re.findall(r"^robot\$ scripts/simulate\.sh (.*--(?:on|hosts) .*)$", text, re.M)
    hosts = re.search(r"here `hosts.txt`:\n\n```text\n(.*?)```", text, re.S).group(1)
    return [[str(SOURCE / w) if w.startswith("models/") else w for w in shlex.split(c)] for c in commands], hosts


class Launched(unittest.TestCase):
    """Runs that the launcher spreads. On the page the machines are called robot and desk."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="hrp_launched_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.launches, hosts = list_launches()
        (self.folder / "hosts.txt").write_text(hosts)

    def start(self, cable, words, log, reach=None):
        """hrp-simulate on the robot; `reach` is what stands in for ssh, in words of sh."""
        reach = reach or f"exec ip netns exec {cable.names['b']} \"$@\""
        way = self.folder / f"{log}.reach"
        way.write_text("#!/bin/sh\nhost=$1; shift\n" + reach + "\n")
        way.chmod(0o755)
        command = ["ip", "netns", "exec", cable.names["a"], str(BIN / "hrp-simulate"), *words, "--ssh", str(way), "--no-plot",
                   "--log", str(self.folder / log)]
        return subprocess.Popen(command, cwd=self.folder, env=dict(os.environ, XDG_RUNTIME_DIR=str(self.folder)), text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def finish(self, process):
        try:
            said = process.communicate(timeout=LIMIT)[0]
        except subprocess.TimeoutExpired:
            process.terminate()
            self.fail("the run did not end\n" + process.communicate()[0])
        return process.returncode, said

    def compare(self, log, duration):
        here = self.folder / f"here-{duration}.mcap"
        if not here.exists():
            run(str(BIN / "hrp-simulate"), SCENARIO, "--in-process", "--duration", duration, "--log", str(here), "--no-plot")
        return subprocess.run([str(BIN / "hrp-log"), "compare", str(self.folder / log), str(here)], capture_output=True, text=True)

    def check_same(self, log, duration):
        compared = self.compare(log, duration)
        self.assertEqual(compared.returncode, 0, compared.stdout + compared.stderr)
        self.assertIn("every payload the same", compared.stdout)

    def test_commands_of_the_page_write_the_bytes_of_a_run_in_one_process_on_both_vendors(self):
        self.assertEqual(len(self.launches), 2, "commands of the page")
        with Cable() as cable:
            for i, words in enumerate(self.launches):
                for vendor in ("cyclone", "fast"):
                    log = f"{vendor}{i}.mcap"
                    status, said = self.finish(self.start(cable, words + ["--duration", DURATION, "--dds", vendor], log))
                    self.assertEqual(status, 0, said)
                    self.assertIn("warning: this run leaves the machine without encryption", said)
                    self.check_same(log, DURATION)

    def test_pictures_of_a_vision_server_on_another_machine_have_the_bytes_of_one_here(self):
        scenario = str(SOURCE / "models/scenarios/cameras.yaml")
        run(str(BIN / "hrp-simulate"), scenario, "--in-process", "--duration", DURATION, "--log", str(self.folder / "here.mcap"), "--no-plot")
        for vendor in ("cyclone", "fast"):
            with Cable() as cable:
                words = [scenario, "--on", "vision=desk", "--duration", DURATION, "--dds", vendor]
                status, said = self.finish(self.start(cable, words, f"{vendor}.mcap"))
                self.assertEqual(status, 0, said)
            compared = subprocess.run([str(BIN / "hrp-log"), "compare", str(self.folder / f"{vendor}.mcap"), str(self.folder / "here.mcap")],
                                      capture_output=True, text=True)
            self.assertIn("every payload the same", compared.stdout, compared.stderr)

    def test_delay_and_loss_change_no_byte(self):
        if not os.path.exists("/dev/net/tun"):
            self.skipTest("SKIPPED: no /dev/net/tun to make a slow cable of")
        for vendor in ("cyclone", "fast"):
            with SlowCable() as cable:
                words = [SCENARIO, "--hosts", "hosts.txt", "--duration", "0.05", "--dds", vendor]
                status, said = self.finish(self.start(cable, words, f"slow-{vendor}.mcap"))
                self.assertEqual(status, 0, said)
                self.check_same(f"slow-{vendor}.mcap", "0.05")
                self.assertGreater(cable.passed, 100)
                self.assertGreater(cable.lost, 0, "nothing was lost: the run was too short to show anything")

    def kill_a_launcher(self):
        with Cable() as cable:
            # The stand-in for ssh dies with the launcher, the server is its child: only standard input tells it.
            reach = f"ip netns exec {cable.names['b']} \"$@\"; true"
            process = self.start(cable, [SCENARIO, "--on", "controller=desk", "--duration", "60", "--realtime"], "killed.mcap", reach)
            for line in process.stdout:
                if line.startswith("running"):
                    break
            process.kill()
            process.communicate(timeout=LIMIT)  # ends when the last process with this output has
            return subprocess.run(["ip", "netns", "pids", cable.names["b"]], capture_output=True, text=True).stdout

    def test_cut_cable_ends_the_run_by_name_and_a_killed_launcher_its_servers(self):
        with Cable() as first, Cable() as second:  # side by side, as each waits ten seconds
            runs = []
            for cable, vendor in ((first, "cyclone"), (second, "fast")):
                words = [SCENARIO, "--on", "controller=desk", "--duration", "5", "--realtime", "--dds", vendor]
                runs.append((cable, vendor, self.start(cable, words, f"cut-{vendor}.mcap")))
            for cable, _, process in runs:
                for line in process.stdout:  # progress, every two seconds; on a busy machine the first one comes at 0.03 s
                    running = re.match(r"running +t = +([\d.]+) s", line)
                    if running and float(running[1]) > 0.5:
                        break
                cable.cut()
            self.assertEqual(self.kill_a_launcher(), "", "processes that are left on the host")
            for _, vendor, process in runs:
                status, said = self.finish(process)
                self.assertEqual(status, 1, said)
                self.assertRegex(said, r"controller on desk has been silent for 10 s at step \d+")
                self.assertIn("complete up to step", said)
                self.assertLess(said.count("\n"), 40, "a broken way fills the terminal\n" + said)
                compared = self.compare(f"cut-{vendor}.mcap", "5")
                for line in compared.stdout.splitlines():
                    self.assertRegex(line, r"equal as far as both go$")
                    self.assertGreater(int(line.split()[1]), 10)

    def check_refused(self, cable, words, message, reach=None):
        status, said = self.finish(self.start(cable, [SCENARIO, "--duration", "0.1", *words], "refused.mcap", reach))
        self.assertNotEqual(status, 0, said)
        self.assertIn(message, said)

    def write_hosts(self, line):
        file = self.folder / "other.txt"
        file.write_text("# test\n" + line + "\n")
        return ["--hosts", str(file), "--force"]

    def test_what_is_missing_on_the_host_is_said_with_its_name(self):
        with Cable() as cable:
            self.check_refused(cable, ["--on", "controller=desk"], "controller on desk: desk cannot be reached", "echo no way >&2; exit 255")
            self.check_refused(cable, self.write_hosts("controller desk programs=/nowhere"), "controller on desk: desk lacks /nowhere/hrp-controller")
            old = self.folder / "old"
            old.mkdir()
            (old / "hrp-controller").write_text("#!/bin/sh\necho 'hrp-controller (openhrp-dds) 0.0.1'\n")
            (old / "hrp-controller").chmod(0o755)
            self.check_refused(cable, self.write_hosts(f"controller desk programs={old}"), "another version: 'hrp-controller (openhrp-dds) 0.0.1'")
            # A file that the server reads is here and not there: an empty folder lies over the one of the motion.
            motion = SOURCE / "models/motions"
            without = f"exec unshare -m sh -c 'mount -t tmpfs none {motion}; exec ip netns exec {cable.names['b']} \"$@\"' sh \"$@\""
            self.check_refused(cable, ["--on", "controller=desk", "--force"], f"desk lacks {motion}", without)

    def test_words_that_name_no_server_or_no_host_are_refused(self):
        with Cable() as cable:
            self.check_refused(cable, ["--on", "logger=desk"], "logger stays on the launcher's machine")
            self.check_refused(cable, ["--on", "controller=-oProxyCommand"], "is no [USER@]HOST")
            self.check_refused(cable, self.write_hosts("dinamics desk"), "other.txt:2: error: there is no server 'dinamics'")
            self.check_refused(cable, self.write_hosts("dynamics desk port=3"), "'port=3' is none of address=")
            self.check_refused(cable, self.write_hosts("dynamics desk address=desk.invalid"), "no IPv4 address of 'desk.invalid'")

    def test_secured_run_takes_the_identity_that_lies_on_the_host(self):
        identities = self.folder / "identities"
        made = subprocess.run([str(SOURCE / "scripts/secure.sh"), str(identities)], capture_output=True, text=True)
        self.assertEqual(made.returncode, 0, made.stderr)
        there = self.folder / "there"
        shutil.copytree(identities / "command", there)
        with Cable() as cable:
            for vendor in ("cyclone", "fast"):
                words = [SCENARIO, "--secure", str(identities), *self.write_hosts(f"controller desk secure={there}"), "--duration", "0.1", "--dds", vendor]
                status, said = self.finish(self.start(cable, words, f"secure-{vendor}.mcap"))
                self.assertEqual(status, 0, said)
                self.assertNotIn("warning", said)
                self.check_same(f"secure-{vendor}.mcap", "0.1")


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
