# SPDX-License-Identifier: BSD-3-Clause
"""Recordings for the diagnosis: CSV files and an experiment.yaml beside them."""
from __future__ import annotations

import json
import os
import pathlib
from dataclasses import dataclass
from typing import Any, Dict, Mapping, Optional, Sequence, Union

import numpy as np

from openhrp_dds.logs import Log

Columns = Mapping[str, Any]


def _take_columns(columns: Union[Columns, Log]) -> Dict[str, np.ndarray]:
    """Columns by name, all (T,) and time first."""
    if "time" not in columns:
        raise ValueError("columns must have 'time' [s]")
    taken = {name: np.asarray(columns[name], dtype=float) for name in columns}
    rows = taken["time"].shape
    for name, values in taken.items():
        if values.ndim != 1 or values.shape != rows:
            raise ValueError(f"column '{name}' must have shape {rows}, as 'time' has, not {values.shape}")
        if name != "time" and not name.startswith("/"):
            raise ValueError(f"column '{name}' must be named as a signal, /joint_states/<joint>/position for one")
    if not np.all(np.diff(taken["time"]) > 0.0):
        raise ValueError("column 'time' must rise from row to row")
    return {"time": taken.pop("time"), **taken}


def write_recording(path: str, columns: Union[Columns, Log]) -> None:
    """Writes a CSV recording: time (T,) [s], and signals (T,) such as /joint_states/<joint>/position [rad], velocity,
    effort [N m], /joint_commands/<joint>/position. NaN becomes an empty field. A Log is a set of columns, too."""
    taken = _take_columns(columns)
    table = np.column_stack(list(taken.values()))
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(taken) + "\n")
        for row in table:
            file.write(",".join("" if np.isnan(value) else repr(float(value)) for value in row) + "\n")


@dataclass
class Recording:
    """One recording of an experiment."""

    name: str
    """Of the file: NAME.csv."""
    columns: Union[Columns, Log]
    """Signals by name, or a Log."""
    role: str = "train"
    """train: effects are fitted to it; validate: they are judged on it."""


def write_experiment(folder: str, robot: str, recordings: Sequence[Recording], settings: Optional[Mapping[str, Any]] = None) -> str:
    """Writes FOLDER/experiment.yaml and its recordings; returns the file's path.

    robot: URDF file. settings: other keys of the experiment, which are those of scenarios (docs/scenario.md), such as
    {"base": "fixed", "servo": {"joints": {"knee": {"kp": 100, "kd": 5}}}, "noise": {"position": 1e-4}}.
    """
    if not recordings:
        raise ValueError("recordings must not be empty")
    if not any(r.role == "train" for r in recordings) or any(r.role not in ("train", "validate") for r in recordings):
        raise ValueError("recordings: each role must be 'train' or 'validate', and at least one 'train'")
    place = pathlib.Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    for recording in recordings:
        write_recording(str(place / (recording.name + ".csv")), recording.columns)
    keys: Dict[str, Any] = {"robot": os.path.relpath(robot, place), **(settings or {})}
    keys["recordings"] = [{"file": r.name + ".csv", "role": r.role} for r in recordings]
    # JSON is YAML, so no YAML library is needed.
    text = "".join(f"{key}: {json.dumps(value)}\n" for key, value in keys.items())
    path = place / "experiment.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)
