#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""pictures_test.py BIN SOURCE: pictures and scans of a walk as a node of ROS 2 uses them: depth image, camera_info, frames and points of
a bag, read by a small reader of our own, lie on the ground and on the wall of the scenario."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

import plain_mcap
import urdf_kinematics as kinematics
from programs import run

BIN, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
WALL = 3.0  # [m] x of its face
SINGLE = 1e-6  # a range is in single precision: some roundings of 6e-8 of it each
SENSORS = """  camera: {head: {link: NECK_P_LINK, xyz: [0.1, 0, 0.1], rpy: [0.1, 0.5, 0.2], width: 48, height: 36, near: 0.3, rate: 4}}
  lidar: {scan: {link: WAIST_P_LINK, xyz: [0.18, 0, 0.3], columns: 40, rows: 6, azimuth: [-1.2, 1.2], elevation: [-0.7, 0.1], rate: 4}}
"""
MORE = f"logging: {{pictures: true}}\nobstacles: {{wall: {{size: [0.2, 30, 9], position: [{WALL + 0.1}, 0, 0]}}}}\n"


def pose_of(transform):
    return kinematics.pose_of(transform["translation"], transform["rotation"])


class PicturesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory(prefix="hrp-pictures-")
        cls.folder = pathlib.Path(cls.holder.name)
        text = (SOURCE / "models/scenarios/default.yaml").read_text().replace("../", f"{SOURCE}/models/")
        (cls.folder / "walk.yaml").write_text(text.replace("sensors:\n", "sensors:\n" + SENSORS, 1) + MORE)
        run(BIN / "hrp-simulate", cls.folder / "walk.yaml", "--in-process", "--duration", 4, "--quiet", "--no-plot", "--log", cls.folder / "run.mcap")
        run(BIN / "hrp-log", "rosbag", cls.folder / "run.mcap", "--out", cls.folder / "bag", "--rate", 200)
        cls.file = plain_mcap.File(cls.folder / "bag/bag_0.mcap")

    @classmethod
    def tearDownClass(cls):
        cls.holder.cleanup()

    def read(self, topic):
        decoder = plain_mcap.Decoder(self.file.find_channel(topic)["schema"])
        return {round(time * 1000): decoder.read(data) for time, data in self.file.topic(topic)}

    def find_poses(self):
        """Time in ms -> frame -> pose in the world."""
        fixed = self.read("/tf_static")[0]["transforms"]
        found = {}
        for time, message in self.read("/tf").items():
            poses = {"world": np.eye(4)}
            for each in message["transforms"] + fixed:
                poses[each["child_frame_id"]] = poses[each["header"]["frame_id"]] @ pose_of(each["transform"])
            found[time] = poses
        return found

    def check(self, points, ranges, share):
        """Points of the world [m] are on the floor or on the wall, and none is behind them."""
        floor, wall = np.abs(points[:, 2]) < SINGLE * ranges, np.abs(points[:, 0] - WALL) < SINGLE * ranges
        self.assertGreater(np.mean(floor | wall), share, "the rest is the robot itself")
        self.assertGreater(np.sum(floor), 20)
        self.assertGreater(np.sum(wall), 20)
        self.assertTrue(np.all(points[:, 2] > -SINGLE * ranges))
        self.assertTrue(np.all(points[:, 0] < WALL + SINGLE * ranges))

    def test_depth_info_and_frames_put_every_pixel_on_floor_and_wall(self):
        poses, infos = self.find_poses(), self.read("/head/camera_info")
        images = self.read("/head/depth/image_raw")
        self.assertEqual(len(images), 16, "four a second, none of the last step")
        for time, image in images.items():
            stamp = image["header"]["stamp"]
            self.assertEqual(stamp["sec"] * 1000 + stamp["nanosec"] // 10**6, time)
            depth = np.frombuffer(bytes(image["data"]), "<f4").reshape(image["height"], image["width"]).astype(float)
            k = np.array(infos[time]["k"]).reshape(3, 3)
            v, u = np.nonzero(np.isfinite(depth))
            z = depth[v, u]
            optical = np.stack([z * (u - k[0, 2]) / k[0, 0], z * (v - k[1, 2]) / k[1, 1], z, np.ones_like(z)])
            points = (poses[time][image["header"]["frame_id"]] @ optical)[:3].T
            self.check(points, np.linalg.norm(optical[:3], axis=0), 0.95)

    def test_points_of_the_lidar_are_on_floor_and_wall(self):
        poses = self.find_poses()
        clouds = self.read("/scan/points")
        self.assertEqual(len(clouds), 16)
        for time, cloud in clouds.items():
            self.assertEqual([field["name"] for field in cloud["fields"]], ["x", "y", "z", "intensity"])
            numbers = np.frombuffer(bytes(cloud["data"]), "<f4").reshape(-1, cloud["point_step"] // 4).astype(float)
            seen = numbers[np.isfinite(numbers[:, 0]), :3]
            points = (poses[time][cloud["header"]["frame_id"]] @ np.c_[seen, np.ones(len(seen))].T)[:3].T
            self.check(points, np.linalg.norm(seen, axis=1), 0.8)

    def test_the_layout_of_foxglove_shows_pictures_of_the_log(self):
        out = self.folder / "foxglove.mcap"
        said = run(BIN / "hrp-log", "foxglove", self.folder / "run.mcap", "--out", out, "--rate", 4)
        self.assertIn("cameras.json", said)
        file, layout = plain_mcap.File(out), json.loads((SOURCE / "share/foxglove/cameras.json").read_text())
        shown = {panel["imageMode"]["imageTopic"] for name, panel in layout["configById"].items() if name.startswith("Image!")}
        self.assertEqual(shown, {"/head/image_raw", "/head/depth/image_raw"})
        for topic in shown:
            schema = file.find_channel(topic)["schema"]
            self.assertEqual((schema["name"], schema["encoding"]), ("sensor_msgs/msg/Image", "ros2msg"))
            ours, bags = ([data for _, data in each.topic(topic)] for each in (file, self.file))
            self.assertEqual(ours, bags, "the pictures that other tests look at")
        topics = {channel["topic"] for channel in file.channels.values()}
        self.assertLessEqual({panel["imageMode"]["calibrationTopic"] for name, panel in layout["configById"].items() if name.startswith("Image!")}, topics)
        self.assertLessEqual(set(layout["configById"]["3D!robot"]["topics"]), topics)

    def test_an_image_is_written_as_png(self):
        for topic, kind in (("head/image_raw", 2), ("head/depth/image_raw", 0)):
            out = self.folder / "image.png"
            run(BIN / "hrp-log", "image", self.folder / "run.mcap", topic, "--at", 2, "--out", out)
            data = out.read_bytes()
            self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual((int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")), (48, 36))
            self.assertEqual(data[25], kind, "colour, or grey")
            self.assertEqual(int.from_bytes(data[29:33], "big"), zlib.crc32(data[12:29]))
        refused = subprocess.run([BIN / "hrp-log", "image", self.folder / "run.mcap", "head/image_raw", "--at", "9", "--out", out], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("has no image at or after 9", refused.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
