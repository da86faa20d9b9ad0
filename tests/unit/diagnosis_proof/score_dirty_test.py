# SPDX-License-Identifier: BSD-3-Clause
"""The claims of the scorer of dirty worlds. Run as: score_dirty_test.py SOURCE_DIR"""
import pathlib
import sys
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else ".")
sys.path.insert(0, str(SOURCE / "diagnosis" / "generator"))
import score_cases  # noqa: E402
import score_judge  # noqa: E402
import score_dirty  # noqa: E402

ROTOR = {"effect": "rotor_inertia", "joint": "a", "inertia": 0.1}
STRIBECK = {"effect": "stribeck_friction", "joint": "a", "coulomb": 2.0, "static": 3.0, "stribeck_velocity": 0.1}
GAIN = {"effect": "torque_constant_error", "joint": "a", "scale": 0.9}


def truth(*background, hidden=(), weak=()):
    listed = list(background) + list(hidden)
    influence = [dict(h, share=0.02 if h in weak else 0.4) for h in listed]
    return {"hidden": list(hidden), "background": list(background), "unlisted": [], "influence": influence,
            "family": "arm_dirty", "drive": "servo"}


def found(effect, grade="supported", parameters=None, alternatives=(), **where):
    return {"effect": effect, "where": where, "grade": grade, "parameters": parameters or {},
            "alternatives": [{"effect": a} for a in alternatives]}


def tally(t, *findings, **more):
    return score_dirty.Tally(t, {"verdict": "mostly_explained", "findings": list(findings), **more})


class DirtyScorer(unittest.TestCase):
    def test_an_effect_is_named_by_its_family_in_its_joint(self):
        self.assertEqual(len(tally(truth(STRIBECK), found("coulomb_friction", joint="a")).named), 1)
        self.assertEqual(len(tally(truth(STRIBECK), found("coulomb_friction", joint="b")).named), 0)

    def test_weak_effects_need_no_name(self):
        t = tally(truth(ROTOR, STRIBECK, weak=[ROTOR]), found("coulomb_friction", joint="a"))
        self.assertEqual((len(t.weighty), t.word()), (1, "right"))

    def test_what_no_log_shows_is_counted_apart(self):
        t = truth(ROTOR, STRIBECK)
        t["influence"][0]["over_noise"], t["influence"][1]["over_noise"] = 0.01, 20.0
        t = tally(t, found("coulomb_friction", joint="a"))
        self.assertEqual((len(t.weighty), len(t.named), len(t.seen), len(t.named_seen)), (2, 1, 1, 1))

    def test_without_efforts_and_commands_no_log_shows_what_a_drive_loses(self):
        t = truth(ROTOR, hidden=[{"effect": "ground_slope", "ground": "ground", "roll": 0.02, "pitch": 0.0}])
        t["missing"] = ["/joint_states/*/effort"]
        self.assertEqual(tally(t, found("ground_slope", ground="ground")).word(), "partly")
        t["missing"].append("/joint_commands/")
        self.assertEqual(tally(t, found("ground_slope", ground="ground")).word(), "right")

    def test_a_claim_is_judged_by_family_and_by_effect_or_alternative(self):
        t = tally(truth(STRIBECK), found("coulomb_friction", joint="a"),
                  found("load_dependent_friction", alternatives=["stribeck_friction"], joint="a"))
        self.assertEqual((len(t.true_family), len(t.true_effect)), (2, 1))

    def test_an_ambiguous_finding_claims_nothing(self):
        t = tally(truth(STRIBECK), found("parallel_spring", grade="ambiguous", joint="a"))
        self.assertEqual((len(t.claims), t.word()), (0, "missed"))

    def test_a_scaled_effort_is_a_gain_of_its_joint(self):
        scaled = {"effect": "sensor_scale", "sensor": "/joint_states/a/effort", "scale": 1.1}
        self.assertEqual(len(tally(truth(scaled), found("torque_constant_error", joint="a")).true_family), 1)

    def test_axes_that_do_not_show_are_not_compared(self):
        moved = {"effect": "com_error", "link": "hand", "offset": [0.03, 0.07, 0.0]}
        said = {"offset": {"value": [0.031, 0.0, 0.0], "ci95": [[0.02, 0.04], [0.0, 0.0], [-0.1, 0.1]], "unseen": ["y"]}}
        (row,) = tally(truth(moved), found("com_error", parameters=said, link="hand")).intervals
        self.assertTrue(row[-1])
        self.assertAlmostEqual(row[5], 1 / 30)

    def test_intervals_count_where_the_very_effect_is_there(self):
        said = {"inertia": {"value": 0.12, "ci95": [0.11, 0.13]}, "level": {"value": 1.0, "ci95": [0.5, 1.5]}}
        (row,) = tally(truth(ROTOR), found("rotor_inertia", parameters=said, joint="a")).intervals
        self.assertFalse(row[-1])
        self.assertAlmostEqual(row[5], 0.2)

    def test_errors_are_compared_over_the_noise_of_each_signal(self):
        t = truth(ROTOR)
        t["listed_error"] = {"/q": {"error": 0.002, "noise": 0.001, "spread": 0.1}}
        self.assertAlmostEqual(tally(t, fit={"per_signal": {"/q": {"before": 1, "after": 0.03}}}).ratio, 1.5)

    def test_the_page_shows_dirty_cases_alone(self):
        case = score_judge.Case("case-001", truth(GAIN), {"findings": [found("payload", link="x")]}, {"seconds": 1})
        self.assertEqual(case.word, "extra finding")
        self.assertIn("wrong family: payload", score_cases.make_page([case], "t", []))


if __name__ == "__main__":
    unittest.main()
