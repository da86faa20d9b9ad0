#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""hide_in_recordings.py EXPERIMENT.yaml OUT --number N --seed S: real recordings with one known effect more.

The motion stays as it was recorded. A joint that had the effect would have needed the torque `more` in addition:

    effort'  = effort + more          where efforts are recorded
    command' = command + more / kp    where a servo with the stated gain kp drives the joint

so inverse dynamics of the changed log is exact, with all that the real machine has besides. Writes OUT/experiment.yaml, its
files and OUT/truth.json. Effects, joints and sizes are drawn from the seed; only joints with a drive and a position are drawn.
"""
import argparse
import csv
import json
import pathlib
import random
import shutil
import xml.etree.ElementTree

import numpy
import yaml

CUTOFF = 12.0          # [Hz] of the positions whose rates the additional torque follows
SLOW = 0.02            # [rad/s] at which dry friction is three quarters of its level
SHARE = (0.3, 0.9)     # additional torque over the spread of the joint's effort, root mean squares; log-uniform
ZERO = (0.05, 0.15)    # [rad]
TILT = (0.05, 0.12)    # [rad] of the base
FACTORS = (0.6, 0.7, 0.75, 1.3, 1.4, 1.5)  # of a mass
GAINS = (0.7, 0.75, 0.8, 1.25, 1.35)       # logged effort over true torque
VELOCITY = (0.85, 0.9, 1.1, 1.2)           # logged velocity over true one
RATES = (0.05, 0.2)    # of a joint's largest speed: zero of its velocity


def low_pass(time, x):
    """Zero-phase Gaussian on an even grid: x, its rate and the rate's rate at the recording's stamps."""
    step = float(numpy.median(numpy.diff(time)))
    grid = numpy.arange(time[0], time[-1] + 0.5 * step, step)
    sigma = max(1.0, 1.0 / (2.0 * numpy.pi * CUTOFF) / step)
    kernel = numpy.exp(-0.5 * (numpy.arange(-int(5 * sigma), int(5 * sigma) + 1) / sigma) ** 2)
    pad = len(kernel)
    smooth = numpy.convolve(numpy.pad(numpy.interp(grid, time, x), pad, mode="edge"), kernel / kernel.sum(), "same")[pad:-pad]
    rate = numpy.gradient(smooth, step)
    return [numpy.interp(time, grid, y) for y in (smooth, rate, numpy.gradient(rate, step))]


class Log:
    """One recording: columns by name, [s], [rad], [N m]."""

    def __init__(self, path):
        with open(path, newline="") as file:
            rows = list(csv.reader(file))
        self.names = rows[0]
        self.table = numpy.array([[float(cell) if cell else numpy.nan for cell in row] for row in rows[1:]])

    def find(self, group, joint, quantity):
        name = f"/{group}/{joint}/{quantity}"
        return self.names.index(name) if name in self.names else None

    def get(self, group, joint, quantity):
        at = self.find(group, joint, quantity)
        return None if at is None else self.table[:, at]

    def motion(self, joint):
        q, time = self.get("joint_states", joint, "position"), self.table[:, 0]
        known = numpy.isfinite(q)
        return [numpy.interp(time, time[known], x) for x in low_pass(time[known], q[known])]

    def add(self, joint, more, kp):
        effort, command = self.find("joint_states", joint, "effort"), self.find("joint_commands", joint, "position")
        if effort is not None:
            self.table[:, effort] += more
        if command is not None and kp:
            self.table[:, command] += more / kp

    def write(self, path):
        with open(path, "w", newline="") as file:
            out = csv.writer(file)
            out.writerow(self.names)
            out.writerows(["" if numpy.isnan(x) else f"{x:.9g}" for x in row] for row in self.table)


class Machine:
    def __init__(self, path):
        self.folder = path.parent
        self.spec = yaml.safe_load(path.read_text())
        files = [entry["file"] for entry in self.spec["recordings"]]
        self.logs = {name: Log(self.folder / name) for name in files}
        self.joints = [j for j in self.list_joints() if self.spread(j) > 0.0]

    def list_joints(self):
        passive = self.spec.get("unactuated", [])
        names = {n.split("/")[2] for log in self.logs.values() for n in log.names if n.startswith("/joint_states/")}
        complete = lambda j: all(log.get("joint_states", j, "position") is not None for log in self.logs.values())
        return sorted(j for j in names if j not in passive and complete(j))

    def kp(self, joint):
        servo = self.spec.get("servo", {})
        return (servo.get("joints", {}).get(joint) or servo.get("default") or {}).get("kp")

    def has(self, group, joint, quantity):
        return all(log.get(group, joint, quantity) is not None for log in self.logs.values())

    def spread(self, joint):
        """[N m] Standard deviation of what drives the joint: the effort, else the servo's law from the stated gain."""
        series = []
        for log in self.logs.values():
            effort, command = log.get("joint_states", joint, "effort"), log.get("joint_commands", joint, "position")
            if effort is None and command is not None and self.kp(joint):
                effort = self.kp(joint) * (command - log.get("joint_states", joint, "position"))
            series.append(numpy.zeros(0) if effort is None else effort)
        all_of_it = numpy.concatenate(series)
        return float(numpy.nanstd(all_of_it)) if all_of_it.size else 0.0

    def size(self, joint, shape):
        """Root mean square of a law's torque for a parameter of one."""
        return float(numpy.sqrt(numpy.mean(numpy.concatenate([shape(*log.motion(joint)) for log in self.logs.values()]) ** 2)))

    def add(self, joint, law):
        for log in self.logs.values():
            log.add(joint, law(*log.motion(joint)), self.kp(joint))


# Laws: torque [N m] that the drive gives in addition, of position, velocity and acceleration, for a parameter of one.
LAWS = {"viscous_friction": ("coefficient", lambda q, v, a: v),
        "coulomb_friction": ("level", lambda q, v, a: numpy.tanh(v / SLOW)),
        "rotor_inertia": ("inertia", lambda q, v, a: a),
        "constant_torque": ("torque", lambda q, v, a: numpy.ones_like(q)),
        "parallel_spring": ("stiffness", lambda q, v, a: q)}


def hide_law(effect):
    def hide(machine, joint, draw):
        name, law = LAWS[effect]
        share = SHARE[0] * (SHARE[1] / SHARE[0]) ** draw.random()
        value = share * machine.spread(joint) / machine.size(joint, law)
        machine.add(joint, lambda q, v, a: value * law(q, v, a))
        return {"effect": effect, "joint": joint, name: value}
    return hide


def hide_zero(machine, joint, draw):
    value = draw.uniform(*ZERO) * draw.choice((-1, 1))
    for log in machine.logs.values():
        for group in ("joint_states", "joint_commands"):
            if log.find(group, joint, "position") is not None:
                log.table[:, log.find(group, joint, "position")] += value
    return {"effect": "joint_offset", "joint": joint, "offset": value}


def hide_gain(machine, joint, draw):
    value = draw.choice(GAINS)
    for log in machine.logs.values():
        log.table[:, log.find("joint_states", joint, "effort")] *= value
    return {"effect": "torque_constant_error", "joint": joint, "scale": 1.0 / value}


def hide_velocity(effect):
    def hide(machine, joint, draw):
        fastest = max(numpy.nanmax(abs(log.get("joint_states", joint, "velocity"))) for log in machine.logs.values())
        scale, zero = (draw.choice(VELOCITY), 0.0) if effect == "sensor_scale" else (1.0, draw.uniform(*RATES) * fastest)
        for log in machine.logs.values():
            at = log.find("joint_states", joint, "velocity")
            log.table[:, at] = scale * log.table[:, at] + zero
        said = {"scale": scale} if effect == "sensor_scale" else {"value": zero}
        return {"effect": effect, "sensor": f"/joint_states/{joint}/velocity", **said}
    return hide


def hide_mass(machine, joint, draw):
    """The model's link beyond the joint has the mass and inertia of the true one over a factor."""
    value = draw.choice(FACTORS)
    robot = machine.folder / machine.spec["robot"]
    tree = xml.etree.ElementTree.parse(robot)
    link = next(j.find("child").get("link") for j in tree.iter("joint") if j.get("name") == joint)
    inertial = next(l.find("inertial") for l in tree.iter("link") if l.get("name") == link)
    inertial.find("mass").set("value", repr(float(inertial.find("mass").get("value")) / value))
    for key, number in inertial.find("inertia").attrib.items():
        inertial.find("inertia").set(key, repr(float(number) / value))
    machine.robot = xml.etree.ElementTree.tostring(tree.getroot(), encoding="unicode")
    return {"effect": "mass_error", "link": link, "scale": value}


def hide_tilt(machine, joint, draw):
    roll, pitch = (draw.uniform(*TILT) * draw.choice((-1, 1)) for _ in range(2))
    cr, sr, cp, sp = numpy.cos(roll), numpy.sin(roll), numpy.cos(pitch), numpy.sin(pitch)
    turn = numpy.array([[cp, sp * sr, sp * cr], [0, cr, -sr], [-sp, cp * sr, cp * cr]])
    # The true base has the recorded attitude, so the model's gravity is that of a base that is turned the other way.
    machine.spec["gravity"] = [float(x) for x in turn @ numpy.array(machine.spec.get("gravity", [0, 0, -9.81]), dtype=float)]
    return {"effect": "base_tilt", "joint": joint, "roll": roll, "pitch": pitch}


def list_ways(machine, joint):
    ways = [hide_law(effect) for effect in LAWS] + [hide_zero, hide_mass, hide_tilt]
    if machine.has("joint_states", joint, "effort"):
        ways.append(hide_gain)
    if machine.has("joint_states", joint, "velocity"):
        ways += [hide_velocity("sensor_scale"), hide_velocity("sensor_bias")]
    return ways


def write(machine, source, out, truth):
    out.mkdir(parents=True, exist_ok=True)
    (out / "experiment.yaml").write_text(yaml.safe_dump(machine.spec, sort_keys=False))
    robot = out / machine.spec["robot"]
    shutil.copyfile(source.parent / machine.spec["robot"], robot)
    if getattr(machine, "robot", None):
        robot.write_text(machine.robot)
    for name, log in machine.logs.items():
        log.write(out / name)
    (out / "truth.json").write_text(json.dumps({"experiment": str(source.parent.name), "hidden": [truth]}, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("experiment", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--number", type=int, default=1, help="cases, each with one effect; all kinds in turn")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    order = []
    draw = random.Random(given.seed)
    for k in range(given.number):
        machine = Machine(given.experiment)
        if not machine.joints:
            parser.exit(2, f"{given.experiment}: no joint has a position and an effort, or a command with a stated gain kp\n")
        joint = draw.choice(machine.joints)
        ways = list_ways(machine, joint)
        if not order:
            order = draw.sample(range(len(ways)), len(ways))
        truth = ways[order.pop() % len(ways)](machine, joint, draw)
        name = given.experiment.resolve().parent.name
        write(machine, given.experiment, given.out / f"{name}-{k + 1:02d}", truth)


if __name__ == "__main__":
    main()
