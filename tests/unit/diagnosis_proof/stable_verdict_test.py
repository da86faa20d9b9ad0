# SPDX-License-Identifier: BSD-3-Clause
"""The verdict on an arm of two joints stays when the recordings change in what must not matter: the noise's seed, their
length, their order, the joints' names, the clock's origin. Run as: stable_verdict_test.py [CLASS] BIN_DIR SOURCE_DIR"""
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop() if len(sys.argv) > 2 else ".")
BIN = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else "build/bin")
sys.path.insert(0, str(SOURCE / "scripts" / "diagnosis"))
import stability  # noqa: E402

LINK = """<link name="%s"><inertial><origin xyz="0 0 -0.15"/><mass value="1.5"/>
<inertia ixx="0.012" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.002"/></inertial></link>
<joint name="%s" type="revolute"><parent link="%s"/><child link="%s"/><origin xyz="0 0 %g"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="80" velocity="20"/></joint>
"""
URDF = ('<robot name="arm"><link name="base"/>' + LINK % ("upper", "shoulder", "base", "upper", 0) +
        LINK % ("lower", "elbow", "upper", "lower", -0.3) + "</robot>")
HEAD = """robot: robot.urdf
base: fixed
servo:
  joints:
    shoulder: {kp: 300, kd: 12, effort_limit: 60}
    elbow: {kp: 120, kd: 4, effort_limit: 40}
"""
NOISE = "sensors: {encoders: {position_noise: 2.0e-5, velocity_noise: 2.0e-3, effort_noise: 0.02}}\n"
RUNS = (("train_1", 0.3), ("train_2", 2.9), ("validate_1", 1.9))


def call(*words):
    run = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=120)
    if run.returncode:
        raise AssertionError(f"{words}: status {run.returncode}\n{run.stdout}{run.stderr}")


def write_motion(path, phase, seconds):
    rows = ["time,shoulder,elbow"]
    for k in range(int(seconds * 100) + 1):
        t = k / 100
        fade = min(1.0, t) ** 3 * (10 - 15 * min(1.0, t) + 6 * min(1.0, t) ** 2)
        rows.append("%.2f,%.9f,%.9f" % (t, fade * (0.5 * math.sin(4 * t + phase) + 0.2 * math.sin(9 * t)),
                                        fade * (0.6 * math.sin(5 * t + 2 * phase) + 0.2 * math.sin(11 * t + phase))))
    path.write_text("\n".join(rows) + "\n")


def make_case(folder, laws, noise, seconds=2.0):
    """Recordings of our own simulator with `laws` in it, and an experiment that knows nothing of them. Steps of 0.1 ms:
    the simulator's are of first order, and from 0.5 ms on that shows above the noise."""
    made = folder.parent / (folder.name + "_made")
    for path in (folder, made):
        path.mkdir()
        (path / "robot.urdf").write_text(URDF)
    entries = ""
    for name, phase in RUNS:
        write_motion(made / "motion.csv", phase, seconds)
        (made / "run.yaml").write_text(HEAD + laws + noise + "controller: {motion: motion.csv}\ninterpolation: hermite\n"
                                       "steps: {time_step: 0.0001, control_period: 0.005, duration: %g}\n" % seconds)
        call(BIN / "hrp-simulate", made / "run.yaml", "--in-process", "--no-plot", "--quiet", "--force", "--log", made / "log.mcap")
        call(BIN / "hrp-log", "csv", made / "log.mcap", "--out", folder / (name + ".csv"))
        entries += "  - {file: %s.csv, role: %s}\n" % (name, name.split("_")[0])
    (folder / "experiment.yaml").write_text(HEAD + "recordings:\n" + entries)


class Asked(unittest.TestCase):
    def stays(self, laws, expected):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            make_case(folder / "case", laws, NOISE)
            make_case(folder / "clean", laws, "")
            answers = stability.examine(BIN / "hrp-diagnose", folder / "case", folder / "clean", folder, 7, 1)
        self.assertEqual(set(answers), {"as it is"} | set(stability.VARIANTS))
        for name, answer in answers.items():
            self.assertEqual(answer, expected, name)


class Verdicts(Asked):
    def test_viscous_friction_in_the_elbow_stays_viscous_friction_in_the_elbow(self):
        self.stays("joint_laws: {elbow: {viscous_friction: {coefficient: 0.4}}}\n", ("explained", (("viscous_friction", "elbow"),)))

    def test_nothing_hidden_stays_nothing(self):
        self.stays("", ("no_mismatch", ()))


class NightlyVerdicts(Asked):
    def test_dry_friction_in_the_shoulder_stays_dry_friction_in_the_shoulder(self):
        self.stays("joint_laws: {shoulder: {coulomb_friction: {level: 1.2}}}\n", ("explained", (("coulomb_friction", "shoulder"),)))


if __name__ == "__main__":
    for program in ("hrp-diagnose", "hrp-simulate", "hrp-log"):
        if not (BIN / program).exists():
            sys.exit(f"{BIN}/{program} is not built: nothing to test")
    unittest.main()
