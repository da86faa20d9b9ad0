# SPDX-License-Identifier: BSD-3-Clause
"""Logs of runs (MCAP) as numpy arrays."""
from __future__ import annotations

from typing import Any, Dict, Iterator, List, Tuple

import numpy as np

from openhrp_dds import _core


class Log:
    """A log as a table: one row a sensor sample. log["/joint_states/knee/position"] is a column (T,), without a copy.

    Columns are named as in the recordings of the diagnosis: /joint_states/<joint>/position, velocity [rad, rad/s], effort
    [N m]; /joint_commands/<joint>/position; /imu/<name>/...; /wrench/<name>/force/x; /base/pose/... NaN: no value.
    """

    def __init__(self, path: str) -> None:
        self.path = str(path)
        names, values = _core.read_log_table(self.path)
        self.columns: List[str] = names
        """Names of the columns; the first one is "time"."""
        self.values: np.ndarray = values
        """(T, columns)."""
        self._index: Dict[str, int] = {name: i for i, name in enumerate(names)}

    @property
    def time(self) -> np.ndarray:
        """(T,) [s]."""
        return self["time"]

    @property
    def joints(self) -> List[str]:
        """Names of the joints with an encoder, in the robot's order."""
        end = "/position"
        return [name.split("/")[2] for name in self.columns if name.startswith("/joint_states/") and name.endswith(end)]

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._index:
            raise KeyError(f"{self.path} has no column '{name}'; it has {', '.join(self.columns[:8])}, ...")
        return self.values[:, self._index[name]]

    def __contains__(self, name: object) -> bool:
        return name in self._index

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.values)

    def joint_array(self, quantity: str = "position", commanded: bool = False) -> np.ndarray:
        """(T, joints) of one quantity of all joints: position [rad], velocity [rad/s], effort [N m]."""
        group = "/joint_commands/" if commanded else "/joint_states/"
        return np.column_stack([self[f"{group}{joint}/{quantity}"] for joint in self.joints])

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with the time [s] as its index. Needs the package python3-pandas."""
        import pandas
        return pandas.DataFrame(self.values[:, 1:], columns=self.columns[1:], index=pandas.Index(self.time, name="time"))

    def states(self) -> Dict[str, np.ndarray]:
        """The true state of every physics step: time (T,) [s]; q, qd, efforts (T, n); base_pose (T, 7) [m; w x y z];
        base_velocity (T, 6) [rad/s; m/s]; hash (T,) of the state's bits."""
        return _core.read_states(self.path)

    def contact_forces(self) -> Dict[Tuple[str, str], Dict[str, np.ndarray]]:
        """(body A, body B) -> time (T,) [s] of the steps in which they touch, and the wrench on A by cause: spring,
        damper, friction, total (T, 6) [N m; N], world axes."""
        return _core.read_contact_forces(self.path)


def read_log(path: str) -> Log:
    """Reads a log of a run. Raises RuntimeError when the file is none."""
    return Log(path)
