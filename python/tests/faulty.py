# SPDX-License-Identifier: BSD-3-Clause
"""Controllers that go wrong at step 20, each in its own way; the environment says which one runs as a process."""
import os

import numpy as np

import openhrp_dds


class Faulty(openhrp_dds.Controller):
    def step(self, observation):
        efforts = np.zeros(len(self.robot.joints))
        return efforts if observation.step < 20 else self.go_wrong(efforts)


class Raises(Faulty):
    def go_wrong(self, efforts):
        raise KeyError("no plan")


class WrongShape(Faulty):
    def go_wrong(self, efforts):
        return np.zeros(len(efforts) + 1)


class NotANumber(Faulty):
    def go_wrong(self, efforts):
        efforts[-1] = np.nan
        return efforts


class ReturnsNothing(Faulty):
    def go_wrong(self, efforts):
        return None


class FailsToStart(openhrp_dds.Controller):
    def start(self, robot):
        raise RuntimeError("no gains")


class HasNoStep(openhrp_dds.Controller):
    pass


# What is said of each: by the server set, and within this process.
WORDS = {"Raises": r"controller 'Raises' at step 20 \(t = 0.0200 s\): KeyError: 'no plan' \(.*faulty.py:\d+\)",
         "WrongShape": r"controller 'WrongShape' at step 20 .*efforts must have shape \(\d+,\), not \(\d+,\)",
         "NotANumber": r"controller 'NotANumber' at step 20 .*NaN in efforts of joint '\w+'",
         "ReturnsNothing": r"controller 'ReturnsNothing' at step 20 .*efforts \(an array\) or a Command, not None",
         "FailsToStart": r"controller 'FailsToStart' in start\(\): RuntimeError: no gains",
         "HasNoStep": r"controller 'HasNoStep' at step 0 .*HasNoStep has no step\(self, observation\)"}

if __name__ == "__main__":
    globals()[os.environ["FAULTY"]].main()
