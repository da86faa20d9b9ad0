# SPDX-License-Identifier: BSD-3-Clause
"""Forward kinematics of a URDF with numpy, from the specification of URDF alone."""
import xml.etree.ElementTree as xml

import numpy as np


def rotation_about(axis, angle):
    axis = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rotation_of(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def transform(R, p):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, p
    return X


def xyz(v):
    """Of a message with x, y and z."""
    return np.array([v["x"], v["y"], v["z"]])


def pose_of(position, q):
    """4x4, of messages of a place and a quaternion."""
    return transform(rotation_of(q["x"], q["y"], q["z"], q["w"]), xyz(position))


def numbers(element, key, default):
    return [float(x) for x in (element.get(key, default) if element is not None else default).split()]


def find_link_poses(urdf, X_WB, joints):
    """URDF text, pose of the root link (4x4), joint name -> position; link name -> pose in the world (4x4)."""
    tree = xml.fromstring(urdf)
    children, poses = {}, {}
    for joint in tree.findall("joint"):
        children.setdefault(joint.find("parent").get("link"), []).append(joint)
    below = {joint.find("child").get("link") for joint in tree.findall("joint")}
    root = next(link.get("name") for link in tree.findall("link") if link.get("name") not in below)

    def walk(link, X_WL):
        poses[link] = X_WL
        for joint in children.get(link, []):
            origin = joint.find("origin")
            roll, pitch, yaw = numbers(origin, "rpy", "0 0 0")
            R = rotation_about([0, 0, 1], yaw) @ rotation_about([0, 1, 0], pitch) @ rotation_about([1, 0, 0], roll)
            X = transform(R, numbers(origin, "xyz", "0 0 0"))
            axis, q = numbers(joint.find("axis"), "xyz", "1 0 0"), joints.get(joint.get("name"), 0.0)
            if joint.get("type") in ("revolute", "continuous"):
                X = X @ transform(rotation_about(axis, q), [0, 0, 0])
            elif joint.get("type") == "prismatic":
                X = X @ transform(np.eye(3), q * np.asarray(axis) / np.linalg.norm(axis))
            walk(joint.find("child").get("link"), X_WL @ X)

    walk(root, X_WB)
    return poses


def find_mass(urdf):
    return sum(float(mass.get("value")) for mass in xml.fromstring(urdf).findall("link/inertial/mass"))
