#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A controller of one's own. As a process of the server set, or imported: docs/tutorials/python.md.

    scripts/simulate.sh models/scenarios/hrp2p_stand.yaml --controller "python3 python/examples/my_controller.py"
"""
import numpy as np

import openhrp_dds


class MyController(openhrp_dds.Controller):
    """The robot stands and nods with its waist, faded in over the first second."""

    def start(self, robot):
        self.waist = robot.joints.index("WAIST_P")

    def step(self, observation):
        q = self.robot.initial_q.copy()
        q[self.waist] += 0.05 * min(1.0, observation.time) * np.sin(2.0 * np.pi * 0.5 * observation.time)
        return openhrp_dds.Command(q)


if __name__ == "__main__":
    MyController.main()
