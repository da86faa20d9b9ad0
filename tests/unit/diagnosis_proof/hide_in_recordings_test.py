# SPDX-License-Identifier: BSD-3-Clause
"""The claims of the trial that adds known effects to recordings. Run as: hide_in_recordings_test.py SOURCE_DIR"""
import json
import pathlib
import random
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else ".").resolve()
sys.path.insert(0, str(SOURCE / "diagnosis" / "generator"))
import hide_in_recordings as hide  # noqa: E402
import numpy  # noqa: E402
import score_hidden  # noqa: E402

ARM = SOURCE / "models" / "experiments" / "arm" / "experiment.yaml"


class HideInRecordings(unittest.TestCase):
    def setUp(self):
        self.before, self.after = hide.Machine(ARM), hide.Machine(ARM)
        self.joint = self.after.joints[0]

    def change(self, group, quantity):
        pairs = zip(self.before.logs.values(), self.after.logs.values())
        return numpy.concatenate([b.get(group, self.joint, quantity) - a.get(group, self.joint, quantity) for a, b in pairs])

    def test_a_spring_is_an_effort_in_proportion_to_the_position_and_moves_nothing(self):
        truth = hide.hide_law("parallel_spring")(self.after, self.joint, random.Random(1))
        q = numpy.concatenate([log.motion(self.joint)[0] for log in self.before.logs.values()])
        numpy.testing.assert_allclose(self.change("joint_states", "effort"), truth["stiffness"] * q, atol=1e-9)
        self.assertFalse(self.change("joint_states", "position").any())

    def test_a_servo_with_a_stated_gain_gets_the_torque_from_its_command(self):
        truth = hide.hide_law("constant_torque")(self.after, self.joint, random.Random(2))
        numpy.testing.assert_allclose(self.change("joint_commands", "position"), truth["torque"] / self.after.kp(self.joint), atol=1e-9)

    def test_the_torque_that_is_added_is_a_share_of_what_the_drive_gives(self):
        for effect, (name, law) in hide.LAWS.items():
            truth = hide.hide_law(effect)(hide.Machine(ARM), self.joint, random.Random(3))
            share = truth[name] * self.before.size(self.joint, law) / self.before.spread(self.joint)
            self.assertTrue(hide.SHARE[0] <= share <= hide.SHARE[1], effect)

    def test_the_rates_of_a_sine_are_its_derivatives(self):
        time = numpy.arange(0.0, 6.0, 0.01)
        _, v, a = hide.low_pass(time, numpy.sin(3.0 * time))
        inner = slice(50, -50)
        numpy.testing.assert_allclose(v[inner], 3.0 * numpy.cos(3.0 * time)[inner], atol=0.01)
        numpy.testing.assert_allclose(a[inner], -9.0 * numpy.sin(3.0 * time)[inner], atol=0.05)

    def test_every_kind_is_written_with_its_truth(self):
        with tempfile.TemporaryDirectory() as folder:
            out, argv = pathlib.Path(folder), sys.argv
            sys.argv = ["hide", str(ARM), str(out), "--number", "9", "--seed", "4"]
            try:
                hide.main()
            finally:
                sys.argv = argv
            kinds = {json.loads((case / "truth.json").read_text())["hidden"][0]["effect"] for case in out.iterdir()}
            self.assertEqual(len(kinds), 9)
            self.assertTrue(all((case / "experiment.yaml").exists() for case in out.iterdir()))


def found(effect, value, half, grade="supported", joint="a"):
    return {"effect": effect, "where": {"joint": joint}, "grade": grade, "alternatives": [],
            "parameters": {"stiffness": {"value": value, "ci95": [value - half, value + half]}}}


class ScoreHidden(unittest.TestCase):
    HIDDEN = {"effect": "parallel_spring", "joint": "a", "stiffness": 2.0}

    def test_a_value_is_judged_beside_what_was_there_before(self):
        before = {"findings": [found("parallel_spring", 1.0, 0.1)]}
        right, wrong = ({"findings": [found("parallel_spring", value, 0.2)]} for value in (3.1, 2.0))
        self.assertTrue(score_hidden.is_value_right(before, right, self.HIDDEN))
        self.assertFalse(score_hidden.is_value_right(before, wrong, self.HIDDEN))

    def test_a_claim_is_wrong_only_if_the_first_answer_does_not_know_it(self):
        before = {"findings": [found("viscous_friction", 1.0, 0.1, "ambiguous")]}
        after = {"findings": [found("viscous_friction", 1.0, 0.1), found("cogging", 1.0, 0.1), found("rotor_inertia", 1.0, 0.1)]}
        self.assertEqual(score_hidden.list_wrong(before, after, self.HIDDEN), ["rotor_inertia at a"])

    def test_an_ambiguous_finding_that_lists_it_names_it(self):
        other = found("payload", 1.0, 0.1, "ambiguous")
        other["alternatives"] = [{"effect": "parallel_spring", "where": {"joint": "a"}}]
        self.assertEqual(score_hidden.find_grade({"findings": [other]}, self.HIDDEN), "ambiguous")
        self.assertEqual(score_hidden.find_grade({"findings": []}, self.HIDDEN), "")


if __name__ == "__main__":
    unittest.main()
