#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""same_bits.py LOG: runs my_controller.py in this process and compares with the log of its run in the server set."""
import sys

import numpy as np

import openhrp_dds
from my_controller import MyController

states = openhrp_dds.read_log(sys.argv[1]).states()
simulation = openhrp_dds.Simulation("models/scenarios/hrp2p_stand.yaml", controller=MyController())
record = simulation.run(steps=len(states["time"]) - 1)
assert np.array_equal(record.q, states["q"][1:])
assert simulation.state_hash == states["hash"][-1]
print(f"{len(record.time)} steps with the same bits, state hash {simulation.state_hash:016x}")
