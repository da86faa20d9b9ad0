// SPDX-License-Identifier: BSD-3-Clause
// <loop> and <unactuated/> in a URDF: what is refused and why, and how the chain is closed at the start.
#include "servers/model_parser/loop_scan.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/multibody/close_loops.h"
#include "common/robot/closed_chains.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

// A four-bar in the x-z plane: ground 0.5, crank 0.2, coupler 0.5, rocker 0.3 m. Bars lie along x at zero; positive
// angles turn x towards -z.
constexpr double kGround = 0.5, kCrank = 0.2, kCoupler = 0.5, kRocker = 0.3;

std::string make_bar(const std::string& name) {
  return "<link name='" + name +
         "'><inertial><origin xyz='0.1 0 0'/><mass value='1'/>"
         "<inertia ixx='0.01' ixy='0' ixz='0' iyy='0.01' iyz='0' izz='0.01'/></inertial></link>\n";
}

std::string make_hinge(const std::string& name, const std::string& parent, const std::string& child, double x,
                       bool driven) {
  return "<joint name='" + name + "' type='continuous'><parent link='" + parent + "'/><child link='" + child +
         "'/><origin xyz='" + std::to_string(x) + " 0 0'/><axis xyz='0 1 0'/>" + (driven ? "" : "<unactuated/>") +
         "</joint>\n";
}

std::string make_tree(bool driven_rocker = false) {
  return make_bar("ground") + make_bar("crank") + make_bar("coupler") + make_bar("rocker") +
         make_hinge("drive", "ground", "crank", 0, true) +
         make_hinge("elbow", "crank", "coupler", kCrank, driven_rocker) +
         make_hinge("swing", "ground", "rocker", kGround, driven_rocker);
}

constexpr char kTurn[] = "rpy='1.5707963267948966 0 0'";  // z along the hinge

std::string make_loop(const std::string& head = "name='tie' type='pin'", const std::string& link_a = "coupler",
                      const std::string& link_b = "rocker", const std::string& xyz_a = "0.5 0 0") {
  return "<loop " + head + ">\n<frame_a link='" + link_a + "'><origin xyz='" + xyz_a + "' " + kTurn +
         "/></frame_a>\n<frame_b link='" + link_b + "'><origin xyz='0.3 0 0' " + kTurn + "/></frame_b>\n</loop>\n";
}

// The tree takes seven lines behind that of <robot>, so that a loop begins in line 9.
RobotDescription parse(const std::string& body, const std::string& more) {
  const Scenario scenario =
      parse_scenario("robot: r.urdf\nbase: fixed\nservo: {default: {kp: 1}}\n" + more, "/dir/s.yaml");
  return parse_robot("<robot name='r'>\n" + body + "</robot>\n", "r.urdf", scenario);
}

std::string find_complaint(const std::string& loop, const std::string& more = "initial: {joints: {drive: -1.2}}\n") {
  try {
    parse(make_tree() + loop, more);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

Scenario read_merged(const RobotDescription& robot) { return parse_scenario(robot.scenario, robot.scenario_path); }

TEST(LoopScan, CarriesTheDescriptionsLoopsInTheScenarioThatServersRead) {
  const RobotDescription robot = parse(make_tree() + make_loop(), "initial: {joints: {drive: -1.2}}\n");
  const Scenario merged = read_merged(robot);
  ASSERT_EQ(merged.loops.size(), 1u);
  const LoopSpec& loop = merged.loops[0];
  EXPECT_EQ(loop.name, "tie");
  EXPECT_EQ(loop.kind, "pin");
  EXPECT_EQ(loop.link_a, "coupler");
  EXPECT_EQ(loop.link_b, "rocker");
  EXPECT_EQ(loop.X_AF.p, Vector3d(0.5, 0, 0));
  EXPECT_LT((loop.X_BF.R - make_rotation_from_rpy({1.5707963267948966, 0, 0})).norm(), 1e-15) << "rounding of sines";
  EXPECT_FALSE(robot.tree.joint(robot.tree.find_joint("elbow")).actuated);
  EXPECT_TRUE(robot.tree.joint(robot.tree.find_joint("drive")).actuated);
}

// The law of cosines, twice: the diagonal d from the crank's end to the rocker's pivot splits the linkage into
// triangles.
TEST(LoopScan, APassiveFourBarIsClosedAtTheStartAsTheLawOfCosinesSays) {
  for (const double crank : {-0.9, -1.2, -1.6, -2.0}) {
    const RobotDescription robot =
        parse(make_tree() + make_loop(), "initial: {joints: {drive: " + std::to_string(crank) + "}}\n");
    const auto pose = read_merged(robot).initial_joints;
    EXPECT_EQ(pose.at("drive"), std::stod(std::to_string(crank))) << "a given position stays";
    const double x = kCrank * std::cos(crank), z = -kCrank * std::sin(crank);  // of the crank's end
    const double d = std::hypot(kGround - x, z);
    const double at_pivot = std::acos((d * d + kRocker * kRocker - kCoupler * kCoupler) / (2.0 * d * kRocker));
    const double to_end = std::atan2(z, x - kGround);  // direction from the pivot to the crank's end, up is positive
    // Angles here turn downward. Of the two ways to assemble it, the one that was found.
    const double swing = pose.at("swing");
    const double above = std::remainder(swing + to_end - at_pivot, 2.0 * M_PI),
                 below = std::remainder(swing + to_end + at_pivot, 2.0 * M_PI);
    EXPECT_LT(std::min(std::abs(above), std::abs(below)), 1e-10)
        << "crank at " << crank << ": Gauss-Newton ends at 1e-12 m";
  }
}

TEST(LoopScan, NamesFileLineAndWhatWasExpected) {
  EXPECT_THAT(find_complaint(make_loop("type='pin'")), HasSubstr("r.urdf:9: error: <loop>: has no name"));
  EXPECT_THAT(find_complaint(make_loop("name='tie' type='rope'")),
              HasSubstr("r.urdf:9: error: loop 'tie': is of type 'rope', expected ball, pin or weld"));
  EXPECT_THAT(find_complaint(make_loop("name='tie'")), HasSubstr("is of type '', expected ball"));
  EXPECT_THAT(find_complaint(make_loop("name='a.b' type='pin'")), HasSubstr("expected a name without '.'"));
  EXPECT_THAT(find_complaint(make_loop("name='tie' type='pin'", "couple")),
              HasSubstr("r.urdf:10: error: loop 'tie' <frame_a>: names link 'couple', which is not in the file; did "
                        "you mean 'coupler'?"));
  EXPECT_THAT(find_complaint(make_loop("name='tie' type='pin'", "coupler", "")),
              HasSubstr("r.urdf:11: error: loop 'tie' <frame_b>: attribute 'link' is missing"));
  EXPECT_THAT(find_complaint(make_loop("name='tie' type='pin'", "coupler", "coupler")),
              HasSubstr("r.urdf:9: error: loop 'tie': has both frames on link 'coupler'"));
  EXPECT_THAT(find_complaint(make_loop("name='tie' type='pin'", "coupler", "rocker", "0.5 zero 0")),
              HasSubstr("loop 'tie' <origin>: xyz is '0.5 zero 0', expected 3 finite numbers [m]"));
  EXPECT_THAT(find_complaint("<loop name='tie' type='pin'><frame_a link='coupler'/></loop>"),
              HasSubstr("has no <frame_b link=\"...\">"));
  EXPECT_THAT(find_complaint("<loop name='tie' type='pin'><parent link='coupler'/></loop>"),
              HasSubstr("<parent>: is unknown here"));
  EXPECT_THAT(find_complaint(make_loop() + make_loop()), HasSubstr("stands here again; first in line 9"));
}

TEST(LoopScan, TwoLinksThatAreFixedToEachOtherAreOne) {
  const std::string tip =
      make_bar("tip") + "<joint name='weld' type='fixed'><parent link='coupler'/><child link='tip'/></joint>\n";
  EXPECT_THAT(find_complaint(tip + make_loop("name='tie' type='pin'", "coupler", "tip")),
              HasSubstr("r.urdf:11: error: loop 'tie': both ends are on the same moving link, 'coupler'"));
}

TEST(LoopScan, AnOpenLoopSaysByHowMuchAndWhatToDo) {
  // Zero pose: coupler's end at 0.2 + 0.5, rocker's at 0.5 + 0.3 m.
  const std::string driven = make_tree(true) + make_loop();
  try {
    parse(driven, "initial: {joints: {drive: 0}}\n");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("r.urdf:9: error: loop 'tie': is open by 100 mm and 0 mrad in the start pose and by 100 mm"));
    EXPECT_THAT(error.what(),
                HasSubstr("no joint may move to close it: mark those that no motor drives with <unactuated/>"));
  }
  // A coupler of 5 cm reaches nowhere.
  EXPECT_THAT(find_complaint(make_loop("name='tie' type='pin'", "coupler", "rocker", "0.05 0 0"),
                             "initial: {joints: {drive: 3.1}}\n"),
              HasSubstr("moving the passive joints (elbow, swing) does not close it"));
}

TEST(LoopScan, GivenPositionsOfPassiveJointsStay) {
  EXPECT_THAT(find_complaint(make_loop(), "initial: {joints: {drive: -1.2, elbow: 0, swing: 0}}\n"),
              HasSubstr("no joint may move to close it"));
}

TEST(LoopScan, LoopsOfDescriptionAndScenarioStandSideBySideUnlessTheyShareAName) {
  const std::string own =
      "initial: {joints: {drive: -1.2}}\nloops:\n  NAME: {kind: ball, link_a: coupler, xyz_a: [0.5, 0, 0], link_b: "
      "rocker, xyz_b: [0.3, 0, 0]}\n";
  std::string other = own, same = own;
  other.replace(own.find("NAME"), 4, "second");
  same.replace(own.find("NAME"), 4, "tie");
  const Scenario merged = read_merged(parse(make_tree() + make_loop(), other));
  ASSERT_EQ(merged.loops.size(), 2u);
  EXPECT_THAT(
      find_complaint(make_loop(), same),
      HasSubstr("s.yaml:6:8: error: loops.tie: the robot's description has a loop of this name, too (r.urdf:9)"));
}

TEST(LoopScan, WithoutLoopsTheScenarioStaysAsItWas) {
  const RobotDescription robot = parse(make_tree(), "initial: {joints: {drive: -1.2}}\n");
  EXPECT_TRUE(read_merged(robot).loops.empty());
  EXPECT_EQ(robot.scenario.find("loops"), std::string::npos);
}

}  // namespace
}  // namespace hrp
