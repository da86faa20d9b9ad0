#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""doctor_test.py BIN TESTS SOURCE: each fault that hrp-doctor knows is made, and its line is there with a mend.

Each test has a folder of runs of its own. Faults of interfaces need root and network namespaces."""
import errno
import fcntl
import os
import pathlib
import resource
import shutil
import socket
import subprocess
import sys
import time
import unittest

from own_surroundings import OwnSurroundings

BIN, TESTS, SOURCE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
LIMIT = 60  # [s] for a program to end; none takes a tenth of it on a quiet machine
MAY_NAMESPACE = os.geteuid() == 0 and shutil.which("ip") is not None


class Doctor(OwnSurroundings):
    def ask(self, *options, before=(), limits=None):
        """(status, lines) of hrp-doctor."""
        done = subprocess.run([*before, str(BIN / "hrp-doctor"), *options], env=self.environment, capture_output=True, text=True,
                              timeout=LIMIT, preexec_fn=limits)
        return done.returncode, done.stdout + done.stderr

    def expect(self, what, words, *options, **more):
        status, said = self.ask(*options, **more)
        fitting = [line for line in said.splitlines() if line.startswith("problem") and line.split()[1] == what.split()[0] and words in line]
        self.assertTrue(fitting, f"no problem of '{what}' with '{words}':\n{said}")
        self.assertIn("   mend: ", fitting[0])
        self.assertEqual(status, 1, said)
        return said

    def start_run(self, *options):
        run = subprocess.Popen([str(BIN / "hrp-simulate"), str(SOURCE / "models/scenarios/squat.yaml"), "--realtime", "--force",
                                "--log", str(self.folder / "run.mcap"), *options],
                               env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(run.wait)
        self.addCleanup(run.terminate)
        self.wait_for(lambda: "domain" in self.tell("list"))
        return int(self.tell("domain"))

    def tell(self, *words):
        return subprocess.run([str(BIN / "hrp-run"), *words], env=self.environment, capture_output=True, text=True, timeout=LIMIT).stdout

    def wait_for(self, done):
        end = time.monotonic() + LIMIT
        while not done():
            self.assertLess(time.monotonic(), end, "waited in vain")
            time.sleep(0.05)

    def make_entry(self, domain, started):
        """What a launcher leaves in the folder of runs, held by this process."""
        runs = self.folder / "openhrp-dds"
        runs.mkdir(mode=0o700)
        claim = open(runs / f"domain_{domain}", "w")
        self.addCleanup(claim.close)
        fcntl.flock(claim, fcntl.LOCK_EX)
        (runs / f"run_{domain}").write_text(f"domain {domain}\nprocess {os.getpid()}\nstarted {started}\nscenario x.yaml\nvendor cyclone\ntoken 00\n")

    # ---- runs ---------------------------------------------------------------------------------------------------

    def test_a_run_that_goes_on_has_no_problem(self):
        for vendor in ("cyclone", "fast"):
            self.start_run("--dds", vendor)
            self.wait_for(lambda: self.tell("status").startswith("running"))
            status, said = self.ask()
            self.assertEqual(status, 0, said)
            self.assertIn("no problem", said)
            self.assertIn(f"of {vendor}", said)
            self.tell("stop")
            self.wait_for(lambda: "domain" not in self.tell("list"))

    def test_no_run(self):
        self.expect("run", "no run on this machine")

    def test_several_runs(self):
        self.start_run()
        subprocess_count = lambda: self.tell("list").count("--run")
        second = subprocess.Popen([str(BIN / "hrp-simulate"), str(SOURCE / "models/scenarios/squat.yaml"), "--realtime", "--log",
                                   str(self.folder / "second.mcap")], env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(second.wait)
        self.addCleanup(second.terminate)
        self.wait_for(lambda: subprocess_count() == 2)
        self.expect("run", "several go on")

    def test_a_paused_run(self):
        self.start_run()
        self.tell("pause")
        self.expect("phase", "paused")

    def test_a_run_that_waits_for_its_controller(self):
        self.start_run("--without", "controller")
        self.expect("phase", "waits for controller")

    def test_a_domain_that_is_no_run_of_ours(self):
        said = self.expect("run", "not steered", "--domain", "123")
        self.assertIn("nobody is seen", said)
        self.assertIn("no scheduler is heard in domain 123", said)

    # ---- other people's ends ------------------------------------------------------------------------------------

    def make_end(self, fault):
        domain = self.start_run()
        environment = dict(self.environment, CYCLONEDDS_URI=f"file://{SOURCE}/idl/example_c/cyclone.xml")
        end = subprocess.Popen([str(TESTS / "foreign_ends"), str(domain), fault], env=environment, stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: end.communicate("\n", timeout=LIMIT))
        self.assertEqual(end.stdout.readline(), "there\n")

    def test_a_best_effort_writer_beside_reliable_readers(self):
        self.make_end("best_effort_writer")
        self.expect("qos", "hrp/joint_commands: the reader is RELIABLE, the writer is BEST_EFFORT")

    def test_a_reader_that_wants_what_no_writer_keeps(self):
        self.make_end("eager_reader")
        self.expect("qos", "hrp/sensor_data: the reader is TRANSIENT_LOCAL, the writer is VOLATILE")

    def test_a_volatile_reader_of_a_topic_whose_last_sample_is_kept(self):
        self.make_end("late_reader")
        self.expect("qos", "does not get what was sent before it came")

    def test_another_type_on_our_topic(self):
        self.make_end("other_type")
        self.expect("types", "has the type hrp::msg::SensorData, not hrp::msg::ContactSet")

    def test_a_misspelt_topic(self):
        self.make_end("misspelt")
        self.assertIn("is it hrp/sensor_data?", self.expect("names", "hrp/sensor_dta"))

    # ---- session ------------------------------------------------------------------------------------------------

    def test_a_folder_of_runs_that_is_a_symlink(self):
        (self.folder / "openhrp-dds").symlink_to("/tmp")
        self.expect("folder", "openhrp-dds")

    def test_another_ros_domain(self):
        domain = self.start_run()
        self.environment["ROS_DOMAIN_ID"] = str(domain + 1)
        self.assertIn(f"export ROS_DOMAIN_ID={domain}", self.expect("environment", "ROS_DOMAIN_ID"))

    def test_a_vendor_file_that_is_not_there(self):
        self.environment["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(self.folder / "none.xml")
        self.expect("environment", "FASTRTPS_DEFAULT_PROFILES_FILE names")

    def test_few_open_files(self):
        self.expect("files", "100 open files", limits=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (100, 100)))

    def test_a_run_that_began_in_the_future(self):
        self.make_entry(119, int(time.time()) + 3600)
        said = self.expect("clock", "in the future")
        self.assertIn("nobody is seen", said)

    def test_a_full_domain(self):
        domain = 118
        self.make_entry(domain, int(time.time()))
        for place in range(39):
            each = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.addCleanup(each.close)
            try:
                each.bind(("127.0.0.1", 7400 + 250 * domain + 10 + 2 * place))
            except OSError as error:  # another test's socket has the port: it is as taken as this test wants it
                self.assertEqual(error.errno, errno.EADDRINUSE)
        # 39, or 40 when the system has given the last port to somebody's socket: it lies among those for anybody.
        self.assertRegex(self.expect("domain", "of 40 places"), "(39|40) of 40 places")

    @unittest.skipUnless(os.access("/dev/shm", os.W_OK), "NOT TESTED: /dev/shm cannot be written")
    def test_shared_memory_of_a_program_that_is_gone(self):
        lock = pathlib.Path(f"/dev/shm/fastrtps_doctor{os.getpid()}_el")
        self.addCleanup(lambda: lock.unlink(missing_ok=True))
        with open(lock, "w") as owner:
            fcntl.flock(owner, fcntl.LOCK_EX)
            self.assertNotIn(lock.name, self.ask()[1], "its owner lives")
        self.expect("shared memory", "programs that are gone")

    # ---- interfaces ---------------------------------------------------------------------------------------------

    def make_machine(self):
        """A network namespace with loopback down and an interface 192.168.9.1 that passes no multicast."""
        name = f"hrp-doctor-{os.getpid()}"
        subprocess.run(["ip", "netns", "add", name], check=True)
        self.addCleanup(lambda: subprocess.run(["ip", "netns", "del", name], check=False))
        for words in ("link add veth0 type veth peer name veth1", "addr add 192.168.9.1/24 dev veth0", "link set veth0 multicast off",
                      "link set veth0 up", "link set veth1 up"):
            subprocess.run(["ip", "-n", name, *words.split()], check=True)
        return name

    @unittest.skipUnless(MAY_NAMESPACE, "NOT TESTED: network namespaces need root and ip")
    def test_loopback_that_is_down(self):
        said = self.expect("interface", "127.0.0.1", before=("ip", "netns", "exec", self.make_machine()))
        self.assertIn("sudo ip link set lo up", said)

    @unittest.skipUnless(MAY_NAMESPACE, "NOT TESTED: network namespaces need root and ip")
    def test_an_interface_without_multicast_and_one_with(self):
        name = self.make_machine()
        subprocess.run(["ip", "-n", name, "link", "set", "lo", "up"], check=True)
        inside = ("ip", "netns", "exec", name)
        self.expect("multicast", "does not pass it", "--network-interface", "192.168.9.1", before=inside)
        subprocess.run(["ip", "-n", name, "link", "set", "veth0", "multicast", "on"], check=True)
        said = self.ask("--network-interface", "192.168.9.1", before=inside)[1]
        self.assertRegex(said, r"ok +multicast +packets to 239.255.0.1 come back")

    def test_an_address_of_nobody(self):
        self.expect("interface", "192.0.2.1", "--network-interface", "192.0.2.1")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
