#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""find_friction.py DIR: records an arm that has friction, and asks the diagnosis what its model lacks.

"Reality" here is a simulation, too: the same arm with 0.3 N m of dry friction in axis2.
"""
import pathlib
import sys

import numpy as np

import openhrp_dds

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
ROBOT = pathlib.Path("models/experiments/arm/robot.urdf").resolve()
SETTINGS = {"base": "fixed", "steps": {"time_step": 0.001, "control_period": 0.004},
            "servo": {"joints": {"axis1": {"kp": 264, "kd": 7.13}, "axis2": {"kp": 51.6, "kd": 1.63},
                                 "axis3": {"kp": 20, "kd": 0.738}, "axis4": {"kp": 2.92, "kd": 0.0751}}}}
NOISE = {"position": 5e-5, "velocity": 5e-3, "effort": 0.0165}


class Excite(openhrp_dds.Controller):
    """Sines with random phases in all joints; keeps what it sees and says."""

    def __init__(self, seed):
        self.seed = seed
        self.rows = []

    def start(self, robot):
        random = np.random.default_rng(self.seed)
        self.frequency = random.uniform(0.2, 1.2, size=(len(robot.joints), 4))  # [Hz]
        self.reference = robot.initial_q  # what the servos have reached: a command is approached over one period
        self.phase = random.uniform(0.0, 2.0 * np.pi, size=(len(robot.joints), 4))

    def step(self, observation):
        t = observation.time
        q = 0.2 * min(1.0, t) * np.sin(2.0 * np.pi * self.frequency * t + self.phase).sum(axis=1)
        self.rows.append(np.concatenate([[t], self.reference, observation.q, observation.qd, observation.efforts]))
        self.reference = q
        return openhrp_dds.Command(q)

    def columns(self):
        names = ["time"]
        for signal in ("joint_commands/{}/position", "joint_states/{}/position", "joint_states/{}/velocity", "joint_states/{}/effort"):
            names += ["/" + signal.format(joint) for joint in self.robot.joints]
        return dict(zip(names, np.array(self.rows).T))


reality = folder / "reality.yaml"
encoders = f"{{encoders: {{position_noise: {NOISE['position']}, velocity_noise: {NOISE['velocity']}, effort_noise: {NOISE['effort']}}}}}"
servos = "".join(f"\n    {joint}: {{kp: {gains['kp']}, kd: {gains['kd']}}}" for joint, gains in SETTINGS["servo"]["joints"].items())
reality.write_text(f"""robot: {ROBOT}
base: fixed
steps: {{time_step: 0.001, control_period: 0.004}}
servo:
  joints:{servos}
sensors: {encoders}
joint_laws:
  axis2: {{coulomb_friction: {{level: 0.3}}}}
""", encoding="utf-8")

recordings = []
for seed in (1, 2, 3):
    controller = Excite(seed)
    openhrp_dds.Simulation(str(reality), controller=controller).step(10000)
    recordings.append(openhrp_dds.Recording(f"recording_{seed}", controller.columns(), "validate" if seed == 3 else "train"))
experiment = openhrp_dds.write_experiment(str(folder / "experiment"), str(ROBOT), recordings, {**SETTINGS, "noise": NOISE})

report = openhrp_dds.diagnose(experiment, str(folder / "report"))
print(f"{report.verdict}: {report.summary}")
for finding in report.findings:
    values = ", ".join(f"{name} {p['value']:.3g} {p['unit']} (95 %: {p['ci95'][0]:.3g} to {p['ci95'][1]:.3g})" for name, p in finding.parameters.items())
    print(f"{finding.grade}: {finding.effect} at {finding.where}: {values}")

try:
    from openhrp_dds import plots
    plots.plot_report(report).figure.savefig(folder / "report.png")
    print(f"{folder / 'report.png'}: recorded, nominal and updated")
except ImportError as error:
    print(error)
