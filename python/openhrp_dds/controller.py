# SPDX-License-Identifier: BSD-3-Clause
"""Controllers in Python: one class, as a process of the server set and within this process."""
from __future__ import annotations

import sys
from typing import Optional, Sequence, Union

import numpy as np

from openhrp_dds import _core


class Controller:
    """Base class: write step(), and start() where there is something to prepare.

    As a process of the server set, in lockstep over DDS:

        if __name__ == "__main__":
            MyController.main()

        scripts/simulate.sh SCENARIO --controller "python3 my_controller.py"

    Within this process, with the same bits: openhrp_dds.Simulation(SCENARIO, controller=MyController()).
    """

    robot: _core.ControlledRobot
    """What the controller may know of its robot; set before start()."""

    def start(self, robot: _core.ControlledRobot) -> None:
        """Before the first observation, and again when the run is reset. Give all memory its first value here."""

    def step(self, observation: _core.Observation) -> Union[np.ndarray, _core.Command]:
        """The answer to one sample of the sensors, for the period that begins with it.

        With `drive: effort` in the scenario: efforts (n,) [N m or N]. With servos: a Command(q, qd, efforts).
        """
        raise NotImplementedError(type(self).__name__ + " has no step(self, observation)")

    @classmethod
    def main(cls) -> None:
        """The main of a controller's process: joins a run, answers until it ends, exits. --help tells the options."""
        sys.exit(run_controller(cls()))


def run_controller(controller: Controller, arguments: Optional[Sequence[str]] = None) -> int:
    """Joins a run as its controller and answers until it ends. Returns the exit status: 0 when the run ended as planned.

    arguments: of the command line (those of this process when left out); --help lists them. Without any, it looks for the
    run on this machine that waits for a controller.
    """
    if not callable(getattr(controller, "step", None)):
        raise TypeError(f"controller must be a Controller with step(observation), not {type(controller).__name__}")
    words = list(sys.argv[1:] if arguments is None else arguments)
    return _core.run_controller_process(controller, type(controller).__name__, words)
