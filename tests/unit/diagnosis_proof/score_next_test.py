# SPDX-License-Identifier: BSD-3-Clause
"""The claims of the scorer of proposed motions. Run as: score_next_test.py SOURCE_DIR"""
import json
import pathlib
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else ".")
sys.path.insert(0, str(SOURCE / "diagnosis" / "generator"))
import score_next  # noqa: E402

FRICTION = {"effect": "coulomb_friction", "joint": "a", "level": 2.0}
ROTOR = {"effect": "rotor_inertia", "joint": "a", "inertia": 0.1}
CLEAN = {"hidden": [FRICTION], "family": "joint"}
DIRTY = {"hidden": [], "background": [FRICTION, ROTOR], "family": "arm_dirty",
         "influence": [dict(FRICTION, share=0.5), dict(ROTOR, share=0.4)]}


def found(effect, half, value=2.0, grade="supported"):
    return {"effect": effect, "where": {"joint": "a"}, "grade": grade,
            "parameters": {"level": {"value": value, "ci95": [value - half, value + half]}}}


def report(*findings):
    return {"verdict": "explained", "findings": list(findings)}


class ScoreNext(unittest.TestCase):
    def test_a_dirty_world_is_right_only_when_all_that_matters_is_named(self):
        self.assertTrue(score_next.is_right(DIRTY, report(found("coulomb_friction", 0.1), found("rotor_inertia", 0.1))))
        self.assertFalse(score_next.is_right(DIRTY, report(found("coulomb_friction", 0.1))))

    def test_of_a_dirty_world_the_effects_that_are_named_are_counted(self):
        case = {"truth": DIRTY, "first": report(found("coulomb_friction", 0.1)), "proposed": {}}
        self.assertEqual(score_next.count_named(case, "first"), (1, 2))
        self.assertEqual(score_next.count_named(case, "proposed"), (0, 2))
        self.assertEqual(score_next.count_named({"truth": CLEAN, "first": report()}, "first"), (0, 0))

    def test_background_is_no_wrong_name_and_its_intervals_count(self):
        self.assertEqual(score_next.count_wrong(DIRTY, report(found("coulomb_friction", 0.1))), 0)
        self.assertEqual(score_next.count_wrong(DIRTY, report(found("backlash", 0.1))), 1)
        self.assertEqual(len(score_next.list_half_widths(DIRTY, report(found("coulomb_friction", 0.1)))), 1)

    def test_a_proposed_motion_that_could_not_be_played_is_counted(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)

            def write(path, contents):
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(json.dumps(contents))

            write("first/truths/case-001.json", CLEAN)
            for kind in ("first", "proposed", "multisines"):
                write(f"{kind}/answers/case-001/run.json", {"status": 0, "seconds": 1})
            write("first/answers/case-001/report.json", report(found("viscous_friction", 0.2)))
            write("first/answers/case-001/next/next.json",
                  {"explanations": ["a", "b"], "motions": [{"file": "train_1.csv", "loads": [{"mass": 1}]}]})
            write("multisines/answers/case-001/report.json", report(found("coulomb_friction", 0.1)))
            write("multisines/cases/case-001/experiment.yaml", "")
            out, opened = score_next.summarise(root, [score_next.read_case(root, "case-001")])
            self.assertEqual(out["not_played"], ["case-001"])
            self.assertEqual((out["proposed"]["right"], out["multisines"]["right"], out["loads"]), (0, 1, 1))
            self.assertEqual(score_next.judge(opened[0]["truth"], opened[0]["proposed"]), "no answer")

    def test_an_interval_that_no_motion_halves_is_counted_apart(self):
        said = lambda least: {"motions": [{"intervals": [{"effect": "coulomb_friction@a", "parameter": "level", "least_half_width": least}]}]}
        case = lambda least: {"truth": CLEAN, "first": report(found("coulomb_friction", 0.4)),
                              "proposed": report(found("coulomb_friction", 0.1)), "next": said(least)}
        self.assertEqual(len(score_next.find_ratios(case(0.1), "proposed", wide=True)), 1)
        self.assertEqual(len(score_next.find_ratios(case(0.3), "proposed", wide=True)), 0)
        self.assertEqual(len(score_next.find_ratios(case(0.3), "proposed")), 1)

    def test_a_limit_is_passed_where_the_urdf_says_so(self):
        with tempfile.TemporaryDirectory() as folder:
            case = pathlib.Path(folder) / "multisines/cases/case-001"
            case.mkdir(parents=True)
            (case / "robot.urdf").write_text('<robot><joint name="knee"><limit lower="-0.5" upper="2"/></joint><joint name="mount"/></robot>')
            (case / "next_train_1.csv").write_text("time,/joint_states/knee/position\n0,0.1\n0.1,-0.6\n")
            (case / "next_validate_1.csv").write_text("time,/joint_states/knee/position\n0,1.9\n0.1,\n")
            passed = lambda kind: score_next.list_passed(pathlib.Path(folder), {"name": "case-001"}, kind)
            self.assertEqual(passed("multisines"), ["next_train_1.csv"])
            self.assertEqual(passed("proposed"), [])


if __name__ == "__main__":
    unittest.main()
