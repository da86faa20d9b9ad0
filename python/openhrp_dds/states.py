# SPDX-License-Identifier: BSD-3-Clause
"""States of a robot in files."""
from __future__ import annotations

import zipfile

import numpy as np

from openhrp_dds._core import Robot, State

_PARTS = ("q", "qd", "base_position", "base_orientation", "base_velocity")


def write_state(path: str, state: State, robot: Robot) -> None:
    """Writes a State of the robot as a file of numpy (npz): the parts of a State and the names of the joints. An existing file is
    replaced."""
    if state.q.shape != (robot.num_joints,):
        raise ValueError(f"state.q must have shape ({robot.num_joints},) for robot '{robot.name}', not {state.q.shape}")
    with open(path, "wb") as file:
        np.savez(file, joints=np.array(robot.joints), **{part: getattr(state, part) for part in _PARTS})


def read_state(path: str, robot: Robot) -> State:
    """The State that write_state() wrote, with the same bits. Its joints may stand in another order, as those of a changed URDF
    do, but must be those of the robot. Raises ValueError."""
    try:
        with np.load(path, allow_pickle=False) as file:
            kept = {part: file[part] for part in (*_PARTS, "joints")}
    except (KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: no state of a robot: {error}") from None
    names = [str(name) for name in kept["joints"]]
    if sorted(names) != sorted(robot.joints):
        other = sorted(set(names) ^ set(robot.joints))
        raise ValueError(f"{path}: of another robot than '{robot.name}'; joints that only one has: {', '.join(other)}")
    order = [names.index(joint) for joint in robot.joints]
    return State(kept["q"][order], kept["qd"][order], **{part: kept[part] for part in _PARTS[2:]})
