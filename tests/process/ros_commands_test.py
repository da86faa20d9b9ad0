#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""ros_commands_test.py BIN TESTS SOURCE: messages of ROS 2 move a robot in a running server set, on both DDS. They are sent by
the commands of docs/tutorials/ros2.md, and by a C program with idlc's types and the quality of service of rmw."""
import json
import pathlib
import re
import shlex
import subprocess
import sys
import time
import unittest

from own_surroundings import OwnSurroundings

BIN, TESTS, SOURCE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
LIMIT = 60  # [s] for what takes less than two seconds on a quiet machine
# [rad] A servo of 600 N m/rad gives way by 0.005 under the 3 N m of a forearm held out.
DROOP = 0.02
MOVES = 1e-3  # [rad] between two readings


def find_documented(pattern):
    page = (SOURCE / "docs/tutorials/ros2.md").read_text()
    blocks = [text for language, text in re.findall(r"^```(\w*)\n(.*?)^```$", page, re.S | re.M) if not language]
    found = [line for block in blocks for line in block.splitlines() if re.match(pattern, line)]
    assert found, f"docs/tutorials/ros2.md has no command {pattern}"
    return [shlex.split(line.split("  #")[0]) for line in found]


class RosCommands(OwnSurroundings):
    def call(self, *words):
        return subprocess.run([str(w) for w in words], env=self.environment, capture_output=True, text=True, timeout=LIMIT, cwd=SOURCE)

    def write(self, *words):
        environment = {**self.environment, "CYCLONEDDS_URI": f"file://{SOURCE}/idl/example_c/cyclone.xml"}
        sent = subprocess.run([TESTS / "ros_writer", self.domain, *map(str, words)], env=environment, capture_output=True, text=True, timeout=LIMIT)
        self.assertEqual((sent.returncode, sent.stderr), (0, ""))
        return sent.stdout.strip()

    def start(self, vendor, *options):
        """The documented run."""
        words = find_documented(r"scripts/simulate\.sh .*hrp-controller-ros")[0][1:]
        self.log, said = self.folder / f"{vendor}.mcap", (self.folder / "said.txt").open("w")
        self.addCleanup(said.close)
        self.run_process = subprocess.Popen([BIN / "hrp-simulate", *words, "--dds", vendor, "--no-plot", "--log", self.log, *options], cwd=SOURCE,
                                            env=self.environment, stdout=said, stderr=subprocess.STDOUT)
        self.addCleanup(self.run_process.wait)
        self.addCleanup(self.run_process.terminate)
        end = time.monotonic() + LIMIT
        while not self.call(BIN / "hrp-run", "domain").stdout.strip().isdigit():
            self.assertLess(time.monotonic(), end, "the run does not start")
        self.domain = self.call(BIN / "hrp-run", "domain").stdout.strip()

    def stop(self):
        """All commands of the log as (time, {joint: (position, velocity)})."""
        self.run_process.terminate()
        self.run_process.wait(LIMIT)
        description = self.call(BIN / "hrp-log", "cat", self.log, "robot_description", "--json").stdout
        names = [joint["name"] for joint in json.loads(description.splitlines()[0])["message"]["joints"]]
        lines = self.call(BIN / "hrp-log", "cat", self.log, "joint_commands", "--json").stdout.splitlines()
        messages = [json.loads(line)["message"] for line in lines]
        return [(m["header"]["time"], dict(zip(names, zip(m["positions"], m["velocities"])))) for m in messages]

    def read_states(self):
        shown = self.call(BIN / "hrp-topic", "echo", "joint_states", "--count", "1", "--json").stdout
        state = json.loads(shown)
        return dict(zip(state["name"], state["position"]))

    def wait_until_at(self, joint, position):
        """However slow a busy machine makes the run: only a joint that has stopped elsewhere is too late."""
        end, at = time.monotonic() + LIMIT, 1e9
        while abs(at - position) > DROOP:
            before, at = at, self.read_states().get(joint, 1e9)
            if abs(at - before) > MOVES:
                end = time.monotonic() + LIMIT
            self.assertLess(time.monotonic(), end, f"{joint} is at {at}; expected {position}")

    def check_cubic(self, commands, joint, goal, duration):
        """From rest to rest within `duration`: q = q0 + (goal - q0) (3 s^2 - 2 s^3), s = t / duration."""
        first = commands[0][1][joint][0]
        moving = [i for i, (_, command) in enumerate(commands) if command[joint][0] != first]
        begin = commands[moving[0] - 1][0]
        seen = 0
        for t, command in commands[moving[0] - 1:]:
            s = min(1.0, (t - begin) / duration)
            expected = first + (goal - first) * (3 * s**2 - 2 * s**3)
            self.assertAlmostEqual(command[joint][0], expected, delta=1e-12)
            self.assertAlmostEqual(command[joint][1], (goal - first) * 6 * (s - s**2) / duration, delta=1e-9)
            seen += s < 1.0
        self.assertGreater(seen, 10)

    def test_documented_trajectory(self):
        for vendor in ("cyclone", "fast"):
            with self.subTest(vendor):
                self.start(vendor)
                _, _, topic, text = find_documented(r"build/bin/hrp-topic pub joint_trajectory")[0]
                sent = self.call(BIN / "hrp-topic", "pub", topic, text)
                self.assertEqual((sent.returncode, sent.stderr), (0, ""))
                message = json.loads(self.call(BIN / "hrp-topic", "pub", topic, text, "--print").stdout)
                self.assertEqual((len(message["joint_names"]), len(message["points"]), message["points"][0]["velocities"]), (1, 1, [0]))
                joint, goal = message["joint_names"][0], message["points"][0]["positions"][0]
                duration = message["points"][0]["time_from_start"]
                self.wait_until_at(joint, goal)
                self.check_cubic(self.stop(), joint, goal, duration["sec"] + duration["nanosec"] / 1e9)

    def test_foreign_writer(self):
        for vendor in ("cyclone", "fast"):
            with self.subTest(vendor):
                self.start(vendor)
                # Type and hash as ROS 2 Jazzy generates them.
                self.assertEqual(self.write("trajectory", "R_ELBOW", -1.0, 0.5),
                                 "rt/joint_trajectory trajectory_msgs::msg::dds_::JointTrajectory_ "
                                 "typehash=RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e;")
                self.wait_until_at("R_ELBOW", -1.0)
                goal = {**self.read_states(), "R_ELBOW": -0.6, "NECK_Y": 0.1}
                self.assertEqual(self.write("positions", *goal.values()),
                                 "rt/position_commands std_msgs::msg::dds_::Float64MultiArray_ "
                                 "typehash=RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f;")
                self.wait_until_at("NECK_Y", 0.1)
                self.wait_until_at("R_ELBOW", -0.6)
                commands = self.stop()
                self.assertEqual(commands[-1][1], {joint: (position, 0) for joint, position in goal.items()})

    def test_rate_of_joint_states(self):
        # Steps of 1 ms, control periods of 5 ms: every eighth sample. Readers that only look may miss some.
        self.start("cyclone", "--ros-rate", "25")
        shown = self.call(BIN / "hrp-topic", "echo", "joint_states", "--count", "20", "--json").stdout
        stamps = [json.loads(line)["header"]["stamp"] for line in shown.splitlines()]
        times = [stamp["sec"] * 10**9 + stamp["nanosec"] for stamp in stamps]
        self.assertEqual(len(times), 20)
        self.assertEqual({time % 40_000_000 for time in times}, {0})

    def test_without_messages_a_run_is_that_of_the_scenarios_controller(self):
        for scenario in ("hrp2p_stand", "default"):
            hashes = set()
            for controller in ("hrp-controller", "hrp-controller-ros"):
                said = self.call(BIN / "hrp-simulate", f"models/scenarios/{scenario}.yaml", "--controller", controller, "--duration", "2", "--no-plot",
                                 "--quiet", "--log", self.folder / f"{scenario}_{controller}.mcap").stdout
                hashes.add(re.search(r"state hash (\w{16})", said)[1])
            self.assertEqual(len(hashes), 1, scenario)

    def test_a_walking_robot_moves_its_arm(self):
        self.log, scenario = self.folder / "walk.mcap", SOURCE / "models/scenarios/default.yaml"
        run = subprocess.Popen([BIN / "hrp-simulate", scenario, "--controller", "hrp-controller-ros", "--speed", "4", "--no-plot", "--quiet",
                                "--log", self.log], env=self.environment, stdout=subprocess.PIPE, text=True)
        self.addCleanup(run.stdout.close)
        self.run_process = run
        self.addCleanup(run.wait)
        self.addCleanup(run.terminate)
        end, sent = time.monotonic() + LIMIT, None
        while sent is None or sent.returncode != 0:
            self.assertLess(time.monotonic(), end, sent)
            sent = self.call(BIN / "hrp-topic", "pub", "joint_trajectory", "{joint_names: [R_ELBOW], points: [{positions: [-1.2], velocities: [0], time_from_start: {sec: 2}}]}")
        self.assertEqual(run.wait(LIMIT), 0)
        said = run.stdout.read()
        self.assertRegex(said, r"(?m)^simulated")
        self.assertNotRegex(said, r"(?m)^fall")
        commands = self.stop()
        self.assertAlmostEqual(commands[-1][0], 12.0, delta=0.01)
        self.check_cubic(commands, "R_ELBOW", -1.2, 2.0)
        self.assertNotEqual(commands[-1][1]["R_KNEE"], commands[0][1]["R_KNEE"])

    def test_refused_messages_change_nothing(self):
        self.start("cyclone")
        for topic, text in (("joint_trajectory", "{joint_names: [R_ELBO], points: [{positions: [0]}]}"),
                            ("position_commands", "{data: [0.1, 0.2]}")):
            self.assertEqual(self.call(BIN / "hrp-topic", "pub", topic, text).returncode, 0)
        end, said = time.monotonic() + LIMIT, ""
        while "position_commands" not in said:
            self.assertLess(time.monotonic(), end, said)
            said = (self.folder / "said.txt").read_text()
        self.assertIn("rt/joint_trajectory: error: joint_names[0]: 'R_ELBO'; expected a joint of hrp2p_like; is it 'R_ELBOW'? (1 refused so far)", said)
        self.assertIn("rt/position_commands: error: data: 2 values; expected 30, one a joint in the order of joint_states (2 refused so far)", said)
        commands = self.stop()
        self.assertTrue(all(command == commands[0][1] for _, command in commands))
        self.assertEqual(self.run_process.returncode, 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
