# SPDX-License-Identifier: BSD-3-Clause
"""The scorer's claims: what counts as right, wrong, missed. Run as: score_cases_test.py SOURCE_DIR"""
import pathlib
import sys
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else ".")
sys.path.insert(0, str(SOURCE / "diagnosis" / "generator"))
import score_cases  # noqa: E402
import score_judge  # noqa: E402


def truth(*hidden, family="joint"):
    return {"hidden": list(hidden), "family": family}


def found(effect, parameters=None, alternatives=None, **where):
    return {"effect": effect, "where": where, "parameters": parameters or {}, "alternatives": alternatives or []}


def report(verdict, *findings, unexplained=()):
    return {"verdict": verdict, "findings": list(findings), "unexplained": list(unexplained)}


COULOMB = {"effect": "coulomb_friction", "joint": "a", "level": 2.0}
STOP = {"effect": "mechanical_stop", "joint": "a", "angle": 0.3}


def word(t, r):
    return score_judge.judge(t, r)[0]


class Scorer(unittest.TestCase):
    def test_the_right_effect_in_the_right_place_is_right(self):
        self.assertEqual(word(truth(COULOMB), report("explained", found("coulomb_friction", joint="a"))), "right")

    def test_the_right_effect_in_another_place_is_not(self):
        self.assertEqual(word(truth(COULOMB), report("explained", found("coulomb_friction", joint="b"))), "wrong place")

    def test_an_extra_finding_spoils_a_right_one(self):
        answer = report("explained", found("coulomb_friction", joint="a"), found("payload", link="x"))
        self.assertEqual(word(truth(COULOMB), answer), "extra finding")

    def test_another_effect_is_a_wrong_cause_and_none_is_a_miss(self):
        self.assertEqual(word(truth(COULOMB), report("explained", found("payload", link="a"))), "wrong cause")
        self.assertEqual(word(truth(COULOMB), report("unexplained")), "missed")
        self.assertEqual(word(truth(COULOMB), None), "no answer")

    def test_a_twin_named_as_alternative_counts_and_is_told_apart(self):
        answer = report("explained", found("stribeck_friction", joint="a", alternatives=[{"effect": "coulomb_friction"}]))
        self.assertEqual(word(truth(COULOMB), answer), "right among twins")

    def test_nothing_hidden_wants_nothing_found(self):
        self.assertEqual(word(truth(), report("no_mismatch")), "right")
        self.assertEqual(word(truth(), report("unexplained")), "false alarm")
        self.assertEqual(word(truth(), report("explained", found("payload", link="x"))), "false finding")

    def test_a_link_that_bends_counts_where_a_finding_lists_it_at_its_place(self):
        bend = {"effect": "hip_bend", "joint": "l_yaw", "stiffness": 9000.0}
        for link, expected in (("l_yaw_link", "right among twins"), ("r_yaw_link", "wrong cause")):
            listed = [{"effect": "link_bending", "where": {"link": link}}]
            answer = report("explained", found("joint_elasticity", alternatives=listed, joint="l_roll"))
            self.assertEqual(word(truth(bend), answer), expected)
        plain = report("explained", found("joint_elasticity", joint="l_roll"))
        self.assertEqual(word(truth(bend), plain), "wrong cause")
        extra = report("explained", found("joint_elasticity", alternatives=[{"effect": "link_bending", "where": {"link": "l_yaw_link"}}],
                                          joint="l_roll"), found("payload", link="x"))
        self.assertEqual(word(truth(bend), extra), "extra finding")

    def test_unknown_physics_wants_its_place_and_no_name(self):
        self.assertEqual(word(truth(STOP), report("unexplained", unexplained=[{"where": {"joint": "a"}}])), "right")
        self.assertEqual(word(truth(STOP), report("unexplained", unexplained=[{"where": {"joint": "b"}}])), "wrong place")
        self.assertEqual(word(truth(STOP), report("explained", found("parallel_spring", joint="a"))), "wrong cause")
        self.assertEqual(word(truth(STOP), report("no_mismatch")), "missed")

    def test_half_of_a_pair_is_partly_right(self):
        both = truth(COULOMB, {"effect": "payload", "link": "x", "mass": 1.0}, family="pair")
        self.assertEqual(word(both, report("partly_explained", found("coulomb_friction", joint="a"))), "partly")

    def test_a_sensor_may_be_named_as_a_whole(self):
        hidden = {"effect": "sensor_bias", "sensor": "/wrench/l/torque", "value": [1, 0, 0]}
        self.assertEqual(word(truth(hidden), report("explained", found("sensor_bias", sensor="/wrench/l"))), "right")
        self.assertEqual(word(truth(hidden), report("explained", found("sensor_bias", sensor="/wrench/left"))), "wrong place")

    def test_parameters_are_compared_with_truth_and_interval(self):
        said = found("coulomb_friction", {"level": {"value": 2.1, "ci95": [1.9, 2.3]}}, joint="a")
        (_, _, _, _, error, inside), = score_judge.compare_parameters(COULOMB, said)
        self.assertAlmostEqual(error, 0.05)
        self.assertTrue(inside)

    def test_a_phase_is_compared_on_the_circle(self):
        hidden = {"effect": "cogging", "joint": "a", "phase": 0.1}
        said = found("cogging", {"phase": {"value": 6.3, "ci95": [6.2, 6.4]}}, joint="a")
        (_, _, _, _, error, inside), = score_judge.compare_parameters(hidden, said)
        self.assertLess(error, 0.03)
        self.assertTrue(inside)

    def test_the_page_shows_a_miss(self):
        case = score_judge.Case("case-001", truth(COULOMB), report("unexplained"), {"seconds": 3, "status": 0})
        page = score_cases.make_page([case], "t", ["<note>"])
        self.assertIn("case-001: missed", page)
        self.assertIn("&lt;note&gt;", page)


if __name__ == "__main__":
    unittest.main()
