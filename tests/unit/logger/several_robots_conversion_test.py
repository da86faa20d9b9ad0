#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""several_robots_conversion_test.py BIN SOURCE: what Foxglove and ROS 2 are given of a run with three robots, decoded and compared
with the run. Each robot has a namespace and a prefix of its frames; the first one has none."""
import json
import sys
import unittest

import numpy as np

import plain_mcap
import urdf_kinematics as kinematics
from programs import BIN, SOURCE, LoggedRun, run
from urdf_kinematics import pose_of, xyz

ROBOTS = ("", "walker/", "partner/")
POSE_TOLERANCE = {"json": 2e-8, "cdr": 1e-12}  # nine digits of metres and of quaternions along ten joints; rounding
FORCE_TOLERANCE = 1e-5  # [N] of 600: nine digits
ARROW_LENGTH, GRAVITY = 0.5, 9.81  # [m] of the first robot's weight, [m/s^2]: docs/tutorials/foxglove.md


class SeveralRobots(LoggedRun):
    @classmethod
    def setUpClass(cls):
        cls.log_run("several_robots.yaml", 0.3)
        out, bag = cls.folder / "foxglove.mcap", cls.folder / "bag"
        run(BIN / "hrp-log", "foxglove", cls.log, "--out", out, "--rate", 20)
        run(BIN / "hrp-log", "rosbag", cls.log, "--out", bag, "--rate", 20)
        cls.foxglove, cls.bag = plain_mcap.File(out), plain_mcap.File(bag / "bag_0.mcap")
        cls.states = {message["header"]["step"]: message for message in cls.cat("robot_state")}
        cls.forces = {message["header"]["step"]: message for message in cls.cat("contact_forces")}
        cls.urdfs = {robot: cls.read_bag(f"/{robot}robot_description")[0][1]["data"] for robot in ROBOTS}

    @classmethod
    def read_bag(cls, topic):
        decoder = plain_mcap.Decoder(cls.bag.find_channel(topic)["schema"])
        return [(time, decoder.read(data)) for time, data in cls.bag.topic(topic)]

    @classmethod
    def read_scene(cls, topic):
        return [(round(time * 1000), json.loads(data)) for time, data in cls.foxglove.topic(topic)]

    def find_state(self, robot, step):
        state = self.states[step]
        return state if robot == "" else next(each for each in state["robots"] if each["name"] + "/" == robot)

    def expect_kinematics(self, poses, step, tolerance):
        for robot in ROBOTS:
            state = self.find_state(robot, step)
            names = [joint["name"] for joint in self.joints(robot)]
            X_WB = pose_of(state["X_WB"]["translation"], state["X_WB"]["rotation"])
            links = kinematics.find_link_poses(self.urdfs[robot], X_WB, dict(zip(names, state["positions"])))
            self.assertGreater(len(links), 15)
            for link, X in links.items():
                self.assertLess(np.abs(poses[robot + link] - X).max(), tolerance, f"{robot}{link} in step {step}")

    def joints(self, robot):
        return [{"name": name} for name in self.read_bag(f"/{robot}joint_states")[0][1]["name"]]

    def test_every_link_of_every_robot_is_a_frame_with_its_prefix(self):
        fixed = self.read_scene("/transforms/fixed")[0][1]["transforms"]
        moving = self.read_scene("/transforms")
        self.assertEqual(len(moving), 7)
        for step, message in moving:
            poses = {"world": np.eye(4)}
            for each in message["transforms"] + fixed:
                poses[each["child_frame_id"]] = poses[each["parent_frame_id"]] @ pose_of(each["translation"], each["rotation"])
            self.expect_kinematics(poses, step, POSE_TOLERANCE["json"])

    def test_one_tf_has_the_frames_of_all_robots(self):
        self.assertEqual([name for name in self.list_bag() if name.endswith("/tf") or name.endswith("/clock")], ["/clock", "/tf"])
        fixed = self.read_bag("/tf_static")[0][1]["transforms"]
        for time, message in self.read_bag("/tf"):
            poses = {"world": np.eye(4)}
            for each in message["transforms"] + fixed:
                X = pose_of(each["transform"]["translation"], each["transform"]["rotation"])
                poses[each["child_frame_id"]] = poses[each["header"]["frame_id"]] @ X
            self.expect_kinematics(poses, round(time * 1000), POSE_TOLERANCE["cdr"])

    def list_bag(self):
        return sorted(channel["topic"] for channel in self.bag.channels.values())

    def test_each_namespace_has_the_samples_of_its_robot(self):
        for robot in ROBOTS:
            for ros, ours in (("joint_states", "sensor_data"), ("joint_commands", "joint_commands")):
                logged = {round(m["header"]["time"] * 1000): m["positions"] for m in self.cat(f"hrp/{robot}{ours}")}
                found = self.read_bag(f"/{robot}{ros}")
                self.assertGreater(len(found), 5)
                for time, message in found:
                    self.assertEqual(message["position"], logged[round(time * 1000)], f"{robot}{ros}")
        self.assertEqual(self.read_bag("/walker/imu/chest")[0][1]["header"]["frame_id"][:7], "walker/")
        self.assertEqual(self.read_bag("/walker/contact/L_ANKLE_R_LINK")[0][1]["header"]["frame_id"], "walker/L_ANKLE_R_LINK")

    def test_arrows_are_the_forces_on_the_feet_of_all_robots(self):
        metres_per_newton = ARROW_LENGTH / (GRAVITY * kinematics.find_mass(self.urdfs[""]))
        step, message = self.read_scene("/scene/contacts")[-1]
        arrows = {entity["id"]: entity["arrows"][0] for entity in message["entities"] if entity["arrows"]}
        expected = {}
        for pair in self.forces[step]["pairs"]:
            if pair["body_b"] < 0:
                expected.setdefault("force/" + pair["name_a"], np.zeros(3))
                expected["force/" + pair["name_a"]] += xyz(pair["total"]["force"])
        self.assertEqual(set(arrows), {id for id, force in expected.items() if force.any()})
        self.assertEqual({id.count("/") for id in arrows}, {1, 2}, "feet of the first robot and of others")
        for id, arrow in arrows.items():
            R = pose_of(arrow["pose"]["position"], arrow["pose"]["orientation"])[:3, :3]
            force = (arrow["shaft_length"] + arrow["head_length"]) * R[:, 0] / metres_per_newton
            self.assertLess(np.abs(force - expected[id]).max(), FORCE_TOLERANCE, id)

    def test_each_robot_has_the_zmp_about_which_its_own_forces_have_no_level_moment(self):
        step, message = self.read_scene("/scene/contacts")[-1]
        entities = {entity["id"]: entity for entity in message["entities"]}
        for robot in ROBOTS:
            zmp = xyz(entities[robot + "zmp"]["spheres"][0]["pose"]["position"])
            self.assertLess(np.abs(zmp - xyz(self.read_bag(f"/{robot}zmp")[-1][1]["point"])).max(), 1e-8)
            moment = np.zeros(3)
            for pair in self.forces[step]["pairs"]:
                if pair["body_b"] == -1 and pair["name_a"].rpartition("/")[0] == robot[:-1]:
                    moment += xyz(pair["total"]["moment"]) + np.cross(xyz(pair["reference"]) - zmp, xyz(pair["total"]["force"]))
            self.assertLess(np.abs(moment[:2]).max(), 1e-5, robot)  # [N m] 600 N times nine digits of metres
            corners = np.array([xyz(p) for p in entities[robot + "support_polygon"]["lines"][0]["points"]])
            self.assertTrue((corners.min(axis=0) - 1e-6 <= zmp)[:2].all() and (zmp <= corners.max(axis=0) + 1e-6)[:2].all(), robot)

    def test_shapes_are_fixed_to_the_frames_of_their_robot(self):
        entities = self.read_scene("/scene/robot")[0][1]["entities"]
        self.assertEqual(len({entity["id"] for entity in entities}), len(entities), "no robot replaces another one")
        for entity in entities:
            self.assertEqual(entity["id"], "link/" + entity["frame_id"])
        self.assertEqual({entity["frame_id"].rpartition("/")[0] for entity in entities}, {"", "walker", "partner"})

    def test_the_layout_for_one_robot_names_topics_that_are_there(self):
        layout = json.loads((SOURCE / "share/foxglove/robot.json").read_text())["configById"]
        named = set(next(panel for id, panel in layout.items() if id.startswith("3D!"))["topics"])
        for panel in layout.values():
            named |= {path["value"].split(".")[0] for path in panel.get("paths", [])}
        topics = {channel["topic"] for channel in self.foxglove.channels.values()}
        self.assertIn("/scene/contacts", named)
        self.assertLessEqual(named, topics)

    def test_urdfs_are_attached_by_the_names_of_their_robots(self):
        for robot in ROBOTS:
            self.assertEqual(self.foxglove.attachments[(robot[:-1] or "robot") + ".urdf"].decode(), self.urdfs[robot])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
