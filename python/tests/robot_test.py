# SPDX-License-Identifier: BSD-3-Clause
"""Multibody functions in Python: two ways to the same number, and arguments that cannot be."""
import unittest

import numpy as np

import openhrp_dds
from places import ARM, ROOT

HUMANOID = ROOT / "models" / "hrp2p_like" / "hrp2p_like.urdf"


def random_state(robot, seed):
    """Fixed seeds: the claims hold for any state."""
    random = np.random.default_rng(seed)
    orientation = random.normal(size=4)
    return openhrp_dds.State(random.normal(size=robot.num_joints), random.normal(size=robot.num_joints),
                             base_position=random.normal(size=3), base_orientation=orientation / np.linalg.norm(orientation),
                             base_velocity=random.normal(size=6))


class Equations(unittest.TestCase):
    # Relative to forces of 1e3 N m and N: a few hundred operations of double precision.
    TOLERANCE = 1e-8

    def setUp(self):
        self.robot = openhrp_dds.load_robot(str(HUMANOID))
        self.state = random_state(self.robot, 1)
        self.vdot = np.random.default_rng(2).normal(size=self.robot.nv)

    def test_inverse_dynamics_is_mass_matrix_times_acceleration_plus_bias(self):
        expected = self.robot.mass_matrix(self.state) @ self.vdot + self.robot.bias(self.state)
        np.testing.assert_allclose(self.robot.inverse_dynamics(self.state, self.vdot), expected, atol=self.TOLERANCE)

    def test_forward_dynamics_undoes_inverse_dynamics(self):
        efforts = np.random.default_rng(3).normal(size=self.robot.num_joints)
        wrench = {self.robot.links[5]: np.arange(6.0)}
        vdot = self.robot.forward_dynamics(self.state, efforts, wrench)
        tau = self.robot.inverse_dynamics(self.state, vdot, wrench)
        np.testing.assert_allclose(tau, np.concatenate([np.zeros(6), efforts]), atol=self.TOLERANCE)

    def test_a_wrench_acts_through_the_jacobian(self):
        frame, wrench = self.robot.links[-1], np.arange(1.0, 7.0)
        with_wrench = self.robot.inverse_dynamics(self.state, self.vdot, {frame: wrench})
        without = self.robot.inverse_dynamics(self.state, self.vdot)
        np.testing.assert_allclose(without - with_wrench, self.robot.jacobian(self.state, frame).T @ wrench, atol=self.TOLERANCE)

    def test_the_jacobian_gives_the_velocity(self):
        for frame in (self.robot.frames[0], self.robot.frames[-1]):
            J, v = self.robot.jacobian(self.state, frame), self.robot.generalised_velocity(self.state)
            np.testing.assert_allclose(J @ v, self.robot.velocity(self.state, frame), atol=self.TOLERANCE)

    def test_the_jacobian_is_the_derivative_of_the_pose(self):
        frame, dt = self.robot.frames[-1], 1e-6
        v = self.robot.generalised_velocity(self.state)
        before = self.robot.pose(self.robot.integrate(self.state, v, -dt), frame)[:3, 3]
        after = self.robot.pose(self.robot.integrate(self.state, v, dt), frame)[:3, 3]
        # Central differences: the third derivative times dt^2, and rounding over dt.
        np.testing.assert_allclose((after - before) / (2 * dt), self.robot.velocity(self.state, frame)[3:], atol=1e-7)

    def test_the_regressor_times_the_parameters_is_inverse_dynamics(self):
        Y_BI, Y_JI, Y_JJ = self.robot.regressor(self.state, self.vdot)
        p, r = self.robot.inertial_parameters, self.robot.joint_parameters.copy()
        r[1::3] = r[2::3] = 0.0  # inverse dynamics has no friction
        tau = self.robot.inverse_dynamics(self.state, self.vdot)
        np.testing.assert_allclose(np.concatenate([Y_BI @ p, Y_JI @ p + Y_JJ @ r]), tau, atol=self.TOLERANCE)

    def test_the_centre_of_mass_moves_with_the_momentum(self):
        J = self.robot.centre_of_mass_jacobian(self.state)
        momentum = self.robot.centroidal_momentum(self.state)[3:]
        np.testing.assert_allclose(J @ self.robot.generalised_velocity(self.state) * self.robot.mass, momentum, atol=self.TOLERANCE)

    def test_kinetic_energy_is_half_v_m_v(self):
        v = self.robot.generalised_velocity(self.state)
        self.assertAlmostEqual(self.robot.kinetic_energy(self.state), 0.5 * v @ self.robot.mass_matrix(self.state) @ v, places=8)

    def test_a_fixed_base_has_no_rows_of_its_own(self):
        arm = openhrp_dds.load_robot(str(ARM), floating_base=False)
        self.assertEqual(arm.nv, arm.num_joints)
        self.assertEqual(arm.poses(arm.zero_state()).shape, (len(arm.links), 4, 4))


class Arguments(unittest.TestCase):
    def setUp(self):
        self.robot = openhrp_dds.load_robot(str(ARM), floating_base=False)
        self.n = self.robot.num_joints

    def test_wrong_shapes_are_named_with_the_expected_one(self):
        with self.assertRaisesRegex(ValueError, rf"state.q must have shape \({self.n},\).*not \(1,\)"):
            self.robot.mass_matrix(openhrp_dds.State([0.0]))
        with self.assertRaisesRegex(ValueError, rf"efforts must have shape \({self.n},\), not \(2, 2\)"):
            self.robot.forward_dynamics(self.robot.zero_state(), np.zeros((2, 2)))
        with self.assertRaisesRegex(ValueError, r"base_velocity must have shape \(6,\)"):
            openhrp_dds.State([0.0], base_velocity=[1.0])

    def test_what_is_no_number_is_a_type_error(self):
        with self.assertRaisesRegex(TypeError, "efforts must be an array of numbers, not str"):
            self.robot.forward_dynamics(self.robot.zero_state(), "strong")
        with self.assertRaises(TypeError):
            self.robot.mass_matrix(np.zeros(3))

    def test_nan_is_refused_with_its_place(self):
        vdot = np.zeros(self.n)
        vdot[1] = np.nan
        with self.assertRaisesRegex(ValueError, r"vdot\[1\] is NaN"):
            self.robot.inverse_dynamics(self.robot.zero_state(), vdot)

    def test_unknown_names_list_the_known_ones(self):
        with self.assertRaisesRegex(ValueError, f"no frame 'nose'; frames: .*{self.robot.links[0]}"):
            self.robot.pose(self.robot.zero_state(), "nose")

    def test_a_turned_quaternion_must_be_a_unit(self):
        with self.assertRaisesRegex(ValueError, "base_orientation must be a unit quaternion"):
            openhrp_dds.State([0.0], base_orientation=[1.0, 1.0, 0.0, 0.0])

    def test_a_file_that_is_not_there_is_an_input_error(self):
        with self.assertRaisesRegex(openhrp_dds.InputError, "nowhere.urdf.*no such file"):
            openhrp_dds.load_robot("nowhere.urdf")

    def test_arrays_of_a_state_look_into_it_and_outlive_it(self):
        state = openhrp_dds.State(np.arange(3.0))
        self.assertIs(state.q.base, state)
        self.assertFalse(state.q.flags.writeable)
        q = state.q
        del state
        np.testing.assert_array_equal(q, [0.0, 1.0, 2.0])


if __name__ == "__main__":
    unittest.main()
