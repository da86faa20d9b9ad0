// SPDX-License-Identifier: BSD-3-Clause
// The generator is the judge of the diagnosis tool, so it is checked by what it did not use to make the data: MuJoCo's
// own URDF loader and inverse dynamics, and closed forms.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>

#include "diagnosis/generator/joint_effects.h"
#include "diagnosis/generator/make_case.h"
#include "diagnosis/generator/reality.h"
#include "diagnosis/generator/robot_parts.h"

namespace hrp::cases {
namespace {

struct Csv {
  std::map<std::string, std::vector<double>> columns;
  const std::vector<double>& at(const std::string& name) const { return columns.at(name); }
};

Csv parse_csv(const std::string& text) {
  Csv out;
  std::istringstream lines(text);
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) names.push_back(cell);
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (const std::string& name : names) {
      std::getline(cells, cell, ',');
      out.columns[name].push_back(std::stod(cell));
    }
  }
  return out;
}

mjModel* load_urdf(const std::string& urdf) {
  auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  mj_makeEmptyFileVFS(vfs.get(), "robot.urdf", static_cast<int>(urdf.size()));
  std::memcpy(vfs->filedata[0], urdf.data(), urdf.size());
  char error[300] = "";
  mjModel* model = mj_loadXML("robot.urdf", vfs.get(), error, sizeof error);
  EXPECT_NE(model, nullptr) << error;
  mj_deleteVFS(vfs.get());
  return model;
}

Case make_clean(const std::string& effect, std::uint64_t seed) {
  CaseOptions options;
  options.duration = 3;
  options.noise_scale = 0;
  return make_case(parse_request(effect), seed, options);
}

TEST(CaseGenerator, TheSameSeedGivesTheSameBytes) {
  CaseOptions options;
  options.duration = 2;
  const Case a = make_case(parse_request("coulomb_friction"), 7, options),
             b = make_case(parse_request("coulomb_friction"), 7, options),
             c = make_case(parse_request("coulomb_friction"), 8, options);
  EXPECT_EQ(a.files, b.files);
  EXPECT_EQ(a.truth, b.truth);
  EXPECT_NE(a.files.at("train_1.csv"), c.files.at("train_1.csv"));
}

// Inverse dynamics of the recorded motion, computed by MuJoCo from the URDF, gives the recorded effort back.
TEST(CaseGenerator, WithoutAnEffectInverseDynamicsOfTheUrdfGivesTheRecordedEffort) {
  const Case made = make_clean("none", 5);
  mjModel* m = load_urdf(made.files.at("robot.urdf"));
  mjData* d = mj_makeData(m);
  const Csv csv = parse_csv(made.files.at("train_1.csv"));
  const std::vector<double>& time = csv.at("time");
  double worst = 0, largest = 0;
  for (std::size_t k = 2; k + 2 < time.size(); ++k) {
    for (int j = 0; j < m->njnt; ++j) {
      const std::string base = std::string("/joint_states/") + mj_id2name(m, mjOBJ_JOINT, j);
      const std::vector<double>& v = csv.at(base + "/velocity");
      d->qpos[j] = csv.at(base + "/position")[k];
      d->qvel[j] = v[k];
      d->qacc[j] = (v[k - 2] - 8 * v[k - 1] + 8 * v[k + 1] - v[k + 2]) / (3 * (time[k + 2] - time[k - 2]));
    }
    mj_inverse(m, d);
    for (int j = 0; j < m->njnt; ++j) {
      const double effort = csv.at(std::string("/joint_states/") + mj_id2name(m, mjOBJ_JOINT, j) + "/effort")[k];
      worst = std::max(worst, std::abs(effort - d->qfrc_inverse[j]));
      largest = std::max(largest, std::abs(effort));
    }
  }
  // What is left is the five-point difference over 2 to 4 ms and the seven digits of the file.
  EXPECT_LT(worst, 2e-3 * largest);
  mj_deleteData(d);
  mj_deleteModel(m);
}

double find_gain(const std::string& yaml, const std::string& joint, const char* key) {
  const std::size_t at = yaml.find(std::string(key) + ": ", yaml.find("    " + joint + ": {kp"));
  return std::stod(yaml.substr(at + std::strlen(key) + 2));
}

TEST(CaseGenerator, TheRecordedEffortIsTheServoLawOfTheExperimentFile) {
  const Case made = make_clean("viscous_friction", 6);
  const std::string& yaml = made.files.at("experiment.yaml");
  const Csv csv = parse_csv(made.files.at("train_2.csv"));
  for (const auto& [name, effort] : csv.columns) {
    if (name.rfind("/joint_states/", 0) != 0 || name.find("/effort") == std::string::npos) continue;
    const std::string joint = name.substr(14, name.size() - 14 - 7), command = "/joint_commands/" + joint,
                      state = "/joint_states/" + joint;
    const double kp = find_gain(yaml, joint, "kp"), kd = find_gain(yaml, joint, "kd");
    for (std::size_t k = 0; k < effort.size(); ++k) {
      const double law = kp * (csv.at(command + "/position")[k] - csv.at(state + "/position")[k]) +
                         kd * (csv.at(command + "/velocity")[k] - csv.at(state + "/velocity")[k]);
      // Seven digits of position in the file times the stiffness.
      EXPECT_NEAR(effort[k], law, 1e-6 * (kp + kd)) << joint << " " << k;
    }
  }
}

TEST(CaseGenerator, AStandingRobotsFootSensorsCarryWhatIsAboveThem) {
  Prng random(3);
  const RobotPlan robot = make_biped(random);
  Commands still = make_commands(robot, "release", {0.0, 1.0}, random);
  const Reading r = Reality(robot, {}).run(still, {1.0}, Vec3{}).at(0);
  double above = 0;
  for (const LinkPlan& link : robot.links) above += link.mass * 9.81;
  for (const FootPlan& foot : robot.feet) above -= robot.links[static_cast<std::size_t>(foot.link)].mass * 9.81;
  // At rest after 3.5 s; the feet may tilt by 1e-3 rad, the rest of the motion has died out to 1e-4 of the weight.
  EXPECT_NEAR(r.foot_force[0][2] + r.foot_force[1][2], above, 1e-3 * above);
}

// The ground holds a light sole that is pressed flat. In the air only the bush holds it, and the bush's damping needs
// shorter steps than the servos do.
TEST(CaseGeneratorNightly, ASoftSoleThatLeavesTheGroundNeedsShorterSteps) {
  Prng random(3);
  RobotPlan robot = make_biped(random);
  robot.base_position[2] += 0.01;  // [m] dropped: 45 ms in the air, 2.5 s before the recording
  Commands still = make_commands(robot, "release", {0.0, 0.1}, random);
  std::vector<Hidden> soft = draw_hidden("foot_compliance", robot, {}, 1.0, random);
  for (Hidden& sole : soft)
    sole.parameters["c_roll"] = sole.parameters["c_pitch"] = 30.0;  // [N m s/rad], of a heavy biped
  EXPECT_THROW(Reality(robot, soft).run(still, {0.1}, Vec3{}), InsaneCase);
  const Reading landed = Reality(robot, soft).run(still, {0.1}, Vec3{}, true).at(0);
  EXPECT_LT(std::hypot(landed.base_orientation[1], landed.base_orientation[2]), 0.05) << "the robot stands";
}

TEST(CaseGenerator, DryFrictionHoldsAJointStillBelowItsLevel) {
  RobotPlan robot;
  robot.links.resize(2);
  robot.links[0].name = "mount";
  LinkPlan& link = robot.links[1];
  link.name = "pendulum";
  link.parent = 0;
  link.mass = 1;
  link.com = {0, 0, -0.5};
  link.inertia = {0.02, 0.02, 0.01, 0, 0, 0};
  link.joint.name = "hinge";
  link.joint.axis = {0, 1, 0};
  link.joint.kp = 1e-6;
  link.joint.kd = 1e-6;
  link.joint.limit = 1;
  link.joint.start = 0.3;  // gravity pulls with 9.81 x 0.5 x sin 0.3 = 1.45 N m
  Commands still;
  still.time = {0.0, 5.0};
  still.position = {{0.3, 0.3}};
  still.velocity = {{0.0, 0.0}};
  const Hidden held{"coulomb_friction", "joint", "hinge", {{"level", 1.6}}},
      slipping{"coulomb_friction", "joint", "hinge", {{"level", 1.3}}};
  // Creep of the soft friction constraint: 1e-6 rad/s at most, over 6.5 s.
  EXPECT_NEAR(Reality(robot, {held}).run(still, {5.0}, Vec3{}).at(0).position[0], 0.3, 1e-5);
  EXPECT_LT(Reality(robot, {slipping}).run(still, {5.0}, Vec3{}).at(0).position[0], 0.29);
}

// An arm that folds out until its first joint turns three hundred times less than at the start.
RobotPlan make_folded_arm() {
  RobotPlan robot;
  robot.name = "folded";
  robot.links.resize(3);
  robot.links[0].name = "mount";
  LinkPlan& column = robot.links[1];
  column.name = "column";
  column.parent = 0;
  column.mass = 4;
  column.com = {0, 0, 0.1};
  column.inertia = {0.02, 0.02, 0.002, 0, 0, 0};
  column.joint = {"turn", {0, 0, 0.2}, {}, {0, 0, 1}, 1530, 61, 400, 0.0, "arm", 1};
  LinkPlan& boom = robot.links[2];
  boom.name = "boom";
  boom.parent = 1;
  boom.mass = 5;
  boom.com = {0, 0, 0.5};
  boom.inertia = {0.1, 0.1, 0.002, 0, 0, 0};
  boom.joint = {"fold", {0, 0, 0.3}, {}, {0, 1, 0}, 1600, 60, 400, 1.5, "arm", 1};
  return robot;
}

TEST(CaseGenerator, AServoIsAsStableWhereTheArmIsStretchedAsWhereItStarted) {
  Commands commands;
  commands.time = {0.0, 1.0};
  commands.position = {{0.0, 0.3}, {1.5, 0.0}};
  commands.velocity = {{0.0, 0.0}, {0.0, 0.0}};
  std::vector<double> times;
  for (int k = 0; k <= 40; ++k) times.push_back(0.05 * k);
  Reality reality(make_folded_arm(), {});
  const std::vector<Reading> readings = reality.run(commands, times, {});
  // At rest for 20 time constants of the servos: what still moves then is the integrator's own hum.
  EXPECT_LT(std::abs(readings.back().velocity[0]), 1e-6);
  EXPECT_NEAR(readings.back().position[0], 0.3, 1e-6);
}

TEST(CaseGenerator, LawsMeetTheirClosedForms) {
  JointReality j;
  j.bouc_wen_yield = 0.02;
  double z = 0;
  for (int i = 0; i < 40000; ++i) z += 1e-5 * calc_bouc_wen_rate(j, 1.0, z);
  EXPECT_NEAR(z, 0.02, 1e-6);  // 20 yield angles of travel: saturated
  j.gap = 0.01;
  j.stiffness = 100;
  j.damping = 1;
  EXPECT_EQ(calc_transmission_torque(j, 0.004, 0, 1, 0), 0);           // inside the gap
  EXPECT_NEAR(calc_transmission_torque(j, 0.015, 0, 0, 0), 1, 1e-12);  // 0.01 rad beyond half the gap
  EXPECT_EQ(calc_transmission_torque(j, 0.0051, 0, -5, 0), 0);         // teeth do not pull
  j.saturation = 2;
  j.torque_scale = 0.5;
  EXPECT_EQ(calc_drive_torque(j, 7, 0, 0, 0), 1);
}

TEST(CaseGenerator, ADriveThatIsLimitedBySpeedGivesStallTorqueAtRestAndNothingAtItsLargestSpeed) {
  JointReality j;
  const Hidden hidden{"velocity_limit", "joint", "elbow", {{"stall_torque", 10}, {"max_speed", 4}}};
  find_joint_effect("velocity_limit")->hide(j, hidden);
  EXPECT_EQ(calc_drive_torque(j, 30, 0, 0, 0), 10);
  EXPECT_EQ(calc_drive_torque(j, -30, 3, 0, 0), -2.5);  // braking is limited as driving is
  EXPECT_EQ(calc_drive_torque(j, 30, -4, 0, 0), 0);
  EXPECT_EQ(calc_drive_torque(j, 2, 3, 0, 0), 2);
}

TEST(CaseGenerator, ADriveWithADeadZoneGivesNothingForSmallEffortsAndLessByItsWidthForOthers) {
  JointReality j;
  find_joint_effect("dead_zone")->hide(j, {"dead_zone", "joint", "elbow", {{"width", 2}}});
  EXPECT_EQ(calc_drive_torque(j, 1.9, 0, 0, 0), 0);
  EXPECT_EQ(calc_drive_torque(j, 5, 0, 0, 0), 3);
  EXPECT_EQ(calc_drive_torque(j, -5, 1, 0, 0), -3);
}

// One effect of each kind of law; the proof itself refuses a case whose effect does not show.
TEST(CaseGenerator, AnEffectIsHiddenWhereTheTruthSaysAndShowsAboveTheNoise) {
  CaseOptions options;
  options.duration = 2;
  for (const char* effect : {"stribeck_friction", "backlash", "actuator_lag", "cogging", "payload", "sensor_delay",
                             "thermal_torque_loss", "magnetic_detent", "sprung_mass"}) {
    const Case made = make_case(parse_request(effect), 21, options);
    ASSERT_EQ(made.truth["hidden"].size(), 1u) << effect;
    EXPECT_EQ(made.truth["hidden"][0]["effect"], effect);
    EXPECT_GE(made.truth["strength"][0].get<double>(), 4.0) << effect;
  }
}

TEST(CaseGenerator, ADeckHoldsEverySingleEffectAndCasesWithNothing) {
  std::map<std::string, int> seen;
  for (const CaseRequest& request : make_case_plan(120, 1))
    seen[request.effects.size() == 1 ? request.effects[0] : request.family]++;
  for (const auto* list :
       {&joint_effects(), &link_effects(), &foot_effects(), &biped_sensor_effects(), &unknown_effects()}) {
    for (const std::string& effect : *list) EXPECT_GE(seen[effect], 1) << effect;
  }
  for (const char* family : {"none", "stand_none", "pair", "pair_same_joint", "stand_pair", "triple"})
    EXPECT_GE(seen[family], 1) << family;
}

TEST(CaseGenerator, AFamilyAskedForIsTheOnlyOneDealt) {
  for (const CaseRequest& request : make_case_plan(30, 2, "stand")) EXPECT_TRUE(request.biped);
  for (const CaseRequest& request : make_case_plan(30, 2, "pair,none"))
    EXPECT_TRUE(request.family == "pair" || request.family == "none") << request.family;
  EXPECT_THROW(make_case_plan(3, 2, "ghosts"), std::invalid_argument);
  // Rounds of walks have no other cases: these would be left out without a word.
  EXPECT_THROW(make_case_plan(3, 2, "pair,walk_joint"), std::invalid_argument);
  EXPECT_THROW(make_case_plan(3, 2, "walk_pair,walk_dirty"), std::invalid_argument);
  EXPECT_EQ(make_case_plan(3, 2, "walk_pair,walk_joint").size(), 3u);
}

// What differs from case to case: sizes, kinds of robots, rates, and what was not recorded.
TEST(CaseGenerator, CasesDifferInRobotRateAndColumns) {
  std::set<std::string> robots;
  std::set<double> rates;
  std::set<bool> velocity, effort, stated;
  Prng random(4);
  for (int i = 0; i < 80; ++i) {
    const RobotPlan robot = make_arm(random);
    const RecorderPlan plan = draw_recorder(robot, {}, random);
    robots.insert(robot.name);
    rates.insert(plan.rate);
    velocity.insert(plan.with_velocity);
    effort.insert(plan.with_effort);
    stated.insert(plan.noise_stated);
  }
  EXPECT_GE(robots.size(), 8u);
  EXPECT_GE(rates.size(), 5u);
  EXPECT_EQ(velocity.size() + effort.size() + stated.size(), 6u);
}

// A humanoid as somebody else might write it: axes of either sense, roll before pitch, hips turned about y and knees
// turned back, no names that say what a joint is for.
std::string make_foreign_humanoid(const std::string& soles, const std::string& ankle_roll) {
  const auto link = [](const std::string& name, double mass, const std::string& more) {
    return "<link name=\"" + name + "\"><inertial><origin xyz=\"0.01 0 -0.1\"/><mass value=\"" + std::to_string(mass) +
           "\"/><inertia ixx=\"0.02\" iyy=\"0.02\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>" + more +
           "</link>";
  };
  const auto joint = [](const std::string& parent, const std::string& child, const std::string& origin,
                        const std::string& axis, const std::string& type = "revolute") {
    return "<joint name=\"j" + child + "\" type=\"" + type + "\"><parent link=\"" + parent + "\"/><child link=\"" +
           child + "\"/><origin " + origin + "/><axis xyz=\"" + axis +
           "\"/><limit lower=\"-2\" upper=\"2\" effort=\"100\" velocity=\"9\"/></joint>";
  };
  std::string out = "<robot name=\"foreign\">" + link("body", 12, "") + link("chest", 15, "") +
                    joint("body", "chest", "xyz=\"0 0 0.2\"", "0 0 -1");
  for (const std::string side : {"0", "1"}) {
    const std::string y = side == "0" ? "0.1" : "-0.1", turn = side == "0" ? "1" : "-1";
    const auto name = [&](const char* part) { return part + side; };
    out += link(name("a"), 1, "") + link(name("b"), 1, "") + link(name("c"), 5, "") + link(name("d"), 3, "") +
           link(name("e"), 0.5, "") + link(name("f"), 1, soles);
    out += joint("body", name("a"), "xyz=\"0 " + y + " 0\"", "-1 0 0") +
           joint(name("a"), name("b"), "xyz=\"0 0 -0.05\"", "0 0 1") +
           joint(name("b"), name("c"), "xyz=\"0 0 0\" rpy=\"0 -0.2 0\"", "0 " + turn + " 0") +
           joint(name("c"), name("d"), "xyz=\"0 0 -0.3\" rpy=\"0 0.2 0\"", "0 -1 0") +
           joint(name("d"), name("e"), "xyz=\"0 0 -0.3\"", "0 " + turn + " 0") +
           joint(name("e"), name("f"), "xyz=\"0 0 -0.02\"", "1 0 0", ankle_roll);
  }
  return out + "</robot>";
}

std::string make_spheres() {
  std::string soles;
  for (const char* at : {"0.12 0.04 -0.05", "0.12 -0.04 -0.05", "-0.06 0.04 -0.05", "-0.06 -0.04 -0.05"}) {
    soles += "<collision><origin xyz=\"" + std::string(at) +
             "\"/><geometry><sphere radius=\"0.005\"/></geometry></collision>";
  }
  return soles;
}

RobotPlan stand_humanoid(const std::string& urdf) {
  const auto path = std::filesystem::temp_directory_path() / "hrp_foreign_humanoid.urdf";
  std::ofstream(path) << urdf;
  Prng random(3);
  return make_standing_robot(path.string(), random);
}

RobotPlan stand_foreign_humanoid() { return stand_humanoid(make_foreign_humanoid(make_spheres(), "revolute")); }

// Two triangles in millimetres, as meshes often are.
std::string make_mesh_sole() {
  const auto path = std::filesystem::temp_directory_path() / "hrp_foreign_sole.stl";
  std::ofstream file(path);
  file << "solid sole\n";
  for (const char* last : {"120 -40 -55", "-60 40 -55"}) {
    file << "facet normal 0 0 -1\nouter loop\nvertex 120 40 -55\nvertex " << last
         << "\nvertex -60 -40 -55\nendloop\nendfacet\n";
  }
  file << "endsolid sole\n";
  return "<collision><geometry><mesh filename=\"" + path.filename().string() +
         "\" scale=\"0.001 0.001 0.001\"/></geometry></collision>";
}

TEST(CaseGenerator, AHumanoidOfAUrdfStandsOnLevelSolesUnderItsCentreOfMass) {
  const RobotPlan robot = stand_foreign_humanoid();
  std::vector<double> q;
  for (int j = 0; j < joint_count(robot); ++j) q.push_back(joint(robot, j).start);
  ASSERT_EQ(robot.feet.size(), 2u);
  double mass = 0, ahead = 0;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const LinkPlan& link = robot.links[i];
    const Eigen::Vector3d com(link.com[0], link.com[1], link.com[2]);
    mass += link.mass;
    ahead += link.mass * (calc_pose(robot, static_cast<int>(i), q) * com).x();
  }
  for (const FootPlan& foot : robot.feet) {
    const Eigen::Isometry3d X = calc_pose(robot, foot.link, q);
    const Eigen::Vector3d sole = X * Eigen::Vector3d(foot.center[0], foot.center[1], foot.center[2] - foot.size[2] / 2);
    // Angles of three joints, rounded to four digits each.
    EXPECT_LT((X.linear() * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 3e-4);
    EXPECT_NEAR(sole.z(), -robot.base_position[2], 2e-4);
    EXPECT_NEAR(sole.x(), ahead / mass, 1e-3);
    EXPECT_NEAR(foot.size[0], 0.18, 1e-6);
  }
}

TEST(CaseGenerator, AHumanoidMayStandOnMeshesWithoutAnkleRolls) {
  std::string urdf = make_foreign_humanoid(make_mesh_sole(), "fixed");
  urdf.replace(urdf.rfind("</robot>"), 8, "<gazebo><sensor><visualize>true</visualize></sensor></gazebo></robot>");
  const RobotPlan robot = stand_humanoid(urdf);
  ASSERT_EQ(robot.feet.size(), 2u);
  for (const FootPlan& foot : robot.feet) {
    EXPECT_NEAR(foot.size[0], 0.18, 1e-6);
    EXPECT_NEAR(foot.size[1], 0.08, 1e-6);
  }
  EXPECT_EQ(find_role(robot, "left_ankle_roll"), -1);
  Prng random(5);
  const Commands swaying = make_commands(robot, "sway", {0.0, 1.0, 2.0}, random);
  for (double q : swaying.position[static_cast<std::size_t>(find_role(robot, "left_hip_roll"))]) {
    EXPECT_EQ(q, joint(robot, find_role(robot, "left_hip_roll")).start) << "a hip that rolls lifts the sole's edge";
  }
}

TEST(CaseGenerator, KneesOfAHumanoidOfAUrdfBendOverSolesThatStayLevelWhereTheyAre) {
  const RobotPlan robot = stand_foreign_humanoid();
  const char* roles[] = {"left_hip_pitch", "left_knee", "left_ankle_pitch"};
  for (const double knee : {0.3, 0.6, 0.9}) {
    const Vec3 leg = level_leg(robot, knee);
    std::vector<double> q;
    for (int j = 0; j < joint_count(robot); ++j) q.push_back(joint(robot, j).start);
    for (std::size_t i = 0; i < 3; ++i) {
      const int j = find_role(robot, roles[i]);
      q[static_cast<std::size_t>(j)] = joint(robot, j).sense * leg[i];
    }
    const FootPlan& foot = robot.feet[0];
    const Eigen::Isometry3d X = calc_pose(robot, foot.link, q);
    EXPECT_NEAR(X.linear()(2, 0), 0, 1e-9) << knee;
    EXPECT_NEAR((X * Eigen::Vector3d(foot.center[0], foot.center[1], foot.center[2])).x(), robot.sole_ahead, 1e-9);
  }
}

}  // namespace
}  // namespace hrp::cases
