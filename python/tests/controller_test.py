# SPDX-License-Identifier: BSD-3-Clause
"""A controller in Python: the same bits as a process of the server set and within this process; what goes wrong is said."""
import os
import pathlib
import sys
import tempfile
import unittest

import numpy as np

import faulty
import openhrp_dds
from places import SCENARIOS, simulate, write_arm
from swing import Swing

HERE = pathlib.Path(__file__).resolve().parent


def command_of(name):
    return f"{sys.executable} '{HERE / name}'"


class SameClass(unittest.TestCase):
    def check_vendor(self, vendor):
        with tempfile.TemporaryDirectory() as folder:
            scenario, log = write_arm(folder), pathlib.Path(folder) / "run.mcap"
            run = simulate(scenario, "--dds", vendor, "--controller", command_of("swing.py"), log=log)
            self.assertEqual(run.returncode, 0, run.stderr)
            states = openhrp_dds.read_log(str(log)).states()
            simulation = openhrp_dds.Simulation(scenario, controller=Swing())
        record = simulation.run(500)
        np.testing.assert_array_equal(record.q, states["q"][1:])
        self.assertEqual(simulation.state_hash, int(states["hash"][-1]))
        self.assertGreater(np.abs(record.q).max(), 0.05)  # it did something

    def test_over_cyclone_it_has_the_bits_of_this_process(self):
        self.check_vendor("cyclone")

    def test_over_fast_dds_it_has_the_bits_of_this_process(self):
        self.check_vendor("fast")

    def test_a_controller_that_holds_has_the_bits_of_the_scenarios_own(self):
        class Hold(openhrp_dds.Controller):
            def step(self, observation):
                return openhrp_dds.Command(q=self.robot.initial_q)

        scenario = str(SCENARIOS / "hrp2p_stand.yaml")
        ours, mine = openhrp_dds.Simulation(scenario), openhrp_dds.Simulation(scenario, controller=Hold())
        ours.step(400)
        mine.step(400)
        self.assertEqual(ours.state_hash, mine.state_hash)

    def test_its_memory_is_saved_and_restored(self):
        with tempfile.TemporaryDirectory() as folder:
            controller = Swing()
            simulation = openhrp_dds.Simulation(write_arm(folder), controller=controller)
            simulation.step(150)
            saved = simulation.save()
            for _ in range(2):
                simulation.step(150)
                end, memory = simulation.state_hash, controller.error.copy()
                simulation.restore(saved)
                self.assertFalse(np.array_equal(controller.error, memory))
                simulation.step(150)
                self.assertEqual(simulation.state_hash, end)
                np.testing.assert_array_equal(controller.error, memory)
                simulation.restore(saved)

    def test_observations_can_be_kept(self):
        class Keeps(Swing):
            kept = []

            def step(self, observation):
                self.kept.append(observation.q)
                return super().step(observation)

        with tempfile.TemporaryDirectory() as folder:
            simulation = openhrp_dds.Simulation(write_arm(folder), controller=Keeps())
            record = simulation.run(30)
        np.testing.assert_array_equal(np.array(Keeps.kept[1:]), record.q[:29])


class WhatGoesWrong(unittest.TestCase):
    def test_in_this_process_it_is_an_error_with_the_controllers_name(self):
        with tempfile.TemporaryDirectory() as folder:
            scenario = write_arm(folder)
            for name, words in faulty.WORDS.items():
                with self.subTest(name), self.assertRaisesRegex(openhrp_dds.SimulationError, words):
                    openhrp_dds.Simulation(scenario, controller=getattr(faulty, name)()).step(100)

    def test_the_exception_of_python_is_the_cause(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(openhrp_dds.SimulationError) as raised:
                openhrp_dds.Simulation(write_arm(folder), controller=faulty.Raises()).step(100)
        self.assertIsInstance(raised.exception.__cause__, KeyError)

    def test_in_the_server_set_the_run_ends_with_these_words(self):
        with tempfile.TemporaryDirectory() as folder:
            scenario, log = write_arm(folder), pathlib.Path(folder) / "run.mcap"
            for name, words in faulty.WORDS.items():
                os.environ["FAULTY"] = name
                with self.subTest(name):
                    run = simulate(scenario, "--controller", command_of("faulty.py"), log=log)
                    self.assertEqual(run.returncode, 1, run.stderr)
                    self.assertRegex(run.stderr, words)

    def test_a_script_that_cannot_be_run_ends_the_run(self):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "run.mcap"
            run = simulate(write_arm(folder), "--controller", command_of("nowhere.py"), log=log)
            self.assertNotEqual(run.returncode, 0)
            self.assertRegex(run.stderr, "controller")

    def test_what_is_no_controller_is_a_type_error(self):
        with self.assertRaisesRegex(TypeError, "controller must be a Controller with step"):
            openhrp_dds.run_controller(object())


if __name__ == "__main__":
    unittest.main()
