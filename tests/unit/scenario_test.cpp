// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/scenario.h"

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/robot/experiment_keys.h"
#include "common/robot/yaml_sections.h"
#include "tests/catch_complaint.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

const char kGood[] = R"(robot: robot.urdf
base: floating
ground: {type: plane, height: 0.01, friction: 0.7, pitch: 0.05}
feet: [l_foot, r_foot]
servo:
  default: {kp: 100, kd: 1, effort_limit: .inf}
  joints:
    knee: {kp: 200}
initial:
  rpy: [0, 0.1, 0]
  joints: {knee: 0.3}
sensors:
  imu:
    chest: {link: torso, xyz: [0, 0, 0.2], gyro: {noise: 0.01}}
  wrench:
    left: {link: l_foot}
  base_pose: true
steps: {time_step: 0.0005, control_period: 0.004, duration: 2}
foot_bush:
  default: {kz: 3e5, k_pitch: 450, k_roll: 320, c_roll: 20}
  l_foot: {k_pitch: 480}
joint_laws:
  knee:
    coulomb_friction: {level: 3}
obstacles:
  box: {shape: box, size: [1, 1, 0.2], position: [1, 0, 0.1]}
  ball: {shape: sphere, radius: 0.3}
controller: {motion: motions/squat.csv, on_fault: hold}
recordings:
  - {file: a.csv, role: train}
noise: {position: 1e-5}
seed: 7
)";

// What parse_scenario() says about `text`, empty when it accepts it.
std::string find_complaint(const std::string& text) {
  return catch_complaint([&] { parse_scenario(text, "dir/test.yaml"); });
}

TEST(Scenario, ReadsEveryKindOfKey) {
  const Scenario s = parse_scenario(kGood, "/dir/test.yaml");
  EXPECT_EQ(s.robot, "/dir/robot.urdf");
  EXPECT_TRUE(s.floating_base);
  EXPECT_DOUBLE_EQ(s.ground.pitch, 0.05);
  EXPECT_EQ(s.feet.size(), 2u);
  EXPECT_DOUBLE_EQ(s.servo_joints.at("knee").kp, 200.0);
  EXPECT_DOUBLE_EQ(s.servo_joints.at("knee").kd, 1.0) << "left out: the default's";
  EXPECT_EQ(s.control_period, 8);
  EXPECT_DOUBLE_EQ(s.foot_bush.at("r_foot").k_roll, 320.0);
  EXPECT_DOUBLE_EQ(s.foot_bush.at("l_foot").k_pitch, 480.0);
  EXPECT_DOUBLE_EQ(s.foot_bush.at("l_foot").k_roll, 320.0);
  EXPECT_EQ(s.joint_laws.at("knee").at(0).effect, "coulomb_friction");
  EXPECT_EQ(s.obstacles.at(1).name, "ball");
  EXPECT_EQ(s.controller.type, "motion");
  EXPECT_EQ(s.controller.motion, "/dir/motions/squat.csv");
  EXPECT_TRUE(s.sensors.imus.at(0).gyro.noise.isApprox(Vector3d::Constant(0.01)));
  EXPECT_FALSE(s.initial_height_given);
  EXPECT_EQ(s.seed, 7u);
}

TEST(Scenario, ControlPeriodIsFiveMillisecondsByDefault) {
  EXPECT_EQ(parse_scenario("robot: a.urdf", "x.yaml").control_period, 5);
}

struct BadScenario {
  const char* text;
  const char* expected;
};
const BadScenario kBadScenarios[] = {
    {"", "robot: is missing"},
    {"[1, 2]", "expected a mapping"},
    {"robot: a.urdf\nfeets: [a]", "dir/test.yaml:2:1: error: feets: unknown key; did you mean 'feet'?"},
    {"robot: a.urdf\nbase: flying", "dir/test.yaml:2:7: error: base: is 'flying', expected one of fixed, floating"},
    {"robot: a.urdf\nservo:\n  default: {kp: -3}",
     "3:17: error: servo.default.kp: is '-3', expected a finite number >= 0"},
    {"robot: a.urdf\nservo: {default: {kp: .nan}}", "servo.default.kp: is '.nan'"},
    {"robot: a.urdf\nservo: {default: {kp: ten}}", "is 'ten', expected a finite number >= 0 [N m/rad or N/m]"},
    {"robot: a.urdf\ngravity: [0, 0]", "gravity: is a list of 2, expected a list of 3 numbers"},
    {"robot: a.urdf\ngravity: [0, 0, down]", "gravity[2]: is 'down'"},
    {"robot: a.urdf\nfeet: left", "feet: is 'left', expected a list of names"},
    {"robot: a.urdf\nfeet: [a, a]", "feet[1]: is 'a', which stands in the list already"},
    {"robot: a.urdf\nrobot: b.urdf", "robot: is given twice"},
    {"robot: [", "not valid YAML"},
    {"robot: a.urdf\nsteps: {control_period: 0.0033}",
     "expected a multiple of steps.time_step 0.001 s, such as 0.003 or 0.004"},
    {"robot: a.urdf\nsteps: {time_step: 0.002}",
     "is 0.005 s (the default), expected a multiple of steps.time_step 0.002"},
    {"robot: a.urdf\nsteps: {time_step: 0}", "steps.time_step: is '0', expected a finite number > 0"},
    {"robot: a.urdf\nseed: -1", "seed: is '-1', expected a whole number"},
    {"robot: a.urdf\njoint_laws: {knee: {coulomb: {level: 1}}}", "joint_laws.knee.coulomb: unknown key"},
    {"robot: a.urdf\njoint_laws: {knee: {backlash: {}}}", "joint_laws.knee.backlash.gap: is missing"},
    {"robot: a.urdf\ndrive: voltage", "drive: is voltage, but 'servo.joints' names no joint"},
    {"robot: a.urdf\ndrive: voltage\nservo: {joints: {e: {kp: 5, supply: 12}}}",
     "servo.joints.e.resistance: is missing"},
    {"robot: a.urdf\nself_collision: perhaps", "expected true or false"},
    {"robot: a.urdf\nsensors: {imu: {chest: {xyz: [0, 0, 0]}}}", "sensors.imu.chest.link: is missing"},
    {"robot: a.urdf\nobstacles: {b: {shape: box}}", "obstacles.b.size: is missing"},
    {"robot: a.urdf\nobstacles: {b: {shape: mesh}}", "obstacles.b.file: is missing"},
    {"robot: a.urdf\nobstacles: {b: {shape: height_field, file: a.csv}}", "obstacles.b.spacing: is missing"},
    {"robot: a.urdf\nobstacles: {b: {shape: height_field, file: a.csv, spacing: 0}}", "obstacles.b.spacing: is '0'"},
    {"robot: a.urdf\nobstacles: {b: {shape: mesh, file: a.obj, spacing: 1}}", "obstacles.b.spacing: unknown key"},
    {"robot: a.urdf\nobstacles: {b: {shape: sphere, radius: 1, mass: 2}}",
     "2:49: error: obstacles.b.mass: obstacles are fixed"},
    {"robot: a.urdf\nrobots: [b.urdf, c.urdf]", "robots: is a list of 2, expected a mapping"},
    {"robot: a.urdf\nobjects: {ball: {shape: sphere, radius: 1, position: [0, 0, 1]}}",
     "objects.ball.mass: is missing"},
    {"robot: a.urdf\ncontact: {model: impulse}\nobjects: {ball: {shape: sphere, radius: 1, mass: 1, position: [0, 0, "
     "1]}}",
     "objects: do not go with"},
    {"robot: a.urdf\nground: {type: mesh}",
     "ground.type: is 'mesh', expected plane or none; give an obstacle of shape mesh"},
    {"robot: a.urdf\nsensors:\n  camera:\n    eye: {fov: 60}",
     "4:16: error: sensors.camera.eye.fov: is 60 rad, expected 0.01 to 3 rad"},
    {"robot: a.urdf\nsensors: {camera: {eye: {width: 0}}}", "sensors.camera.eye.width: is 0, expected 1 to 4096"},
    {"robot: a.urdf\nsensors: {camera: {eye: {heigth: 9}}}",
     "sensors.camera.eye.heigth: unknown key; did you mean 'height'?"},
    {"robot: a.urdf\nsensors: {camera: {eye: {near: 2, far: 1}}}",
     "sensors.camera.eye.far: is 1 m, expected more than near, 2 m"},
    {"robot: a.urdf\nsensors: {camera: {eye: {color: false, depth: false}}}",
     "sensors.camera.eye: takes neither color nor depth"},
    {"robot: a.urdf\nsensors: {camera: {my-eye: {}}}",
     "sensors.camera.my-eye: is the name of topics, expected letters, digits and _"},
    {"robot: a.urdf\nsensors: {camera: {eye: {rate: 500}}}",
     "2:32: error: sensors.camera.eye.rate: is 500 1/s, expected at most 200 1/s: once in a control period"},
    {"robot: a.urdf\nsensors: {depth: {eye: {link: head}}}",
     "sensors.depth: a depth camera is a 'camera' with 'depth: true'"},
    {"robot: a.urdf\nsensors: {lidar: {scan: {range: [5, 1]}}}",
     "sensors.lidar.scan.range: falls, expected the smaller number first"},
    {"robot: a.urdf\nsensors: {lidar: {scan: {range: 5}}}",
     "sensors.lidar.scan.range: is '5', expected a list of 2 numbers [m]"},
    {"robot: a.urdf\nsensors: {lidar: {scan: {azimuth: [-180, 180]}}}",
     "sensors.lidar.scan.azimuth: is more than a turn; are these degrees?"},
    {"robot: a.urdf\nsensors: {lidar: {scan: {rows: 1000, columns: 2000}}}",
     "sensors.lidar.scan.rows: is 1000, expected 1 to 500"},
    {"robot: a.urdf\nobstacles: {b: {shape: sphere, radius: 1, color: [2, 0, 0]}}",
     "obstacles.b.color[0]: is '2', expected a number from 0 to 1"},
    {"robot: a.urdf\ncontroller: {type: motion}", "controller.motion: is missing"},
    {"robot: a.urdf\nmax_sole_points: 2", "max_sole_points: is 2, expected 3 to 16"},
    {"robot: a.urdf\nfeet: [a]\nfoot_bush: {b: {kz: 1}}", "'b' is not in the list of feet"},
    {"robot: a.urdf\nfeet: &a [*a]", "expected a word"},
    {"robot: a.urdf\nhands: {h: {link: b}}", "hands.h.stiffness: is missing"},
    {"robot: a.urdf\nhands:\n  h: {link: b, stiffness: -1}", "3:27: error: hands.h.stiffness: is '-1'"},
    {"robot: a.urdf\nhands: {h: {link: b, stiffness: 1, stifness: 2}}", "did you mean 'stiffness'?"},
    {"robot: a.urdf\nservo: {default: {kP: 2}}", "servo.default.kP: unknown key; did you mean 'kp'?"},
    {"robot: a.urdf\nservo: {default: {KD: 2}}", "did you mean 'kd'?"},
    {"robot: a.urdf\nsteps: {control_period: 5}",
     "dir/test.yaml:2:25: error: steps.control_period: is 5 s, expected at most 1 s"},
    {"robot: a.urdf\nhands: {h: {link: b, stiffness: 1, path: [{time: 1, xyz: [0, 0, 0]}, {time: 1, xyz: [0, 0, 1]}]}}",
     "hands.h.path[1].time: is not later than the point before"},
    {"robot: a.urdf\nhands: {h: {link: b, stiffness: 1, waves: [{amplitude: [0, 0, 1]}]}}",
     "hands.h.waves[0].frequency: is missing"},
};

TEST(Scenario, BadInputIsNamedWithLineKeyValueAndExpectation) {
  for (const BadScenario& c : kBadScenarios)
    EXPECT_THAT(find_complaint(c.text), HasSubstr(c.expected)) << "text:\n" << c.text;
}

TEST(Scenario, AllErrorsAreSaidAtOnce) {
  try {
    parse_scenario("base: flying\nfeets: 1\nseed: x\n", "x.yaml");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.diagnostics().size(), 4u) << error.what();
  }
}

TEST(Scenario, MissingFilesAreNamedWithTheirLine) {
  const std::string path = ::testing::TempDir() + "/scenario_test_missing.yaml";
  std::ofstream(path) << "base: fixed\nrobot: nowhere.urdf\n";
  try {
    load_scenario(path);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(":2:8: error: robot: there is no file"));
  }
  EXPECT_THROW(load_scenario("/no/such/scenario.yaml"), InputError);
}

// What parse_experiment_keys() says about an experiment of one recording, empty when it accepts it.
std::string find_complaint_of_keys(const std::string& file, const std::string& more = "") {
  return catch_complaint([&] {
    parse_experiment_keys("recordings:\n  - {file: " + file + "}\n" + more, ::testing::TempDir() + "/experiment.yaml");
  });
}

TEST(ExperimentKeys, ARecordingThatTheSystemCannotLookForIsNotThere) {
  const std::string circle = ::testing::TempDir() + "/scenario_test_circle";
  std::filesystem::remove(circle);
  std::filesystem::create_symlink(circle, circle);
  for (const std::string& name : {std::string("nowhere.csv"), std::string(300, 'a'), circle}) {
    EXPECT_THAT(find_complaint_of_keys(name),
                HasSubstr(":2:12: error: recordings[0].file: there is no file or bag folder"));
  }
  EXPECT_EQ(find_complaint_of_keys("."), "");
}

TEST(ExperimentKeys, NoiseIsANumberWhoseSquareIsOne) {
  EXPECT_EQ(find_complaint_of_keys(".", "noise: {position: 1e-15, velocity: 1e12}\n"), "");
  for (const std::string noise : {"0", "-1e-5", ".inf", ".nan", "1e-320", "1e-200", "1e200", "much", "[1]"}) {
    EXPECT_THAT(find_complaint_of_keys(".", "noise: {position: " + noise + "}\n"),
                HasSubstr(":3:19: error: noise.position: expected a standard deviation"));
  }
}

TEST(ExperimentKeys, NoiseIsOfAQuantityOrOfASensor) {
  EXPECT_EQ(find_complaint_of_keys(".", "noise: {effort: 1, /imu/waist: 1e-3, /joint_states/knee/position: 1e-4}\n"),
            "");
  EXPECT_THAT(find_complaint_of_keys(".", "noise: {postion: 1e-3}\n"),
              HasSubstr(":3:9: error: noise.postion: expected position, velocity, effort, or"));
}

TEST(ExperimentKeys, ARateIsMoreThanZero) {
  EXPECT_EQ(find_complaint_of_keys(".", "sample_rate: 250\n"), "");
  for (const std::string rate : {"0", "-5", ".nan", ".inf", "1e300", "often", "[1]"}) {
    EXPECT_THAT(find_complaint_of_keys(".", "sample_rate: " + rate + "\n"),
                HasSubstr(":3:14: error: sample_rate: expected a rate of more than 0 Hz"));
  }
}

TEST(Scenario, TextThatIsNotUtf8IsNamedWithItsPlace) {
  const std::string text = "name: x\nnotes: caf";
  EXPECT_EQ(parse_scenario(std::string(kGood) + "notes: caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x99\x82\n", "s.yaml").path,
            "s.yaml");
  for (const std::string bad :
       {"\xe9", "\xc3", "\xff", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\x80"}) {
    try {
      parse_scenario(text + bad + "\n", "s.yaml");
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("s.yaml:2:11: error: byte "));
    }
  }
}

TEST(Scenario, DiagnosticOfALaterCheckPointsAtTheKey) {
  const Scenario s = parse_scenario(kGood, "/dir/test.yaml");
  EXPECT_EQ(s.make_diagnostic("servo.joints.knee", "x").line, 8);
  EXPECT_EQ(s.make_diagnostic("feet[1]", "x").line, 4);
}

TEST(Scenario, DamagedTextIsRefusedOrReadButNeverCrashes) {
  std::mt19937 random(20240501);
  const std::string good = kGood;
  const std::string alphabet = "{}[]:,-#&*!|>'\"%@`\n\t .0123456789aeinxyz\x01\xff";
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string text = good;
    if (i % 4 == 0) text.resize(random() % text.size());
    const int edits = 1 + static_cast<int>(random() % 4);
    for (int k = 0; k < edits && !text.empty(); ++k)
      text[random() % text.size()] = alphabet[random() % alphabet.size()];
    if (!find_complaint(text).empty()) ++refused;
  }
  EXPECT_GT(refused, 1000) << "the mutations should break most texts";
}

TEST(Scenario, ExperimentFoldersAreScenarios) {
  const std::filesystem::path shared = std::filesystem::path(source_dir()) / "../shared";
  int found = 0;
  for (const char* folder : {"recordings", "cases/open"}) {
    if (!std::filesystem::is_directory(shared / folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(shared / folder)) {
      const auto file = entry.path() / "experiment.yaml";
      if (!std::filesystem::exists(file)) continue;
      EXPECT_NO_THROW(load_scenario(file.string())) << file;
      ++found;
    }
  }
  if (found == 0) GTEST_SKIP() << "NOT TESTED: no experiment folders beside the repository (../shared)";
}

TEST(YamlSections, KeysHaveTheirLinesInAnyLayout) {
  const auto sections = split_sections(
      "%YAML 1.2\n---\n# an arm\nrobot: arm.urdf  # ours\nrecordings: [\n  {file: a.csv}\n]\neffects:\n- {a: "
      "1}\n...\n");
  ASSERT_EQ(sections.size(), 4u);
  EXPECT_EQ(sections[0].text, "# an arm\n");
  EXPECT_EQ(sections[1].key, "robot");
  EXPECT_EQ(sections[2].text, "recordings: [\n  {file: a.csv}\n]\n");
  EXPECT_EQ(sections[3].text, "effects:\n- {a: 1}\n");
}

TEST(YamlSections, ItemsOfAnyLayoutTakeFurtherOnes) {
  const std::string usual = "  - {effect: payload, where: {link: hand}}  # a tool\n";
  const auto list = [](const std::string& text) { return list_items(split_sections(text).back(), text); };
  EXPECT_EQ(list("effects:  # found\n" + usual), usual);
  for (const char* text : {"effects: [{a: 1, b: {c: x y}}, {a: 2}]\n", "effects:\n- {a: 1, b: {c: x y}}\n- a: 2\n",
                           "effects: [\n  {a: 1, b: {c: x y}},\n  {a: 2}\n]\n"})
    EXPECT_EQ(list(text), "  - {a: 1, b: {c: x y}}\n  - {a: 2}\n") << text;
  EXPECT_EQ(list("effects: []\n"), "");
  EXPECT_EQ(list("notes: &own [{a: 1}]\neffects: *own\n"), "  - {a: 1}\n") << "an anchor of another section";
}

}  // namespace
}  // namespace hrp
