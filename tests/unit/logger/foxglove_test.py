#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""foxglove_test.py BIN SOURCE: what Foxglove is given of a run (`hrp-log foxglove`), decoded and compared with the run."""
import json
import sys
import unittest

import numpy as np

import plain_mcap
import urdf_kinematics as kinematics
from programs import BIN, SOURCE, LoggedRun, run
from urdf_kinematics import pose_of, xyz

POSE_TOLERANCE = 2e-8   # nine digits of metres and of quaternions, along ten joints
ARROW_LENGTH, GRAVITY = 0.5, 9.81  # [m] of the robot's weight, [m/s^2]: docs/tutorials/foxglove.md
POLYGON_TOLERANCE = 1e-6  # [m] nine digits of the corners


def check_schema(schema, value, where):
    """The part of JSON Schema that the schemas of Foxglove use."""
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
    assert isinstance(value, kinds[schema["type"]]), f"{where}: {schema['type']} expected, is {value!r}"
    if schema["type"] == "object":
        assert set(value) == set(schema["required"]), f"{where}: {sorted(value)}, expected {schema['required']}"
        for key, part in value.items():
            check_schema(schema["properties"][key], part, f"{where}.{key}")
    elif schema["type"] == "array":
        for i, part in enumerate(value):
            check_schema(schema["items"], part, f"{where}[{i}]")


def is_inside(polygon, p):
    """Whether a point lies in a convex polygon whose corners go round counter-clockwise, seen from above."""
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        along = (b - a)[:2]
        if along[0] * (p - a)[1] - along[1] * (p - a)[0] < -POLYGON_TOLERANCE * np.linalg.norm(along):
            return False
    return True


class FoxgloveTest(LoggedRun):
    @classmethod
    def setUpClass(cls):
        # The first two steps of the walk: both feet, one foot, the other one.
        cls.log_run("default.yaml", 3)
        out = cls.folder / "foxglove.mcap"
        run(BIN / "hrp-log", "foxglove", cls.log, "--out", out, "--rate", 20)
        cls.out, cls.file = out, plain_mcap.File(out)
        cls.urdf = cls.file.attachments["robot.urdf"].decode()
        cls.robot = cls.cat("robot_description")[0]
        cls.states = {message["header"]["step"]: message for message in cls.cat("robot_state")}
        cls.forces = {message["header"]["step"]: message for message in cls.cat("contact_forces")}

    def json(self, topic):
        return [(round(time * 1000), json.loads(data)) for time, data in self.file.topic(topic)]

    def pressing_pairs(self, step):
        return [pair for pair in self.forces[step]["pairs"] if pair["body_b"] < 0]

    def test_messages_follow_the_schemas_they_come_with(self):
        for channel, _, data in self.file.messages:
            schema = channel["schema"]
            if channel["encoding"] != "json":
                continue
            self.assertEqual(schema["encoding"], "jsonschema")
            self.assertIn(schema["name"], ("foxglove.FrameTransforms", "foxglove.SceneUpdate"))
            check_schema(json.loads(schema["text"]), json.loads(data), channel["topic"])

    def test_every_link_of_the_urdf_is_where_its_kinematics_say(self):
        names = [joint["name"] for joint in self.robot["joints"]]
        fixed = self.json("/transforms/fixed")[0][1]["transforms"]
        moving = self.json("/transforms")
        self.assertEqual(len(moving), 61)
        for step, message in moving:
            poses = {"world": np.eye(4)}
            for each in message["transforms"] + fixed:
                poses[each["child_frame_id"]] = poses[each["parent_frame_id"]] @ pose_of(each["translation"], each["rotation"])
            state = self.states[step]
            X_WB = pose_of(state["X_WB"]["translation"], state["X_WB"]["rotation"])
            expected = kinematics.find_link_poses(self.urdf, X_WB, dict(zip(names, state["positions"])))
            self.assertGreater(len(expected), 15)
            for link, X in expected.items():
                self.assertLess(np.abs(poses[link] - X).max(), POSE_TOLERANCE, f"{link} in step {step}")

    def test_arrows_are_the_forces_on_the_feet(self):
        metres_per_newton = ARROW_LENGTH / (GRAVITY * kinematics.find_mass(self.urdf))
        counts = set()
        for step, message in self.json("/scene/contacts"):
            arrows = {entity["id"]: entity["arrows"][0] for entity in message["entities"] if entity["arrows"]}
            expected = {}
            for pair in self.pressing_pairs(step):
                expected.setdefault("force/" + pair["name_a"], np.zeros(3))
                expected["force/" + pair["name_a"]] += xyz(pair["total"]["force"])
            self.assertEqual({id for id, force in expected.items() if force.any()}, set(arrows), f"step {step}")
            counts.add(len(arrows))
            for id, arrow in arrows.items():
                R = pose_of(arrow["pose"]["position"], arrow["pose"]["orientation"])[:3, :3]
                force = (arrow["shaft_length"] + arrow["head_length"]) * R[:, 0] / metres_per_newton
                self.assertLess(np.abs(force - expected[id]).max(), 1e-5, f"{id} in step {step}")  # [N] of 600: nine digits
        self.assertEqual(counts, {0, 1, 2}, "step 0 has no forces; the walk stands on one foot and on two")

    def test_zmp_has_no_level_moment_and_lies_in_the_support_polygon(self):
        seen = 0
        for step, message in self.json("/scene/contacts"):
            entities = {entity["id"]: entity for entity in message["entities"]}
            if "zmp" not in entities:
                continue
            seen += 1
            zmp = xyz(entities["zmp"]["spheres"][0]["pose"]["position"])
            moment = np.zeros(3)
            for pair in self.pressing_pairs(step):
                moment += xyz(pair["total"]["moment"]) + np.cross(xyz(pair["reference"]) - zmp, xyz(pair["total"]["force"]))
            self.assertLess(np.abs(moment[:2]).max(), 1e-5, f"step {step}")  # [N m] 600 N times nine digits of metres
            polygon = [xyz(p) for p in entities["support_polygon"]["lines"][0]["points"]]
            self.assertTrue(is_inside(polygon, zmp), f"step {step}")
        self.assertGreater(seen, 50)

    def test_shapes_are_fixed_to_their_links(self):
        entities = {entity["id"]: entity for entity in self.json("/scene/robot")[0][1]["entities"]}
        kinds = {"SHAPE_BOX": "cubes", "SHAPE_SPHERE": "spheres", "SHAPE_CYLINDER": "cylinders", "SHAPE_MESH": "triangles"}
        for i, link in enumerate(self.robot["links"]):
            entity = entities["link/" + link["name"]]
            self.assertEqual((entity["frame_id"], entity["frame_locked"]), (link["name"], True))
            shapes = [shape for shape in self.robot["shapes"] if shape["link"] == i]
            for kind, name in kinds.items():
                self.assertEqual(len(entity[name]), sum(shape["kind"] == kind for shape in shapes), link["name"])
        boxes = [shape for shape in self.robot["shapes"] if shape["kind"] == "SHAPE_BOX"]
        drawn = [cube["size"] for entity in entities.values() for cube in entity["cubes"]]
        self.assertEqual(sorted(sorted(xyz(s)) for s in drawn), sorted(sorted(xyz(shape["size"])) for shape in boxes))

    def test_urdf_is_attached_and_on_its_topic(self):
        channel = self.file.find_channel("/robot_description")
        self.assertEqual((channel["schema"]["name"], channel["schema"]["encoding"]), ("std_msgs/msg/String", "ros2msg"))
        data = plain_mcap.Decoder(channel["schema"]).read(self.file.topic("/robot_description")[0][1])["data"]
        self.assertEqual(data, self.robot["urdf"])
        self.assertEqual(self.urdf, self.robot["urdf"])
        self.assertIn("scenario.yaml", self.file.attachments)

    def test_all_of_the_log_is_still_there(self):
        theirs = set(run(BIN / "hrp-log", "hash", self.out).splitlines())
        self.assertLessEqual(set(run(BIN / "hrp-log", "hash", self.log).splitlines()), theirs)

    def test_layout_names_topics_that_are_there(self):
        layout = json.loads((SOURCE / "share/foxglove/robot.json").read_text())
        panels, topics = layout["configById"], {channel["topic"] for channel in self.file.channels.values()}
        self.assertEqual(len(panels), 4)
        named = set(next(panel for id, panel in panels.items() if id.startswith("3D!"))["topics"])
        for panel in panels.values():
            named |= {path["value"].split(".")[0] for path in panel.get("paths", [])}
        self.assertLessEqual(named, topics)

        def leaves(node):
            return {node} if isinstance(node, str) else leaves(node["first"]) | leaves(node["second"])
        self.assertEqual(leaves(layout["layout"]), set(panels))

    def test_zmp_and_support_polygon_are_there_on_terrain(self):
        log, out = (self.folder / name for name in ("waves.mcap", "waves_foxglove.mcap"))
        run(BIN / "hrp-simulate", SOURCE / "models/scenarios/terrain.yaml", "--in-process", "--duration", 0.5, "--quiet", "--no-plot",
            "--log", log)
        run(BIN / "hrp-log", "foxglove", log, "--out", out)
        message = json.loads(plain_mcap.File(out).topic("/scene/contacts")[-1][1])
        entities = {entity["id"]: entity for entity in message["entities"]}
        zmp = xyz(entities["zmp"]["spheres"][0]["pose"]["position"])
        polygon = [xyz(p) for p in entities["support_polygon"]["lines"][0]["points"]]
        self.assertTrue(is_inside(polygon, zmp))
        self.assertLess(abs(zmp[2]), 1e-3)  # [m] the field is level at the start; soles sink in by less

    def test_an_object_and_a_push_on_it_are_where_the_state_says(self):
        scenario, log, out = (self.folder / name for name in ("crate.yaml", "crate.mcap", "crate_foxglove.mcap"))
        scenario.write_text(
            f"robot: {SOURCE}/models/test_robots/box.urdf\nground: {{type: none}}\ncontroller: {{type: hold}}\nsteps: {{duration: 0.2}}\n"
            "objects: {crate: {size: [0.3, 0.2, 0.1], mass: 2, position: [1, 0.5, 2], velocity: [0.4, 0, 0]}}\n"
            "pushes:\n  shove: {link: crate, force: [0, 3, 4], xyz: [0.1, 0, 0.05], start: 0, duration: 1}\n")
        run(BIN / "hrp-simulate", scenario, "--in-process", "--log", log, "--no-plot", "--quiet")
        run(BIN / "hrp-log", "foxglove", log, "--out", out)
        file = plain_mcap.File(out)
        robot = {entity["id"]: entity for entity in json.loads(file.topic("/scene/robot")[0][1])["entities"]}
        self.assertEqual(robot["object/crate"]["frame_id"], "crate")
        self.assertEqual(robot["object/crate"]["cubes"][0]["size"], {"x": 0.3, "y": 0.2, "z": 0.1})
        at = [t["translation"] for t in json.loads(file.topic("/transforms")[-1][1])["transforms"] if t["child_frame_id"] == "crate"]
        self.assertAlmostEqual(at[0]["x"], 1.08, delta=0.01)  # 0.4 m/s for 0.2 s; the push beside its middle turns it, too
        arrow = json.loads(file.topic("/scene/pushes")[1][1])["entities"][0]["arrows"][0]["pose"]["position"]
        self.assertAlmostEqual(arrow["x"], 1.1, delta=0.02)  # 0.1 m from the middle of the crate
        self.assertAlmostEqual(arrow["z"], 2.05, delta=0.02)

    def test_pushes_and_hands_are_arrows_at_their_points(self):
        scenario, log, out = (self.folder / name for name in ("pushed.yaml", "pushed.mcap", "pushed_foxglove.mcap"))
        scenario.write_text(
            f"robot: {SOURCE}/models/test_robots/box.urdf\nfeet: [box]\ninitial: {{position: [1, 2, 3], rpy: [0, 0, 1.5707963267948966]}}\n"
            "pushes:\n  shove: {link: box, force: [0, 3, 4], xyz: [0.1, 0, 0.05], start: 0, duration: 0.01}\n")
        run(BIN / "hrp-simulate", scenario, "--in-process", "--duration", 0.02, "--quiet", "--no-plot", "--log", log)
        run(BIN / "hrp-log", "foxglove", log, "--out", out, "--rate", 0)
        pictures = [json.loads(data)["entities"] for _, data in plain_mcap.File(out).topic("/scene/pushes")]
        self.assertEqual([len(entities) for entities in pictures], [0] + 10 * [1] + 10 * [0])  # of state k: over the step that ended there
        arrow, metadata = pictures[1][0]["arrows"][0], pictures[1][0]["metadata"]
        X = pose_of(arrow["pose"]["position"], arrow["pose"]["orientation"])
        # [m] the box has fallen by g dt^2 and turned a little in one step of 1 ms.
        self.assertLess(np.abs(X[:3, 3] - [1, 2.1, 3.05]).max(), 1e-4)
        self.assertLess(np.abs(X[:3, 0] - [0, 0.6, 0.8]).max(), 1e-6)
        self.assertEqual(metadata, [{"key": "box [N]", "value": "0 3 4"}])

    def test_surfaces_stand_where_the_scenario_puts_them(self):
        scenario, log, out = (self.folder / name for name in ("world.yaml", "world.mcap", "world_foxglove.mcap"))
        terrain = SOURCE / "models/terrain"
        scenario.write_text(
            f"robot: {SOURCE}/models/test_robots/box.urdf\nfeet: [box]\ninitial: {{position: [0, 0, 2]}}\nobstacles:\n"
            f"  stairs: {{shape: mesh, file: {terrain}/stairs.obj, scale: 2, position: [1, 2, 3], rpy: [0, 0, 1.5707963267948966]}}\n"
            f"  waves: {{shape: height_field, file: {terrain}/waves.csv, spacing: 0.05}}\n")
        run(BIN / "hrp-simulate", scenario, "--in-process", "--duration", 0.01, "--quiet", "--no-plot", "--log", log)
        run(BIN / "hrp-log", "foxglove", log, "--out", out)
        stairs, waves = json.loads(plain_mcap.File(out).topic("/scene/world")[0][1])["entities"][0]["triangles"]
        corners = [line.split()[1:] for line in (terrain / "stairs.obj").read_text().splitlines() if line.startswith("v ")]
        expected = [(1 - 2 * float(y), 2 + 2 * float(x), 3 + 2 * float(z)) for x, y, z in corners]  # turned by 90 degrees about z
        X = pose_of(stairs["pose"]["position"], stairs["pose"]["orientation"])
        drawn = [(X @ np.append(xyz(point), 1))[:3] for point in stairs["points"]]
        self.assertEqual(len(drawn), 16)
        for point in expected:
            self.assertLess(min(np.abs(p - point).max() for p in drawn), 1e-6, point)  # single precision in the reader of meshes
        self.assertEqual(len(stairs["indices"]), 3 * 28)
        self.assertEqual((len(waves["points"]), len(waves["indices"])), (161 * 81, 6 * 160 * 80))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
