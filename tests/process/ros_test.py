#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""ros_test.py BIN TESTS SOURCE: a run as nodes of ROS 2 see it on the wire, on both DDS: names, types, type hashes, quality of
service, contents. The reader is a C program with idlc's types and the quality of service of rmw."""
import json
import pathlib
import subprocess
import sys
import time
import unittest

from own_surroundings import OwnSurroundings

BIN, TESTS, SOURCE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
LIMIT = 60  # [s] for what takes less than a second on a quiet machine

# Type and hash as ROS 2 Jazzy generates them for these messages.
EXPECTED = {
    "rt/clock": ("rosgraph_msgs::msg::dds_::Clock_", "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"),
    "rt/tf": ("tf2_msgs::msg::dds_::TFMessage_", "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"),
    "rt/tf_static": ("tf2_msgs::msg::dds_::TFMessage_", "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"),
    "rt/robot_description": ("std_msgs::msg::dds_::String_", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"),
    "rt/joint_states": ("sensor_msgs::msg::dds_::JointState_", "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"),
}


class Ros(OwnSurroundings):
    def run_and_read(self, vendor, scenario="squat", namespace=()):
        """Lines of ros_reader, and the states of the log by their time in ns."""
        log = self.folder / "run.mcap"
        run = subprocess.Popen([BIN / "hrp-simulate", SOURCE / f"models/scenarios/{scenario}.yaml", "--dds", vendor, "--realtime",
                                "--duration", "0", "--no-plot", "--quiet", "--log", log],
                               env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(run.wait)
        self.addCleanup(run.terminate)
        domain, end = "", time.monotonic() + LIMIT
        while not domain.strip().isdigit():
            self.assertLess(time.monotonic(), end, "the run does not start")
            domain = subprocess.run([BIN / "hrp-run", "domain"], env=self.environment, capture_output=True, text=True).stdout
        reader = subprocess.run([TESTS / "ros_reader", domain.strip(), "100", *namespace], capture_output=True, text=True, timeout=LIMIT,
                                env={**self.environment, "CYCLONEDDS_URI": f"file://{SOURCE}/idl/example_c/cyclone.xml"})
        self.assertEqual(reader.returncode, 0, reader.stderr)
        run.terminate()
        run.wait(LIMIT)
        shown = subprocess.run([BIN / "hrp-log", "cat", log, "robot_state", "--json"], capture_output=True, text=True).stdout
        states = [json.loads(line)["message"] for line in shown.splitlines()]
        description = subprocess.run([BIN / "hrp-log", "cat", log, "robot_description", "--json"], capture_output=True, text=True).stdout
        return ([line.split() for line in reader.stdout.splitlines()], {round(s["header"]["time"] * 1e9): s for s in states},
                json.loads(description.splitlines()[0])["message"])

    def check(self, vendor):
        lines, states, robot = self.run_and_read(vendor)
        said = {}
        for words in lines:
            said.setdefault(words[0], []).append(words[1:])
        ends = {end[0]: end[1:] for end in said["end"]}
        for topic, (kind, digest) in EXPECTED.items():
            self.assertEqual(ends[topic], [kind, f"typehash=RIHS01_{digest};"], topic)
        for topic, (kind, user_data) in ends.items():
            self.assertRegex(user_data, r"^typehash=RIHS01_[0-9a-f]{64};$", topic)
            self.assertRegex(kind, r"^\w+::msg::dds_::\w+_$", topic)
        self.assertEqual(int(said["urdf"][0][0]), len(robot["urdf"].encode()))
        links = {link["name"] for link in robot["links"]}
        self.assertEqual(int(said["fixed"][0][0]), sum(frame["name"] not in links for frame in robot["frames"]))
        self.assertEqual(int(said["joints"][-1][0]), len(robot["joints"]))
        for seconds, nanoseconds, parent, child, *position in said["tf"]:
            state = states[int(seconds) * 10**9 + int(nanoseconds)]
            self.assertEqual((parent, child), ("world", robot["links"][0]["name"]))
            expected = state["X_WB"]["translation"]
            self.assertEqual([float(p) for p in position], [expected["x"], expected["y"], expected["z"]])
        for seconds, nanoseconds in said["clock"]:
            self.assertIn(int(seconds) * 10**9 + int(nanoseconds), states)

    def check_several(self, vendor):
        lines, states, _ = self.run_and_read(vendor, "several_robots", ["partner"])
        said = {}
        for words in lines:
            said.setdefault(words[0], []).append(words[1:])
        ends = {end[0]: end[1:] for end in said["end"]}
        for topic in ("rt/joint_states", "rt/robot_description"):
            kind, digest = EXPECTED[topic]
            for robot in ("", "walker/", "partner/"):
                self.assertEqual(ends["rt/" + robot + topic[3:]], [kind, f"typehash=RIHS01_{digest};"])
        for topic in ("clock", "tf", "tf_static"):
            self.assertEqual([end for end in ends if end.endswith("/" + topic)], ["rt/" + topic])
        seconds, nanoseconds, *_ = said["tf"][-1]
        state = states[int(seconds) * 10**9 + int(nanoseconds)]
        expected = {name: robot["X_WB"]["translation"] for name, robot in
                    [("", state), *((robot["name"] + "/", robot) for robot in state["robots"])]}
        found = {child.rpartition("/")[0] + ("/" if "/" in child else ""): list(map(float, position))
                 for child, *position in said["root"][-3:]}
        self.assertEqual(found, {name: [p["x"], p["y"], p["z"]] for name, p in expected.items()})

    def test_several_robots_on_cyclone(self):
        self.check_several("cyclone")

    def test_several_robots_on_fast(self):
        self.check_several("fast")

    def test_cyclone(self):
        self.check("cyclone")

    def test_fast(self):
        self.check("fast")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
