# SPDX-License-Identifier: BSD-3-Clause
"""The usual plots with matplotlib (package python3-matplotlib). Not imported by openhrp_dds itself.

Each function draws into `axes`, or into a new figure, and returns the axes.
"""
from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np

from openhrp_dds._core import Record
from openhrp_dds.diagnosis import DiagnosisReport
from openhrp_dds.logs import Log

try:
    import matplotlib.pyplot as plt
except ImportError as error:
    raise ImportError("openhrp_dds.plots needs matplotlib: apt-get install python3-matplotlib") from error


def _make_axes(axes: Any, title: str, label: str) -> Any:
    if axes is None:
        axes = plt.subplots(figsize=(9, 5), constrained_layout=True)[1]
    axes.set_title(title)
    axes.set_xlabel("time [s]")
    axes.set_ylabel(label)
    axes.grid(True, alpha=0.3)
    return axes


def plot_joints(log: Log, joints: Optional[Sequence[str]] = None, quantity: str = "position", axes: Any = None) -> Any:
    """Trajectories of joints from a Log; dashed: the command, where it was recorded."""
    unit = {"position": "rad", "velocity": "rad/s", "effort": "N m"}
    if quantity not in unit:
        raise ValueError(f"quantity must be one of {', '.join(unit)}, not '{quantity}'")
    axes = _make_axes(axes, f"joint {quantity}", f"{quantity} [{unit[quantity]}]")
    for joint in log.joints if joints is None else joints:
        line, = axes.plot(log.time, log[f"/joint_states/{joint}/{quantity}"], label=joint)
        command = f"/joint_commands/{joint}/{quantity}"
        if command in log:
            axes.plot(log.time, log[command], "--", color=line.get_color(), linewidth=0.8)
    axes.legend(fontsize="small", ncol=2)
    return axes


def plot_contact_forces(source: Union[Log, Record], feet: Optional[Sequence[str]] = None, cause: str = "total", axes: Any = None) -> Any:
    """Vertical contact forces [N]: of a Record by foot, of a Log by pair of bodies and `cause` (spring, damper, friction,
    total)."""
    axes = _make_axes(axes, "contact forces", "vertical force [N]")
    if isinstance(source, Record):
        for i in range(source.foot_forces.shape[1]):
            axes.plot(source.time, source.foot_forces[:, i], label=feet[i] if feet is not None else f"foot {i}")
    else:
        for (body_a, body_b), forces in source.contact_forces().items():
            if feet is None or body_a in feet:
                axes.plot(forces["time"], forces[cause][:, 5], ".", markersize=2, label=f"{body_a} on {body_b}")
    axes.legend(fontsize="small")
    return axes


def plot_comparison(recorded: Union[Log, Mapping[str, np.ndarray]], simulated: Mapping[str, Union[Log, Mapping[str, np.ndarray]]],
                    column: str, axes: Any = None) -> Any:
    """One signal as recorded and as simulated: {"nominal": log, "updated": log}. `column` as /joint_states/knee/position."""
    axes = _make_axes(axes, column, column.rsplit("/", 1)[-1])
    axes.plot(recorded["time"], recorded[column], "k", linewidth=2.0, alpha=0.5, label="recorded")
    for name, table in simulated.items():
        axes.plot(table["time"], table[column], label=name)
    axes.legend(fontsize="small")
    return axes


def plot_report(report: DiagnosisReport, signal: Optional[str] = None, axes: Any = None) -> Any:
    """One signal of a report: recorded, nominal and updated (docs/diagnosis_series.md). The one that differs most when
    none is named."""
    series = report.series
    names = [each["name"] for each in series.get("signals", [])]
    traces = [(names[trace["signal"]], trace) for recording in series.get("recordings", []) for trace in recording.get("traces", [])]
    chosen = [(name, trace) for name, trace in traces if signal is None or name == signal]
    if not chosen:
        raise ValueError(f"signal '{signal}' has no curve in {report.folder}; those with one: {', '.join(sorted({n for n, _ in traces}))}")
    name, trace = chosen[0]
    axes = _make_axes(axes, name, series["signals"][names.index(name)].get("unit", ""))
    for key, label, style in (("recorded", "recorded", "k"), ("before", "nominal", "C1"), ("after", "updated", "C0")):
        if key in trace:
            axes.plot(trace["time"], np.array(trace[key], dtype=float), style, label=label)
    axes.legend(fontsize="small")
    return axes
