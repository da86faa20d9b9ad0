#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""ros_services_test.py BIN TESTS SOURCE: clients of ROS 2 pause, step, resume and reset a run over DDS, as the rmw of each vendor
does it, and the stamps of all messages are simulated time that goes forward, but for one jump at a reset."""
import pathlib
import re
import subprocess
import sys
import time
import unittest

from own_surroundings import OwnSurroundings

BIN, TESTS, SOURCE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
LIMIT = 60  # [s] for what takes less than a second on a quiet machine
PERIOD = 5_000_000  # [ns] control period of the scenario
TOPICS = ("rt/clock", "rt/tf", "rt/joint_states", "rt/imu/chest", "rt/wrench/left_foot")
# As ROS 2 Jazzy generates them.
SET_BOOL = {"Request": "c62fbb99d94e1b25e8ef9e109f9581956bb1b3361a45a4e5810c36a90d29932e",
            "Response": "d0814e7f7b4880ab77e9c57426c7aa1562ab69f11eef8e2e968812f9cbd0b059"}


class RosServices(OwnSurroundings):
    def setUp(self):
        super().setUp()
        self.foreign = {**self.environment, "CYCLONEDDS_URI": f"file://{SOURCE}/idl/example_c/cyclone.xml"}

    def spawn(self, *words, **options):
        process = subprocess.Popen([str(w) for w in words], **options)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        return process

    def start(self, vendor, *options):
        self.spawn(BIN / "hrp-simulate", SOURCE / "models/scenarios/hrp2p_stand.yaml", "--dds", vendor, "--realtime", "--duration", "0",
                   "--no-plot", "--quiet", "--log", self.folder / f"{vendor}.mcap", *options, env=self.environment,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        domain = ""
        while not domain.strip().isdigit():
            domain = subprocess.run([BIN / "hrp-run", "domain"], env=self.environment, capture_output=True, text=True).stdout
        self.domain = domain.strip()
        self.said = self.folder / f"{vendor}_stamps.txt"
        with self.said.open("w") as said:
            self.spawn(TESTS / "ros_stamps", self.domain, env=self.foreign, stdout=said)

    def call(self, *words, program="ros_caller"):
        words = [str(w) for w in words]
        said = subprocess.run([TESTS / program, self.domain, *words], env=self.foreign, capture_output=True, text=True, timeout=LIMIT)
        self.assertEqual((said.returncode, said.stderr), (0, ""))
        return said.stdout.splitlines()

    def read_stamps(self, topic):
        """[ns] in the order of their arrival; the last line may be half written."""
        lines = [line.split() for line in self.said.read_text().split("\n")[:-1]]
        return [int(s) * 10**9 + int(n) for name, s, n in lines if name == topic]

    def wait_until(self, condition, what):
        end = time.monotonic() + LIMIT
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.02)

    def wait_for_stop(self, step):
        """The run stands after `step`, and its last clock is the last control period up to there."""
        last = step * 1_000_000 // PERIOD * PERIOD
        self.wait_until(lambda: self.read_stamps("rt/clock")[-1:] == [last], f"the clock does not stop at {last} ns")
        status = subprocess.run([BIN / "hrp-run", "status"], env=self.environment, capture_output=True, text=True).stdout
        self.assertIn("paused", status)

    def check_steering(self, call):
        """Each call is a word; its answer is (success, message)."""
        self.wait_until(lambda: all(len(self.read_stamps(topic)) > 20 for topic in TOPICS), "not all topics come")
        success, message = call("pause")
        stopped = int(re.fullmatch(r"stops after step (\d+)", message)[1])
        self.assertTrue(success)
        self.wait_for_stop(stopped)
        for _ in range(6):  # over the next control period
            self.assertEqual(call("step"), (True, f"stops after step {stopped + 1}"))
            stopped += 1
            self.wait_for_stop(stopped)
        self.assertEqual(call("resume"), (True, ""))
        self.wait_until(lambda: self.read_stamps("rt/clock")[-1] > (stopped + 100) * 1_000_000, "the run does not go on")
        before = self.read_stamps("rt/clock")[-1]
        self.assertEqual(call("reset"), (True, ""))
        self.wait_until(lambda: min(self.read_stamps("rt/clock")[-200:]) < before // 2, "no new beginning")
        self.assertTrue(call("pause")[0])
        self.assertEqual(call("go"), (True, ""))

    def check_stamps(self):
        """One jump to 0 at the reset, else whole control periods forward from each message to the next."""
        for topic in TOPICS:
            stamps = self.read_stamps(topic)
            steps = [b - a for a, b in zip(stamps, stamps[1:])]
            back = [i for i, step in enumerate(steps) if step <= 0]
            self.assertEqual([stamps[i + 1] for i in back], [0], topic)
            self.assertEqual({step % PERIOD for step in steps if step > 0}, {0}, topic)

    def test_cyclone(self):
        self.start("cyclone", "--ros-services")

        def call(word):
            *ends, reply = self.call(7000 + len(word), word)
            kind = "SetBool" if word in ("pause", "go") else "Trigger"
            service = "pause" if word == "go" else word
            for line, part, topic in zip(ends, ("Request", "Response"), (f"rq/run/{service}Request", f"rr/run/{service}Reply"), strict=True):
                _, name, type_name, data = line.split()
                self.assertEqual((name, type_name), (topic, f"std_srvs::srv::dds_::{kind}_{part}_"))
                self.assertRegex(data, rf"^typehash=RIHS01_{SET_BOOL[part] if kind == 'SetBool' else '[0-9a-f]{64}'};$")
            _, success, *message = reply.split(" ", 2)
            return success == "1", message[0] if message else ""

        self.check_steering(call)
        self.check_stamps()

    def test_fast(self):
        self.start("fast", "--ros-services")

        def call(word):
            reply, = self.call(word, program="ros_caller_fast")
            _, success, *message = reply.split(" ", 2)
            return success == "1", message[0] if message else ""

        self.check_steering(call)
        self.check_stamps()

    def test_fast_client_of_cyclone(self):
        """ROS 2 has no services across vendors: nobody is answered, and the run is left alone."""
        self.start("cyclone", "--ros-services")
        for word in ("pause", "reset"):
            self.assertEqual(self.call(word, program="ros_caller_fast")[-1], "silence")
        self.check_forward()

    def test_cyclone_client_of_fast(self):
        self.start("fast", "--ros-services")
        for word in ("pause", "reset"):
            self.assertEqual(self.call(7, word)[-1], "silence")
        self.check_forward()

    def check_forward(self):
        self.wait_until(lambda: len(self.read_stamps("rt/clock")) > 20, "no clock comes")
        before = self.read_stamps("rt/clock")
        self.assertEqual(before, sorted(set(before)))
        self.wait_until(lambda: len(self.read_stamps("rt/clock")) > len(before) + 20, "the run stands")

    def test_not_asked_for(self):
        """Without --ros-services nobody can steer the run."""
        self.start("cyclone")
        self.wait_until(lambda: len(self.read_stamps("rt/clock")) > 20, "no clock comes")
        shown = subprocess.run([BIN / "hrp-topic", "list"], env=self.environment, capture_output=True, text=True).stdout
        self.assertIn("rt/clock", shown)
        self.assertNotIn("rq/run", shown)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
