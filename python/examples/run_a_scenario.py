#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs a walk in this process, looks at forces, goes back, and pushes on with the same bits."""
import numpy as np

import openhrp_dds

simulation = openhrp_dds.Simulation("models/scenarios/default.yaml")
record = simulation.run(steps=4000, every=5)  # four seconds; arrays with a row every 5 ms
print(f"t = {simulation.time:.3f} s, the base has moved by {record.base_position[-1, 0] - record.base_position[0, 0]:.3f} m")

for pair in simulation.contact_forces:
    spring, damper, friction = (np.linalg.norm(pair[cause][3:]) for cause in ("spring", "damper", "friction"))
    print(f"{pair['body_a']} on {pair['body_b']}: spring {spring:.0f} N, damper {damper:.0f} N, friction {friction:.0f} N")

saved = simulation.save()
simulation.step(1000)
first = simulation.state_hash
simulation.restore(saved)
simulation.step(1000)
assert simulation.state_hash == first
print("restored and continued: the same bits")
