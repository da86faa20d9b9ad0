// SPDX-License-Identifier: BSD-3-Clause
// Robots in MJCF and SDF are the robots that other readers see in them: MuJoCo itself, and ours of the same robot's
// URDF.
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/multibody/kinematics.h"
#include "common/multibody/mass_matrix.h"
#include "common/spatial/rpy.h"
#include "servers/model_parser/mjcf/compiled_model.h"
#include "servers/mujoco_dynamics/mjcf.h"
#include "tests/catch_complaint.h"
#include "tests/physics/scenario_robot.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const std::string kModels = source_dir() + "/models/";

Scenario make_scenario(const std::string& file, const std::string& more = "base: fixed\n") {
  return parse_scenario("robot: " + kModels + file + "\n" + more, kModels + "s.yaml");
}
RobotDescription load(const std::string& file, const std::string& more = "base: fixed\n") {
  return load_robot(make_scenario(file, more));
}

std::string find_complaint(const std::string& text, const std::string& more = "") {
  return catch_complaint([&] { parse_robot(text, "r.xml", parse_scenario("robot: r.xml\n" + more, "/dir/s.yaml")); });
}

// A pose of the robot with joint `i` of the other one's order at the position of its namesake.
State make_state(const TreeSpec& tree, const TreeSpec& first) {
  State state;
  state.q = state.qd = Eigen::VectorXd::Zero(tree.num_joints());
  for (int i = 0; i < tree.num_joints(); ++i) state.q[i] = 0.2 + 0.1 * first.find_joint(tree.joint(i).name);
  return state;
}

// Largest difference of two mass matrices, relative to the largest entry: joints by name, the base first.
double compare_mass_matrices(const TreeSpec& a, const TreeSpec& b) {
  const Model model_a(a, {0, 0, -9.81}), model_b(b, {0, 0, -9.81});
  Data data_a(model_a), data_b(model_b);
  update_kinematics(model_a, make_state(a, a), &data_a);
  update_kinematics(model_b, make_state(b, a), &data_b);
  const Eigen::MatrixXd& M_a = update_mass_matrix(model_a, &data_a);
  const Eigen::MatrixXd& M_b = update_mass_matrix(model_b, &data_b);
  const int base = a.floating_base ? 6 : 0;
  std::vector<int> order;  // of b's velocities in a's order
  for (int i = 0; i < base; ++i) order.push_back(i);
  for (int i = 0; i < a.num_joints(); ++i) order.push_back(base + b.find_joint(a.joint(i).name));
  return (M_a - M_b(order, order)).cwiseAbs().maxCoeff() / M_a.cwiseAbs().maxCoeff();
}

void expect_same_joint(const JointSpec& a, const JointSpec& b) {
  EXPECT_EQ(a.kind, b.kind) << a.name;
  EXPECT_EQ(a.lower, b.lower) << a.name;
  EXPECT_EQ(a.upper, b.upper) << a.name;
  EXPECT_EQ(a.effort_limit, b.effort_limit) << a.name;
  EXPECT_EQ(a.viscous_friction, b.viscous_friction) << a.name;
  EXPECT_EQ(a.coulomb_friction, b.coulomb_friction) << a.name;
  EXPECT_EQ(a.actuated, b.actuated) << a.name;
  EXPECT_LT((a.X_PF.R - b.X_PF.R).cwiseAbs().maxCoeff(), 1e-15) << a.name;
  EXPECT_LT((a.X_PF.p - b.X_PF.p).cwiseAbs().maxCoeff(), 1e-15) << a.name;
}

void expect_same_robot(const RobotDescription& a, const RobotDescription& b) {
  ASSERT_EQ(a.tree.num_joints(), b.tree.num_joints());
  for (int i = 0; i < a.tree.num_joints(); ++i) {
    ASSERT_GE(b.tree.find_joint(a.tree.joint(i).name), 0) << a.tree.joint(i).name;
    expect_same_joint(a.tree.joint(i), b.tree.joint(b.tree.find_joint(a.tree.joint(i).name)));
  }
  ASSERT_EQ(a.shapes.size(), b.shapes.size());
  for (size_t i = 0; i < a.shapes.size(); ++i) {
    EXPECT_EQ(a.shapes[i].kind, b.shapes[i].kind) << i;
    EXPECT_LT((a.shapes[i].size - b.shapes[i].size).cwiseAbs().maxCoeff(), 1e-15) << i;
    EXPECT_LT((a.shapes[i].X_LG.p - b.shapes[i].X_LG.p).cwiseAbs().maxCoeff(), 1e-15) << i;
  }
  // Principal axes are found anew by MuJoCo: rounding.
  EXPECT_LT(compare_mass_matrices(a.tree, b.tree), 1e-12);
}

TEST(RobotFormats, TheArmInMjcfIsTheArm) {
  const RobotDescription urdf = load("test_robots/arm.urdf"), mjcf = load("test_robots/arm.xml");
  expect_same_robot(urdf, mjcf);
  const JointSpec& follower = mjcf.tree.joint(mjcf.tree.find_joint("grip_follower"));
  EXPECT_EQ(mjcf.tree.joint(follower.mimic.joint).name, "grip");
  EXPECT_EQ(follower.mimic.multiplier, -1.0);
  EXPECT_EQ(mjcf.tree.joint(0).rotor_inertia, 0.05);
  EXPECT_GE(mjcf.tree.find_frame("tool"), 0) << "a site is a frame";
  EXPECT_EQ(mjcf.warnings, urdf.warnings) << "nothing was left out";
}

TEST(RobotFormats, TheArmInSdfIsTheArmWithoutRotorsAndFollower) {
  RobotDescription urdf = load("test_robots/arm.urdf");
  for (int i = 0; i < urdf.tree.num_joints(); ++i) {
    urdf.tree.joint(i).rotor_inertia = 0.0;
    urdf.tree.joint(i).mimic = {};
  }
  const RobotDescription sdf = load("test_robots/arm.sdf");
  expect_same_robot(urdf, sdf);
  EXPECT_EQ(sdf.tree.joint(0).velocity_limit, 5.0);
}

// Written by the MuJoCo server with 17 digits, read by MuJoCo, and by us from what it made of it.
TEST(RobotFormats, OurHumanoidComesBackFromMjcf) {
  const Scenario scenario = parse_scenario(
      "robot: " + kModels + "hrp2p_like/hrp2p_like.urdf\nfeet: [L_ANKLE_R_LINK, R_ANKLE_R_LINK]\n", kModels + "s.yaml");
  RobotDescription urdf = load_robot(scenario);
  const Scenario bare = parse_scenario("robot: r.xml\n", "/dir/s.yaml");
  const RobotDescription mjcf = parse_robot(make_mjcf(urdf, scenario), "r.xml", bare);
  ASSERT_EQ(mjcf.tree.num_joints(), 30);
  for (int i = 0; i < 30; ++i) urdf.tree.joint(i).name = "j" + std::to_string(i);
  EXPECT_LT(compare_mass_matrices(urdf.tree, mjcf.tree), 1e-12);
  EXPECT_THAT(mjcf.warnings, Contains(HasSubstr("r.xml: warning: <worldbody>: what stands in the world is left out")));
  EXPECT_THAT(mjcf.warnings, Contains(HasSubstr("the scenario's 'servo' drives the joints")));
}

TEST(RobotFormats, AllThreeFormatsRunAlike) {
  const std::string more =
      "base: fixed\nservo: {default: {kp: 200, kd: 5}}\ninitial: {joints: {shoulder: 0.4, elbow: -0.7}}\n"
      "rotor_inertia: {turn: 0.05, shoulder: 0.04, elbow: 0.02, grip: 0.1, grip_follower: 0.1}\n";
  std::vector<Eigen::VectorXd> ends;
  for (const char* ending : {"urdf", "xml", "sdf"}) {
    ScenarioRobot run("robot: " + kModels + "test_robots/arm." + ending + "\n" + more);
    run.command.q = Eigen::VectorXd::Zero(5);
    for (int i = 0; i < 500; ++i) ASSERT_EQ(run.step(), StepStatus::kOk) << run.simulator.fault_text();
    const TreeSpec& tree = run.simulator.tree();
    Eigen::VectorXd q(4);  // SDF has no follower
    int at = 0;
    for (const char* name : {"turn", "shoulder", "elbow", "grip"})
      q[at++] = run.simulator.state().q[tree.find_joint(name)];
    ends.push_back(q);
  }
  // Rounding of poses and inertias grows with the 500 steps.
  EXPECT_LT((ends[1] - ends[0]).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((ends[2] - ends[0]).head<3>().cwiseAbs().maxCoeff(), 2e-3) << "the second jaw moves by itself";
  EXPECT_GT(ends[0].cwiseAbs().maxCoeff(), 1e-4) << "it moved";
}

const char kOddMjcf[] = R"(<mujoco model="odd">
  <compiler autolimits="true"/>
  <default><joint armature="0.01"/><default class="leg"><geom type="capsule" size="0.03"/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="base" pos="0 0 1">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1" mass="3"/>
      <body name="thigh" pos="0.1 0 0" euler="20 10 0" childclass="leg">
        <joint name="hip_x" axis="1 0 0" pos="0 0 0.02"/>
        <joint name="hip_y" axis="0 1 0" ref="15" range="-40 60"/>
        <geom fromto="0 0 0 0.05 0 -0.3" mass="2"/>
        <body name="shank" pos="0.05 0 -0.3">
          <joint name="knee" axis="0 1 0.2" pos="0.01 0.02 0.03" springref="10" stiffness="3" damping="0.5"/>
          <joint name="stretch" type="slide" axis="0 0 1" ref="0.05"/>
          <geom fromto="0 0 0 0 0 -0.3" mass="1"/>
          <site name="sole" pos="0 0 -0.33"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
)";

// Joints beside the origin, several of them in a body, references other than zero, classes, degrees.
TEST(RobotFormats, PosesAreThoseThatMujocoComputes) {
  const RobotDescription robot = parse_robot(kOddMjcf, "odd.xml", parse_scenario("robot: odd.xml\n", "/dir/s.yaml"));
  const CompiledModel mujoco = compile_mjcf(kOddMjcf, "odd.xml");
  std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(mujoco.get()), mj_deleteData);
  const double q[] = {0.3, -0.5, 0.9, 0.12};
  std::copy(q, q + 4, data->qpos + 7);
  mj_kinematics(mujoco.get(), data.get());

  State state;
  ASSERT_EQ(robot.tree.num_joints(), 4);
  state.q = Eigen::Map<const Eigen::VectorXd>(q, 4);
  state.qd = Eigen::VectorXd::Zero(4);
  state.p_WB = {0, 0, 1};
  const Model model(robot.tree, {0, 0, -9.81});
  Data ours(model);
  update_kinematics(model, state, &ours);
  for (const char* name : {"thigh", "shank"}) {
    const Transform X_WF = calc_frame_pose(model, ours, robot.tree.find_frame(name));
    const double* p = data->xpos + 3 * mj_name2id(mujoco.get(), mjOBJ_BODY, name);
    EXPECT_LT((X_WF.p - Vector3d(p[0], p[1], p[2])).norm(), 1e-14) << name;
  }
  EXPECT_NEAR(robot.tree.joint(1).lower, -40 * M_PI / 180, 1e-15);
  EXPECT_DOUBLE_EQ(robot.tree.joint(2).spring.stiffness, 3.0);
  EXPECT_NEAR(robot.tree.joint(2).spring.rest, 10 * M_PI / 180, 1e-15);
  EXPECT_EQ(robot.tree.joint(2).rotor_inertia, 0.01);
}

TEST(RobotFormats, WhatMjcfHasBeyondUsIsRefusedByNameAndLine) {
  const auto complain = [](const std::string& bodies, const std::string& more = "") {
    return find_complaint("<mujoco>\n<worldbody>\n<body name='a'><freejoint/><geom size='1'/>\n" + bodies +
                          "</body>\n</worldbody>\n" + more + "</mujoco>\n");
  };
  EXPECT_THAT(
      complain("<body name='b'>\n<joint name='shoulder' type='ball'/><geom size='1'/></body>"),
      HasSubstr("r.xml:5: error: <joint name=\"shoulder\">: of body 'b' is of type 'ball', expected hinge or slide"));
  EXPECT_THAT(complain("<body name='b'><joint name='j'/><geom size='1'/></body>",
                       "<tendon>\n<fixed name='rope'><joint joint='j' coef='1'/></fixed></tendon>"),
              HasSubstr("<tendon name=\"rope\">: tendons are not supported"));
  EXPECT_THAT(
      complain("<body name='b'><joint name='j'/><geom size='1'/></body>",
               "<equality>\n<weld name='w' body1='a' body2='b'/></equality>"),
      HasSubstr(
          "r.xml:7: error: <weld name=\"w\">: this equality constraint between bodies 'a' and 'b' is not supported"));
  EXPECT_THAT(complain("<geom name='egg' type='ellipsoid' size='1 2 3'/>"),
              HasSubstr("r.xml:4: error: <geom name=\"egg\">: of body 'a' is an ellipsoid"));
  EXPECT_THAT(find_complaint("<mujoco><worldbody><body name='a'><freejoint/><geom size='1'/></body>\n<body "
                             "name='b'><freejoint/><geom size='1'/>"
                             "</body></worldbody></mujoco>"),
              HasSubstr("r.xml:2: error: <body name=\"b\">: floats, and so does 'a'"));
  EXPECT_THAT(find_complaint("<mujoco><worldbody><body name='a'><geom size='1'/></body></worldbody></mujoco>"),
              HasSubstr("the scenario must say 'base: fixed'"));
  EXPECT_THAT(find_complaint("<mujoco><worldbody/></mujoco>"), HasSubstr("there is no robot"));
  EXPECT_THAT(find_complaint("<mujoco>\n<worldbody>\n<bode/></worldbody></mujoco>"),
              HasSubstr("r.xml:3: error: MuJoCo refuses it"));
}

TEST(RobotFormats, WhatSdfHasBeyondUsIsRefusedByNameAndLine) {
  const auto complain = [](const std::string& inside, const std::string& more = "") {
    return find_complaint(
        "<sdf version='1.9'>\n<model name='m'>\n<link name='a'/>\n<link name='b'/>\n" + inside + "</model></sdf>\n",
        more);
  };
  const auto joint = [](const std::string& name, const std::string& type, const std::string& parent,
                        const std::string& child) {
    return "<joint name='" + name + "' type='" + type + "'><parent>" + parent + "</parent><child>" + child +
           "</child><axis><xyz>0 0 1</xyz></axis></joint>\n";
  };
  EXPECT_THAT(complain(joint("s", "ball", "a", "b")),
              HasSubstr("r.xml:5: error: joint 's': is of type 'ball', expected revolute"));
  EXPECT_THAT(complain(joint("s", "revolute", "a", "b") + joint("t", "revolute", "a", "b")),
              HasSubstr("r.xml:6: error: joint 't': moves link 'b', which joint 's' moves already"));
  EXPECT_THAT(complain(""), HasSubstr("r.xml:4: error: link 'b': hangs from no joint, and neither does 'a'"));
  EXPECT_THAT(complain(joint("s", "revolute", "world", "a")), HasSubstr("the scenario must say 'base: fixed'"));
  EXPECT_THAT(complain(joint("s", "revolute", "a", "c")), HasSubstr("libsdformat refuses it"));
  EXPECT_THAT(find_complaint("<sdf version='1.9'><world name='w'/></sdf>"),
              HasSubstr("worlds go into the scenario's 'world'"));
  EXPECT_THAT(find_complaint("<sdf version='1.9'/>"), HasSubstr("has no <model> right below <sdf>"));
}

// Faults that the common way finds are told with the lines of the file that people wrote.
// Faults that the common way finds are told with the lines of the file that people wrote.
TEST(RobotFormats, FaultsOfTheTreeHaveTheLinesOfTheFileItself) {
  const std::string foot =
      "<link name='foot'>\n<collision "
      "name='c'><geometry><mesh><uri>sole.stl</uri></mesh></geometry></collision></link>";
  EXPECT_THAT(find_complaint("<sdf version='1.9'>\n<model name='m'>\n" + foot + "</model></sdf>", "feet: [foot]\n"),
              HasSubstr("r.xml:4: error: link 'foot' <collision> <mesh>: there is no file 'sole.stl'"));
}

// The compiler moves a mesh to its centre of mass and turns it; the description has it where the file has it.
TEST(RobotFormats, MeshesStayWhereTheFileHasThem) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "mjcf_mesh";
  std::filesystem::create_directories(folder / "meshes");
  std::ofstream(folder / "meshes/wedge.obj")
      << "v 0 0 0\nv 200 0 0\nv 0 100 0\nv 0 0 50\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const std::string text =
      "<mujoco><compiler meshdir='meshes' angle='radian'/><asset><mesh file='wedge.obj' scale='0.001 0.001 "
      "0.002'/></asset><worldbody>"
      "<body name='a'><freejoint/><geom type='mesh' mesh='wedge' pos='1 2 3' euler='0 0 "
      "0.5'/></body></worldbody></mujoco>";
  const std::string path = (folder / "r.xml").string();
  const RobotDescription robot =
      parse_robot(text, path, parse_scenario("robot: r.xml\nfeet: [a]\n", (folder / "s.yaml").string()));
  ASSERT_EQ(robot.shapes.size(), 1u);
  EXPECT_EQ(robot.shapes[0].mesh, (folder / "meshes/wedge.obj").string());
  EXPECT_TRUE(robot.shapes[0].scale.isApprox(Vector3d(0.001, 0.001, 0.002)));
  EXPECT_LT((robot.shapes[0].X_LG.p - Vector3d(1, 2, 3)).norm(), 1e-15);
  EXPECT_LT((robot.shapes[0].X_LG.R - make_rotation_from_rpy({0, 0, 0.5})).norm(), 1e-15);
}

std::string read_file(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// Whatever a file holds, it is read or refused. The fuzz targets mjcf and sdf try many more.
TEST(RobotFormats, DamagedFilesAreReadOrRefused) {
  const Scenario scenario = parse_scenario("robot: r.xml\nbase: fixed\nservo: {default: {kp: 1}}\n", "/dir/s.yaml");
  std::mt19937 random(25);
  for (const auto& [file, count] : {std::pair("arm.xml", 300), std::pair("arm.sdf", 20)}) {
    const std::string text = read_file(kModels + "test_robots/" + file);
    int refused = 0;
    for (int i = 0; i < count; ++i) {
      std::string damaged = text;
      for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = static_cast<char>("0<\"- x/9e"[random() % 9]);
      if (i % 5 == 0) damaged.resize(random() % damaged.size());
      try {
        parse_robot(damaged, "r.xml", scenario);
      } catch (const InputError&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, count / 4) << file;
  }
}

// Articulated things of the world hang from it beside a robot that is held there.
TEST(RobotFormats, ADoorOfTheWorldLeansOnTheArmWithTheMomentThatPushesIt) {
  ScenarioRobot run("robot: " + kModels +
                    "test_robots/arm_and_door.xml\nbase: fixed\nground: {type: none}\nself_collision: true\n"
                    "servo: {default: {kp: 200, kd: 5}}\ninitial: {joints: {shoulder: 0.4, elbow: -0.7}}\n");
  const TreeSpec& tree = run.robot.tree;
  const int door = tree.find_link("door"), hinge = tree.find_joint("hinge");
  ASSERT_FALSE(tree.joint(hinge).actuated) << "the file has actuators, and none for the hinge";
  ExternalWrench push{door, Vector6d::Zero()};
  push.F_W[2] = 3.0;  // [N m] about the hinge
  for (int i = 0; i < 4000; ++i) ASSERT_EQ(run.step({push}), StepStatus::kOk) << run.simulator.fault_text();
  EXPECT_LT(std::abs(run.simulator.state().qd[hinge]), 1e-3) << "at rest";
  ASSERT_EQ(run.simulator.contact_forces().size(), 1u);
  const PairForce& pair = run.simulator.contact_forces()[0];
  ASSERT_EQ(std::max(pair.body_a, pair.body_b), door);
  const Vector3d hinge_W(0.6, 0.6, 0.8);
  const double moment = pair.total[2] + (pair.p_WR - hinge_W).cross(Vector3d(pair.total.tail<3>())).z();
  // What is left is the creeping of damper and servo.
  EXPECT_NEAR(std::abs(moment), 3.0, 0.01);
}

TEST(RobotFormats, RollPitchYawAreExactAtRightAngles) {
  for (const double pitch : {0.3, M_PI / 2, -M_PI / 2, M_PI / 2 - 1e-9, -M_PI / 2 + 1e-12, M_PI}) {
    const Matrix3d R = make_rotation_from_rpy({0.7, pitch, -1.1});
    EXPECT_LT((make_rotation_from_rpy(calc_rpy(R)) - R).cwiseAbs().maxCoeff(), 1e-15) << pitch;
  }
}

}  // namespace
}  // namespace hrp
