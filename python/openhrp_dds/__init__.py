# SPDX-License-Identifier: BSD-3-Clause
"""Simulate, control and diagnose robots with openhrp-dds.

    import openhrp_dds
    run = openhrp_dds.Simulation("models/scenarios/default.yaml")
    record = run.run(steps=2000, every=10)      # numpy arrays: record.q, record.base_position, ...

docs/tutorials/python.md is the tutorial. Conventions: world z up; quaternions (w, x, y, z); spatial vectors have the
angular part first; SI units.
"""
from openhrp_dds._core import (Command, ControlledRobot, ImuSample, InputError, Observation, Record, Robot, SavedRun,
                               Simulation, SimulationError, State, load_robot)
from openhrp_dds.controller import Controller, run_controller
from openhrp_dds.diagnosis import DiagnosisReport, Finding, FootReport, ProgramError, diagnose, identify_foot
from openhrp_dds.logs import Log, read_log
from openhrp_dds.recordings import Recording, write_experiment, write_recording
from openhrp_dds.states import read_state, write_state

__all__ = ["Command", "ControlledRobot", "Controller", "DiagnosisReport", "Finding", "FootReport", "ImuSample", "InputError",
           "Log", "Observation", "ProgramError", "Record", "Recording", "Robot", "SavedRun", "Simulation", "SimulationError",
           "State", "diagnose", "identify_foot", "load_robot", "read_log", "read_state", "run_controller",
           "write_experiment", "write_recording", "write_state"]
