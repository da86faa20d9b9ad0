#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""keep_states.py FILE: keeps a state in a file and begins another run there; keeps a run and goes back to it."""
import sys

import openhrp_dds

SCENARIO = "models/scenarios/hrp2p_stand.yaml"
path = sys.argv[1] if len(sys.argv) > 1 else "state.npz"

simulation = openhrp_dds.Simulation(SCENARIO)
simulation.step(1000)
openhrp_dds.write_state(path, simulation.state, simulation.robot)

other = openhrp_dds.Simulation(SCENARIO)
other.reset(openhrp_dds.read_state(path, other.robot))
assert other.state.hash == simulation.state.hash
print(f"{path}: the same state, at step {other.step_number} of another run")

saved = simulation.save()
simulation.step(500)
first = simulation.state_hash
simulation.restore(saved)
simulation.step(500)
assert simulation.state_hash == first
print("restored and continued: the same bits")
