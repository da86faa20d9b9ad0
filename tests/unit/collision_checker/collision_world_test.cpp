// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/collision_world.h"

#include <unistd.h>

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "servers/collision_checker/sole_contact.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kModels = source_dir() + "/models/";

struct Case {
  Scenario scenario;
  RobotDescription robot;
};

Case make_setup(const std::string& urdf, const std::string& more) {
  Case c;
  c.scenario = parse_scenario("robot: " + kModels + urdf + "\n" + more, kModels + "test.yaml");
  c.robot = load_robot(c.scenario);
  return c;
}

Case load_setup(const std::string& scenario, const std::string& more = "") {
  Case c;
  c.scenario = load_scenario(kModels + "scenarios/" + scenario);
  c.scenario = parse_scenario(c.scenario.text + more, c.scenario.path);
  c.robot = load_robot(c.scenario);
  return c;
}

// A box of 0.4 x 0.3 x 0.2 m as its own sole.
Case make_box(const std::string& more = "") { return make_setup("test_robots/box.urdf", "feet: [box]\n" + more); }

TEST(CollisionWorld, BoxAtStartTouchesTheGroundWithNothing) {
  const Case s = make_box();
  CollisionWorld world(s.robot, s.scenario);
  EXPECT_NEAR(world.start_state().p_WB.z(), 0.1, 1e-15);
}

TEST(CollisionWorld, BoxTouchesWithItsFourCornersAtTheirDepths) {
  const Case s = make_box();
  CollisionWorld world(s.robot, s.scenario);
  State state = world.start_state();
  state.p_WB.z() -= 0.002;
  const ContactSet& contacts = world.calc_contacts(state);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].body_b, kGround);
  ASSERT_EQ(contacts[0].points.size(), 4u);
  for (const ContactPoint& point : contacts[0].points) {
    EXPECT_NEAR(point.depth, 0.002, 1e-15);
    EXPECT_NEAR(point.p_WC.z(), -0.001, 1e-15) << "half way into the penetration";
    EXPECT_NEAR(std::abs(point.p_WC.x()), 0.2, 1e-15);
    EXPECT_NEAR(std::abs(point.p_WC.y()), 0.15, 1e-15);
  }
  EXPECT_NEAR(contacts[0].separation.z(), 0.002, 1e-15);
  EXPECT_NEAR(contacts[0].separation_turn.norm(), 0.0, 1e-12);
}

TEST(CollisionWorld, SeparatingTurnLevelsATiltedBox) {
  const Case s = make_box();
  CollisionWorld world(s.robot, s.scenario);
  State state = world.start_state();
  state.p_WB.z() -= 0.01;
  state.R_WB = Eigen::Quaterniond(make_rotation_from_rpy({0.02, -0.01, 0.3}));
  const ContactSet& contacts = world.calc_contacts(state);
  ASSERT_EQ(contacts.size(), 1u);
  const Matrix3d turn = Eigen::AngleAxisd(contacts[0].separation_turn.norm(), contacts[0].separation_turn.normalized())
                            .toRotationMatrix();
  // The turn is exact to first order: what is left is of the order of the angle cubed (0.022^3 = 1e-5).
  EXPECT_NEAR((turn * state.R_WB.toRotationMatrix() * Vector3d::UnitZ()).z(), 1.0, 1e-9);
}

TEST(CollisionWorld, SlopedGroundTurnsTheNormal) {
  const Case s = make_box("ground: {height: 0.5, roll: 0.05, pitch: -0.1}\ninitial: {rpy: [0.05, -0.1, 0]}\n");
  CollisionWorld world(s.robot, s.scenario);
  State state = world.start_state();
  const Vector3d n = make_rotation_from_rpy({0.05, -0.1, 0.0}).col(2);
  state.p_WB -= 0.003 * n;
  const ContactSet& contacts = world.calc_contacts(state);
  ASSERT_EQ(contacts.size(), 1u);
  ASSERT_EQ(contacts[0].points.size(), 4u);
  for (const ContactPoint& point : contacts[0].points) {
    EXPECT_TRUE(point.n_BA_W.isApprox(n, 1e-12));
    EXPECT_NEAR(point.depth, 0.003, 1e-12);
  }
}

// A robot that falls lies on the ground: what else than its soles comes near it touches it.
TEST(CollisionWorld, AStandingRobotTouchesTheGroundWithItsSolesAlone) {
  for (const char* name : {"default.yaml", "hrp2p_stand.yaml", "hrp1s_stand.yaml"}) {
    const Case all = load_setup(name);
    Case feet = all;
    feet.scenario.ground.all_touch = false;
    CollisionWorld world(all.robot, all.scenario), soles(feet.robot, feet.scenario);
    State state = world.start_state();
    state.p_WB.z() -= 1e-4;
    const ContactSet &a = world.calc_contacts(state), &b = soles.calc_contacts(state);
    ASSERT_EQ(a.size(), b.size()) << name;
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].body_a, b[i].body_a) << name;
      ASSERT_EQ(a[i].points.size(), b[i].points.size());
      for (size_t k = 0; k < a[i].points.size(); ++k) EXPECT_EQ(a[i].points[k].p_WC, b[i].points[k].p_WC) << name;
    }
  }
}

TEST(CollisionWorld, ALyingRobotTouchesTheGroundWithItsTrunkUnlessFeetAloneMay) {
  for (const bool all : {true, false}) {
    Case s = load_setup("hrp2p_stand.yaml");
    s.scenario.ground.all_touch = all;
    CollisionWorld world(s.robot, s.scenario);
    State state = world.start_state();
    state.R_WB = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY());  // on its face
    state.p_WB.z() = 0.05;
    bool trunk = false, ordered = true;
    const ContactSet& contacts = world.calc_contacts(state);
    for (size_t i = 0; i < contacts.size(); ++i) {
      trunk = trunk || (contacts[i].body_b == kGround && contacts[i].body_a == 0);
      if (i > 0) ordered = ordered && contacts[i - 1].body_a < contacts[i].body_a;
    }
    EXPECT_EQ(trunk, all);
    EXPECT_TRUE(ordered) << "one pair a link";
  }
}

TEST(CollisionWorld, NormalsPointFromTheObstacleTowardsTheRobot) {
  for (const char* shape :
       {"shape: box, size: [1, 1, 1]", "shape: sphere, radius: 0.5", "shape: cylinder, radius: 0.5, length: 1"}) {
    const Case s = make_box(std::string("ground: {type: none}\nobstacles: {thing: {") + shape +
                            ", position: [0, 0, -0.5], friction: 0.3}}\n");
    CollisionWorld world(s.robot, s.scenario);
    State state = world.start_state();
    state.p_WB = {0.0, 0.0, 0.1 - 0.002};
    const ContactSet& contacts = world.calc_contacts(state);
    ASSERT_EQ(contacts.size(), 1u) << shape;
    EXPECT_EQ(contacts[0].body_b, make_obstacle_index(0));
    EXPECT_EQ(contacts[0].friction, 0.3);
    for (const ContactPoint& point : contacts[0].points) {
      EXPECT_GT(point.n_BA_W.z(), 0.99) << shape;
      EXPECT_NEAR(point.depth, 0.002, 1e-5) << shape << ": FCL's iterative pairs stop at 1e-6";
    }
  }
}

TEST(CollisionWorld, HalfSittingRobotsStandOnTwoSolesWithoutTouchingThemselves) {
  for (const char* name : {"hrp2p_stand.yaml", "hrp1s_stand.yaml"}) {
    const Case s = load_setup(name, "self_collision: true\n");
    CollisionWorld world(s.robot, s.scenario);
    State state = world.start_state();
    // The lowest point touches the ground to rounding (positions below 2 m: 4e-16), and nothing else touches anything.
    for (const ContactPair& pair : world.calc_contacts(state)) {
      EXPECT_EQ(pair.body_b, kGround);
      for (const ContactPoint& point : pair.points) EXPECT_LT(point.depth, 1e-14);
    }
    state.p_WB.z() -= 1e-3;
    const ContactSet& contacts = world.calc_contacts(state);
    ASSERT_EQ(contacts.size(), 2u);
    for (const ContactPair& pair : contacts) EXPECT_EQ(pair.points.size(), 4u);
    // Links of one hip or shoulder, whose axes meet in a point; nothing else overlaps.
    for (const auto& [a, b] : world.excluded_pairs()) {
      EXPECT_EQ(a.substr(0, 5), b.substr(0, 5)) << name << ": " << a << " overlaps " << b;
    }
  }
}

TEST(CollisionWorld, ArmsThatCrossTheTrunkCollide) {
  const Case s = load_setup("hrp2p_stand.yaml", "self_collision: true\n");
  CollisionWorld world(s.robot, s.scenario);
  State state = world.start_state();
  state.q[s.robot.tree.find_joint("L_SHOULDER_R")] = -0.9;
  bool found = false;
  for (const ContactPair& pair : world.calc_contacts(state)) {
    if (pair.body_b >= 0) found = true;
    EXPECT_TRUE(pair.body_b < 0 || pair.body_a < pair.body_b);
  }
  EXPECT_TRUE(found);
}

TEST(CollisionWorld, EqualStatesGiveEqualBitsAndOrder) {
  const Case s = load_setup("hrp2p_stand.yaml", "self_collision: true\n");
  CollisionWorld a(s.robot, s.scenario), b(s.robot, s.scenario);
  State state = a.start_state();
  state.p_WB.z() -= 1e-3;
  State other = state;
  other.R_WB = Eigen::Quaterniond(make_rotation_from_rpy({0.3, 0.2, 0.1}));
  b.calc_contacts(other);  // a past must not matter
  const ContactSet& ca = a.calc_contacts(state);
  const ContactSet& cb = b.calc_contacts(state);
  ASSERT_EQ(ca.size(), cb.size());
  for (size_t i = 0; i < ca.size(); ++i) {
    ASSERT_EQ(ca[i].points.size(), cb[i].points.size());
    EXPECT_EQ(ca[i].separation, cb[i].separation);
    for (size_t k = 0; k < ca[i].points.size(); ++k) EXPECT_EQ(ca[i].points[k].p_WC, cb[i].points[k].p_WC);
  }
}

TEST(CollisionWorld, StatesThatAreNotFiniteTouchNothing) {
  const Case s = make_box();
  CollisionWorld world(s.robot, s.scenario);
  State state = world.start_state();
  state.p_WB.z() = std::nan("");
  EXPECT_TRUE(world.calc_contacts(state).empty());
  state = world.start_state();
  state.q.resize(3);
  EXPECT_TRUE(world.calc_contacts(state).empty());
}

TEST(SoleContact, ReductionKeepsTheCornersOfTheSupportPolygon) {
  std::vector<ContactPoint> points;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) points.push_back({Vector3d(0.05 * i, 0.03 * j, 0), Vector3d::UnitZ(), 1e-3});
  }
  reduce_points(Matrix3d::Identity(), Vector3d::UnitZ(), 4, &points);
  ASSERT_EQ(points.size(), 4u);
  for (const ContactPoint& point : points) {
    EXPECT_TRUE(point.p_WC.x() == 0.0 || std::abs(point.p_WC.x() - 0.2) < 1e-12);
    EXPECT_TRUE(point.p_WC.y() == 0.0 || std::abs(point.p_WC.y() - 0.12) < 1e-12);
  }
}

TEST(SoleContact, CylinderRollsOnItsLowestLine) {
  Sole sole;
  for (double y : {-0.1, 0.1}) sole.rims.push_back({Vector3d(0, y, 0), Vector3d::UnitY(), 0.05});
  for (double angle : {0.0, 0.3, 1.0, 2.0}) {
    ContactPair pair;
    const Transform X_WL{make_rotation_from_rpy({0, angle, 0}), {0, 0, 0.049}};
    ASSERT_TRUE(calc_sole_contact(sole, X_WL, GroundPlane(), 4, &pair));
    ASSERT_EQ(pair.points.size(), 2u);
    for (const ContactPoint& point : pair.points) EXPECT_NEAR(point.depth, 1e-3, 1e-12) << angle;
  }
}

// ---- what never touches -------------------------------------------------------------------------------------------

// Bodies that the box touches where it stands: 5 mm in the ground, in a table and in a field.
std::vector<int> touch_all(const std::string& no_contact) {
  const std::string path = testing::TempDir() + "/no_contact_" + std::to_string(getpid()) + ".csv";
  std::ofstream(path) << "0,0\n0,0\n";
  const Case s = make_box(
      "initial: {position: [0, 0, 0.095]}\nobstacles:\n"
      "  table: {size: [1, 1, 0.1], position: [0, 0, -0.05]}\n"
      "  land: {shape: height_field, spacing: 4, file: " +
      path + "}\n" + no_contact);
  CollisionWorld world(s.robot, s.scenario);
  std::vector<int> touched;
  for (const ContactPair& pair : world.calc_contacts(world.start_state())) touched.push_back(pair.body_b);
  return touched;
}

TEST(NoContact, WhatIsNamedNeverTouches) {
  constexpr int kTable = -2, kLand = -3;
  EXPECT_THAT(touch_all(""), ElementsAre(kLand, kTable, kGround));
  EXPECT_THAT(touch_all("no_contact: {box: [table]}"), ElementsAre(kLand, kGround));
  EXPECT_THAT(touch_all("no_contact: {land: [box], ground: [box]}"), ElementsAre(kTable));
  EXPECT_THAT(touch_all("no_contact: {table: [all]}"), ElementsAre(kLand, kGround));
  EXPECT_THAT(touch_all("no_contact: {box: [all]}"), ElementsAre());
}

TEST(NoContact, ArmsThatCrossTheTrunkPassThroughIt) {
  const Case s = load_setup("hrp2p_stand.yaml", "self_collision: true\nno_contact: {all: [all]}\n");
  CollisionWorld world(s.robot, s.scenario);
  State state = world.start_state();
  state.q[s.robot.tree.find_joint("L_SHOULDER_R")] = -0.9;
  EXPECT_TRUE(world.calc_contacts(state).empty());
}

TEST(NoContact, NamesThatAreNobodyAreRefusedWithTheirPlace) {
  try {
    make_box("no_contact:\n  box: [tabl]\nobstacles: {table: {size: [1, 1, 1]}}\n");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(":4:9: error: no_contact.box[0]: the robot has no link, and the scenario no "
                                        "obstacle 'tabl'; did you mean 'table'?"));
  }
}

}  // namespace
}  // namespace hrp
