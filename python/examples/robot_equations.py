#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Kinematics and dynamics of a humanoid from its URDF."""
import numpy as np

import openhrp_dds

robot = openhrp_dds.load_robot("models/hrp2p_like/hrp2p_like.urdf")
state = openhrp_dds.State(q=np.full(robot.num_joints, 0.1), base_position=[0.0, 0.0, 0.7])
print(f"{robot.name}: {robot.num_joints} joints, {robot.mass:.1f} kg, centre of mass {robot.centre_of_mass(state).round(3)} m")

M, bias = robot.mass_matrix(state), robot.bias(state)
vdot = robot.forward_dynamics(state, efforts=np.zeros(robot.num_joints))
assert np.allclose(M @ vdot + bias, 0.0, atol=1e-8)  # nothing holds it: it falls
J = robot.jacobian(state, "L_ANKLE_R_LINK")
print(f"M is {M.shape}, the left foot's Jacobian {J.shape}; the centre of mass falls with "
      f"{(robot.centre_of_mass_jacobian(state) @ vdot)[2]:.2f} m/s^2")
