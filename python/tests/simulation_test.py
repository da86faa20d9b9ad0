# SPDX-License-Identifier: BSD-3-Clause
"""Runs within Python's process: the bits of the programs, going back, forces by cause, threads."""
import copy
import pathlib
import pickle
import tempfile
import threading
import unittest

import numpy as np

import openhrp_dds
from places import SCENARIOS, simulate, write_arm

DEFAULT = str(SCENARIOS / "default.yaml")
SQUAT = str(SCENARIOS / "squat.yaml")


class SameBits(unittest.TestCase):
    def check_program(self, scenario, seconds):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "run.mcap"
            run = simulate(scenario, "--in-process", "--duration", seconds, log=log)
            self.assertEqual(run.returncode, 0, run.stderr)
            states = openhrp_dds.read_log(str(log)).states()
        simulation = openhrp_dds.Simulation(scenario)
        steps = len(states["time"]) - 1
        record = simulation.run(steps)
        np.testing.assert_array_equal(record.q, states["q"][1:])
        np.testing.assert_array_equal(record.qd, states["qd"][1:])
        np.testing.assert_array_equal(record.base_position, states["base_pose"][1:, :3])
        self.assertEqual(simulation.state_hash, int(states["hash"][-1]))

    def test_a_walk_is_that_of_the_program(self):
        self.check_program(DEFAULT, 2.0)

    def test_a_motion_that_says_where_the_robot_begins_is_that_of_the_program(self):
        self.check_program(SQUAT, 0.5)

    def test_many_steps_in_one_call_are_single_steps(self):
        one, many = openhrp_dds.Simulation(DEFAULT), openhrp_dds.Simulation(DEFAULT)
        many.step(300)
        for _ in range(300):
            one.step()
        self.assertEqual(one.state_hash, many.state_hash)

    def test_a_reset_run_repeats(self):
        simulation = openhrp_dds.Simulation(DEFAULT)
        simulation.step(500)
        first = simulation.state_hash
        simulation.reset()
        self.assertEqual(simulation.step_number, 0)
        simulation.step(500)
        self.assertEqual(simulation.state_hash, first)


class Pushed(unittest.TestCase):
    def test_a_push_is_that_of_a_scenario_with_it(self):
        text = pathlib.Path(SQUAT).read_text().replace("robot: ../", f"robot: {SCENARIOS.parent}/").replace("motion: ../", f"motion: {SCENARIOS.parent}/")
        text += "pushes:\n  nudge: {link: R_HAND_LINK, force: [8, -3, 1], xyz: [0, 0.01, 0], start: 0.1, duration: 0.05}\n"
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "pushed.yaml"
            path.write_text(text)
            scripted = openhrp_dds.Simulation(str(path))
            scripted.step(300)
        live = openhrp_dds.Simulation(SQUAT)
        live.step(100)
        live.push("R_HAND_LINK", [8, -3, 1], 50, point=[0, 0.01, 0])
        self.assertEqual(live.pushes, [])
        live.step()
        self.assertEqual([push["link"] for push in live.pushes], ["R_HAND_LINK"])
        np.testing.assert_array_equal(live.pushes[0]["force"], [8, -3, 1])
        live.step(199)
        self.assertEqual(live.pushes, [])
        self.assertEqual(live.state_hash, scripted.state_hash)

    def test_a_restored_run_is_pushed_on_with_the_same_bits(self):
        simulation = openhrp_dds.Simulation(SQUAT)
        simulation.push("R_HAND_LINK", [8, 0, 0], 100)
        simulation.step(30)
        saved = simulation.save()
        simulation.step(200)
        end = simulation.state_hash
        simulation.restore(saved)
        simulation.step(200)
        self.assertEqual(simulation.state_hash, end)

    def test_another_simulation_is_pushed_on_and_pushed_again(self):
        one, other = openhrp_dds.Simulation(SQUAT), openhrp_dds.Simulation(SQUAT)
        for force in (8, 5):
            one.push("R_HAND_LINK", [force, 0, 0], 100)
        one.step(30)
        other.restore(one.save())
        for simulation in (one, other):
            simulation.push("R_HAND_LINK", [0, 4, 0], 50)
            simulation.step(20)
            np.testing.assert_array_equal(simulation.pushes[0]["force"], [0, 4, 0])
        self.assertEqual(one.state_hash, other.state_hash)

    def test_what_nobody_can_push_is_refused(self):
        simulation = openhrp_dds.Simulation(SQUAT)
        with self.assertRaisesRegex(ValueError, "no link 'tail'"):
            simulation.push("tail", [1, 0, 0], 10)
        with self.assertRaisesRegex(ValueError, r"force\[0\] is NaN"):
            simulation.push("R_HAND_LINK", [float("nan"), 0, 0], 10)


class GoingBack(unittest.TestCase):
    def test_a_restored_walk_goes_on_with_the_same_bits(self):
        simulation = openhrp_dds.Simulation(DEFAULT)
        simulation.step(2503)  # in the middle of a control period, of a step, with rolling feet
        saved = simulation.save()
        first = simulation.run(700)
        end = simulation.state_hash
        simulation.restore(saved)
        self.assertEqual(simulation.step_number, 2503)
        second = simulation.run(700)
        np.testing.assert_array_equal(first.q, second.q)
        self.assertEqual(simulation.state_hash, end)

    def test_another_simulation_goes_on_with_the_same_bits(self):
        simulation, other = openhrp_dds.Simulation(DEFAULT), openhrp_dds.Simulation(DEFAULT)
        simulation.step(1200)
        other.restore(simulation.save())
        simulation.step(300)
        other.step(300)
        self.assertEqual(simulation.state_hash, other.state_hash)

    def test_what_is_of_another_scenario_is_refused(self):
        with self.assertRaisesRegex(ValueError, "saved: is of another scenario"):
            openhrp_dds.Simulation(SQUAT).restore(openhrp_dds.Simulation(DEFAULT).save())

    def test_commands_that_were_given_come_back_too(self):
        with tempfile.TemporaryDirectory() as folder:
            simulation = openhrp_dds.Simulation(write_arm(folder), controller=None)
            simulation.set_command(np.full(simulation.robot.num_joints, 0.3))
            simulation.step(50)
            saved = simulation.save()
            simulation.step(50)
            end = simulation.state_hash
            simulation.set_command(np.zeros(simulation.robot.num_joints))
            simulation.step(10)
            simulation.restore(saved)
            simulation.step(50)
            self.assertEqual(simulation.state_hash, end)

    def test_a_run_begins_at_a_state_that_is_set(self):
        with tempfile.TemporaryDirectory() as folder:
            simulation = openhrp_dds.Simulation(write_arm(folder), controller=None)
            n = simulation.robot.num_joints
            state = openhrp_dds.State(np.linspace(-0.3, 0.4, n), np.linspace(0.1, 0.2, n))
            simulation.step(7)
            simulation.reset(state)
            np.testing.assert_array_equal(simulation.state.q, state.q)
            np.testing.assert_array_equal(simulation.state.qd, state.qd)
            self.assertEqual(simulation.step_number, 0)
            with self.assertRaisesRegex(ValueError, r"state.q must have shape"):
                simulation.reset(openhrp_dds.State([0.0] * (n + 1)))


class StatesInFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = str(pathlib.Path(folder.name) / "state.npz")
        self.simulation = openhrp_dds.Simulation(str(SCENARIOS / "hrp2p_stand.yaml"))
        self.simulation.step(333)
        self.state = self.simulation.state
        openhrp_dds.write_state(self.path, self.state, self.simulation.robot)

    def test_what_is_read_has_the_bits_of_what_was_written(self):
        read = openhrp_dds.read_state(self.path, self.simulation.robot)
        self.assertEqual(read.hash, self.state.hash)
        self.assertEqual(pickle.loads(pickle.dumps(self.state)).hash, self.state.hash)
        self.assertEqual(copy.deepcopy(self.state).hash, self.state.hash)

    def test_runs_that_begin_there_are_equal(self):
        other = openhrp_dds.Simulation(str(SCENARIOS / "hrp2p_stand.yaml"))
        other.reset(openhrp_dds.read_state(self.path, other.robot))
        self.simulation.reset(self.state)
        self.simulation.step(500)
        other.step(500)
        self.assertEqual(self.simulation.state_hash, other.state_hash)

    def test_another_robot_and_another_file_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            arm = openhrp_dds.Simulation(write_arm(folder), controller=None)
            with self.assertRaisesRegex(ValueError, "of another robot"):
                openhrp_dds.read_state(self.path, arm.robot)
            with self.assertRaisesRegex(ValueError, "must have shape"):
                openhrp_dds.write_state(self.path, self.state, arm.robot)
        pathlib.Path(self.path).write_bytes(pathlib.Path(self.path).read_bytes()[:200])
        with self.assertRaisesRegex(ValueError, "no state of a robot"):
            openhrp_dds.read_state(self.path, self.simulation.robot)
        with self.assertRaises(FileNotFoundError):
            openhrp_dds.read_state(self.path + "x", self.simulation.robot)


class Forces(unittest.TestCase):
    def setUp(self):
        self.simulation = openhrp_dds.Simulation(str(SCENARIOS / "hrp2p_stand.yaml"))
        self.simulation.step(2000)

    def test_a_standing_robot_is_carried_by_what_touches_it(self):
        forces = self.simulation.contact_forces
        carried = sum(pair["total"][5] for pair in forces if pair["body_b"] == "ground")
        weight = self.simulation.robot.mass * 9.81
        # The robot has stood for two seconds: what still sways is below a thousandth of its weight.
        self.assertAlmostEqual(carried / weight, 1.0, delta=1e-3)
        self.assertAlmostEqual(self.simulation.foot_forces.sum(), carried, delta=1e-9 * weight)

    def test_causes_add_up_to_the_total_to_the_bit(self):
        for pair in self.simulation.contact_forces:
            np.testing.assert_array_equal(pair["spring"] + pair["damper"] + pair["friction"], pair["total"])
            for point in pair["points"]:
                np.testing.assert_array_equal(point["spring"] + point["damper"] + point["friction"], point["total"])

    def test_soles_touch_the_ground_from_above(self):
        contacts = self.simulation.contacts
        self.assertEqual({pair["body_b"] for pair in contacts}, {"ground"})
        for pair in contacts:
            self.assertTrue(pair["points"])
            for point in pair["points"]:
                np.testing.assert_allclose(point["normal"], [0, 0, 1])

    def test_observations_have_the_sensors_by_name(self):
        observation = self.simulation.observation
        self.assertEqual(set(observation.imus), {"chest"})
        self.assertEqual(set(observation.wrenches), {"left_foot", "right_foot"})
        self.assertIsNone(observation.base_pose)


class Threads(unittest.TestCase):
    def test_another_thread_counts_while_steps_are_made(self):
        simulation = openhrp_dds.Simulation(DEFAULT)
        worker = threading.Thread(target=lambda: simulation.step(20000))
        counted = 0
        worker.start()
        while worker.is_alive():
            counted += 1
            threading.Event().wait(0.0001)
        worker.join()
        # With the interpreter's lock held, this thread would have had its first turn after the last step.
        self.assertGreater(counted, 10)
        self.assertEqual(simulation.step_number, 20000)

    def test_two_simulations_step_side_by_side_with_the_bits_of_one(self):
        runs = [openhrp_dds.Simulation(DEFAULT) for _ in range(3)]
        threads = [threading.Thread(target=run.step, args=(1500,)) for run in runs[:2]]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        runs[2].step(1500)
        self.assertEqual({run.state_hash for run in runs[:2]}, {runs[2].state_hash})

    def test_a_simulation_that_steps_refuses_a_second_thread(self):
        class Asks(openhrp_dds.Controller):
            def step(self, observation):
                simulation.state

        with tempfile.TemporaryDirectory() as folder:
            simulation = openhrp_dds.Simulation(write_arm(folder), controller=Asks())
            with self.assertRaisesRegex(openhrp_dds.SimulationError, "stepping in another thread, or asks itself"):
                simulation.step()


class Arguments(unittest.TestCase):
    def test_a_scenario_that_is_not_there_is_an_input_error(self):
        with self.assertRaisesRegex(openhrp_dds.InputError, "nowhere.yaml"):
            openhrp_dds.Simulation("nowhere.yaml")

    def test_numbers_of_steps_must_make_sense(self):
        simulation = openhrp_dds.Simulation(DEFAULT)
        with self.assertRaisesRegex(ValueError, "steps must not be negative, not -1"):
            simulation.step(-1)
        with self.assertRaisesRegex(ValueError, "every must be at least 1, not 0"):
            simulation.run(10, every=0)
        with self.assertRaises(TypeError):
            simulation.step(1.5)

    def test_commands_are_for_simulations_without_a_controller(self):
        with self.assertRaisesRegex(openhrp_dds.SimulationError, "controller=None"):
            openhrp_dds.Simulation(DEFAULT).set_command(openhrp_dds.Command())
        with self.assertRaisesRegex(ValueError, "controller must be 'scenario', None or a Controller, not 'walk'"):
            openhrp_dds.Simulation(DEFAULT, controller="walk")

    def test_efforts_alone_need_a_drive_that_takes_them(self):
        simulation = openhrp_dds.Simulation(DEFAULT, controller=None)
        with self.assertRaisesRegex(ValueError, "`drive: servo`.*Command"):
            simulation.set_command(np.zeros(simulation.robot.num_joints))

    def test_a_record_has_its_shapes(self):
        simulation = openhrp_dds.Simulation(DEFAULT)
        n = simulation.robot.num_joints
        record = simulation.run(100, every=10)
        shapes = {name: getattr(record, name).shape for name in ("time", "q", "qd", "efforts", "base_position", "base_orientation",
                                                               "base_velocity", "foot_forces")}
        self.assertEqual(shapes, {"time": (10,), "q": (10, n), "qd": (10, n), "efforts": (10, n), "base_position": (10, 3),
                                  "base_orientation": (10, 4), "base_velocity": (10, 6), "foot_forces": (10, 2)})
        np.testing.assert_allclose(record.time, np.arange(1, 11) * 0.01, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
