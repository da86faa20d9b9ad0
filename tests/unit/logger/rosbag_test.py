#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""rosbag_test.py BIN SOURCE: the bag of ROS 2 that `hrp-log rosbag` makes of a run, by the files and the CDR in it."""
import subprocess
import sys
import unittest

import numpy as np
import yaml

import plain_mcap
import urdf_kinematics as kinematics
from programs import BIN, LoggedRun, run
from urdf_kinematics import pose_of, xyz

POSE_TOLERANCE = 1e-12  # doubles all the way: rounding of some ten products


def seconds(stamp):
    return stamp["sec"] + 1e-9 * stamp["nanosec"]


class RosbagTest(LoggedRun):
    @classmethod
    def setUpClass(cls):
        cls.log_run("default.yaml", 2)
        cls.bag = cls.folder / "bag"
        run(BIN / "hrp-log", "rosbag", cls.log, "--out", cls.bag, "--rate", 50)
        cls.metadata = yaml.safe_load((cls.bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
        cls.file = plain_mcap.File(cls.bag / cls.metadata["relative_file_paths"][0])
        cls.robot = cls.cat("robot_description")[0]

    def read(self, topic):
        decoder = plain_mcap.Decoder(self.file.find_channel(topic)["schema"])
        return [(time, decoder.read(data)) for time, data in self.file.topic(topic)]

    def test_file_is_one_of_the_ros2_profile_with_ros2msg_schemas(self):
        self.assertEqual(self.file.profile, "ros2")
        for channel in self.file.channels.values():
            self.assertEqual((channel["schema"]["encoding"], channel["encoding"]), ("ros2msg", "cdr"))
            self.assertRegex(channel["schema"]["name"], r"^\w+/msg/\w+$")
            self.assertRegex(channel["metadata"]["topic_type_hash"], r"^RIHS01_[0-9a-f]{64}$")

    def test_metadata_says_what_is_in_the_file(self):
        meta = self.metadata
        self.assertEqual((meta["version"], meta["storage_identifier"]), (5, "mcap"))
        self.assertEqual(meta["message_count"], len(self.file.messages))
        times = [time for _, time, _ in self.file.messages]
        self.assertEqual(meta["starting_time"]["nanoseconds_since_epoch"], min(times))
        self.assertEqual(meta["duration"]["nanoseconds"], max(times) - min(times))
        self.assertEqual({each["topic_metadata"]["name"] for each in meta["topics_with_message_count"]},
                         {channel["topic"] for channel in self.file.channels.values()})
        for each in meta["topics_with_message_count"]:
            topic, channel = each["topic_metadata"], self.file.find_channel(each["topic_metadata"]["name"])
            self.assertEqual(each["message_count"], len(self.file.topic(topic["name"])))
            self.assertEqual((topic["type"], topic["serialization_format"]), (channel["schema"]["name"], "cdr"))
            self.assertEqual(topic["offered_qos_profiles"], channel["metadata"]["offered_qos_profiles"])
            profile = yaml.safe_load(topic["offered_qos_profiles"])[0]
            latched = topic["name"] in ("/robot_description", "/tf_static")
            self.assertEqual((profile["reliability"], profile["durability"]), (1, 1 if latched else 2), topic["name"])

    def test_clock_and_stamps_are_simulated_time(self):
        clock = self.read("/clock")
        self.assertEqual(len(clock), 101)
        for time, message in clock:
            self.assertAlmostEqual(seconds(message["clock"]), time, delta=1e-9)
        for topic in ("/joint_states", "/imu/chest", "/wrench/left_foot", "/zmp"):
            for time, message in self.read(topic):
                self.assertAlmostEqual(seconds(message["header"]["stamp"]), time, delta=1e-9, msg=topic)

    def test_tf_is_the_robots_kinematics(self):
        urdf = self.read("/robot_description")[0][1]["data"]
        names = [joint["name"] for joint in self.robot["joints"]]
        states = {round(message["header"]["time"] * 1000): message for message in self.cat("robot_state")}
        fixed = self.read("/tf_static")[0][1]["transforms"]
        for time, message in self.read("/tf"):
            poses = {"world": np.eye(4)}
            for each in message["transforms"] + fixed:
                X = pose_of(each["transform"]["translation"], each["transform"]["rotation"])
                poses[each["child_frame_id"]] = poses[each["header"]["frame_id"]] @ X
            state = states[round(time * 1000)]
            X_WB = pose_of(state["X_WB"]["translation"], state["X_WB"]["rotation"])
            for link, X in kinematics.find_link_poses(urdf, X_WB, dict(zip(names, state["positions"]))).items():
                self.assertLess(np.abs(poses[link] - X).max(), POSE_TOLERANCE, f"{link} at {time} s")

    def test_joint_states_and_commands_are_those_of_the_log(self):
        names = [joint["name"] for joint in self.robot["joints"]]
        for topic, ours, fields in (("/joint_states", "sensor_data", ("positions", "velocities", "efforts")),
                                    ("/joint_commands", "joint_commands", ("positions", "velocities", "efforts"))):
            logged = {round(message["header"]["time"] * 1000): message for message in self.cat(ours)}
            read = self.read(topic)
            self.assertGreater(len(read), 95)
            for time, message in read:
                self.assertEqual(message["name"], names)
                expected = logged[round(time * 1000)]
                self.assertEqual([message["position"], message["velocity"], message["effort"]], [expected[field] for field in fields])

    def test_contact_wrenches_hold_the_robot(self):
        """The default run stands still at first: all wrenches together are the weight."""
        weight = 9.81 * kinematics.find_mass(self.robot["urdf"])
        state = next(message for message in self.cat("robot_state") if message["header"]["step"] == 400)
        names = [joint["name"] for joint in self.robot["joints"]]
        X_WB = pose_of(state["X_WB"]["translation"], state["X_WB"]["rotation"])
        poses = kinematics.find_link_poses(self.robot["urdf"], X_WB, dict(zip(names, state["positions"])))
        total = np.zeros(3)
        for channel in self.file.channels.values():
            if not channel["topic"].startswith("/contact/"):
                continue
            message = next(message for time, message in self.read(channel["topic"]) if abs(time - 0.4) < 1e-9)
            total += poses[message["header"]["frame_id"]][:3, :3] @ xyz(message["wrench"]["force"])
        self.assertAlmostEqual(total[2], weight, delta=0.05 * weight)  # it still sways a little

    def test_our_own_diagnosis_reads_the_bag(self):
        folder = self.bag.parent
        (folder / "robot.urdf").write_text(self.robot["urdf"])
        (folder / "experiment.yaml").write_text(
            "robot: robot.urdf\nbase: floating\nfeet: [L_ANKLE_R_LINK, R_ANKLE_R_LINK]\n"
            "recordings:\n  - {file: bag, role: train}\n  - {file: bag, role: validate}\n")
        said = subprocess.run([BIN / "hrp-diagnose", folder / "experiment.yaml", "--check", "--out", folder / "out"],
                              capture_output=True, text=True)
        self.assertIn("/joint_states", said.stdout + said.stderr)
        self.assertRegex(said.stdout + said.stderr, r"50(\.0+)? ?(Hz|samples)", said.stdout + said.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
