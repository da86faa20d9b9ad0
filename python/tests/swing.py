# SPDX-License-Identifier: BSD-3-Clause
"""A controller with memory for the arm of places.py: efforts that follow a slow swing. As a process, or imported."""
import numpy as np

import openhrp_dds


class Swing(openhrp_dds.Controller):
    def start(self, robot):
        self.error = np.zeros(len(robot.joints))

    def step(self, observation):
        wanted = 0.3 * np.sin(2.0 * observation.time) * np.ones_like(self.error)
        error = wanted - observation.q
        self.error = self.error + error * self.robot.period
        return 20.0 * error - 2.0 * observation.qd + 5.0 * self.error


if __name__ == "__main__":
    Swing.main()
