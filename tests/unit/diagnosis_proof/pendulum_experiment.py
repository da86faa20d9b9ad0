# SPDX-License-Identifier: BSD-3-Clause
"""An experiment that a test makes itself, so that no other program is needed: a servoed pendulum by explicit steps."""
import math
import re

URDF = """<?xml version="1.0"?>
<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/><inertia ixx="0.03" iyy="0.03" izz="0.005" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="one" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
</robot>
"""
YAML = """robot: robot.urdf
base: fixed
servo:
  joints:
    one: {kp: 200, kd: 8, effort_limit: 50}
initial:
  joints: {one: 0}
recordings:
  - {file: train_1.csv, role: train}
  - {file: validate_1.csv, role: validate}
"""
HEAD = ["time", "/joint_commands/one/position", "/joint_commands/one/velocity", "/joint_states/one/position",
        "/joint_states/one/velocity", "/joint_states/one/effort"]



def make_rows(phase, seconds=2.0, step=0.004, kp=200, kd=8, pace=3.0):
    """A servoed pendulum, semi-implicit steps of 0.1 ms, with a ripple of 1e-5 in place of noise."""
    inertia, moment = 0.03 + 2 * 0.2 * 0.2, 2 * 9.81 * 0.2
    q = v = t = 0.0
    rows = []
    for k in range(int(seconds / step)):
        w = 1e-5 * math.sin(1e4 * (k * 0.37 + phase) ** 2)
        c, cd = 0.4 * math.sin(pace * t + phase) - 0.4 * math.sin(phase), 0.4 * pace * math.cos(pace * t + phase)
        effort = kp * (c - q) + kd * (cd - v)
        rows.append([t, c, cd, q + w, v + 100 * w, effort + 500 * w])
        for _ in range(int(step / 1e-4)):
            c, cd = 0.4 * math.sin(pace * t + phase) - 0.4 * math.sin(phase), 0.4 * pace * math.cos(pace * t + phase)
            v += 1e-4 * (kp * (c - q) + kd * (cd - v) - moment * math.sin(q)) / inertia
            q += 1e-4 * v
            t += 1e-4
    return rows


ROWS = {"train_1.csv": make_rows(0.3), "validate_1.csv": make_rows(1.7)}
ROWS_TWO = {"train_1.csv": make_rows(0.9, kp=120, kd=5, pace=4.1), "validate_1.csv": make_rows(2.6, kp=120, kd=5, pace=4.1)}
URDF_TWO = URDF.replace("</robot>", "").replace('"upper"', '"first"') + re.sub("\"one\"", "\"two\"", URDF[URDF.index('  <link name="upper"'):]).replace('"upper"', '"second"')
YAML_TWO = YAML.replace("    one: {kp: 200, kd: 8, effort_limit: 50}", "    one: {kp: 200, kd: 8, effort_limit: 50}\n    two: {kp: 120, kd: 5, effort_limit: 50}")


def make_csv(rows, head=HEAD):
    return "\n".join([",".join(head)] + [",".join(f"{x:.9g}" if isinstance(x, float) else str(x) for x in r) for r in rows]) + "\n"
