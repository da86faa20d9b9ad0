// SPDX-License-Identifier: BSD-3-Clause
// Terrain made of boxes: a body of the robot on a tilted obstacle, held against Coulomb's law on an incline.
#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "servers/console/trial/trial.h"
#include "tests/physics/scenario_robot.h"

namespace hrp {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2]
constexpr double kHalfHeight = 0.1 + 0.05;  // [m] half of the body's height and of the ramp's

// The box of test_robots on a ramp that descends along x by `slope` [rad].
std::string make_ramp(double slope, double friction) {
  const Vector3d p = kHalfHeight * Vector3d(std::sin(slope), 0.0, std::cos(slope));
  const auto text = [](double x) { return std::to_string(x); };
  return "robot: ../test_robots/box.urdf\nfeet: [box]\nground: {type: none}\n"
         "initial: {position: [" + text(p.x()) + ", 0, " + text(p.z()) + "], rpy: [0, " + text(slope) + ", 0]}\n"
         "contact: {stiffness: 1.0e6, tangential_stiffness: 1.0e6}\n"
         "obstacles: {ramp: {size: [20, 4, 0.1], rpy: [0, " + text(slope) + ", 0], friction: " + text(friction) + "}}\n";
}

struct Slide {
  double speed = 0.0;   // [m/s] down the ramp at the end
  double normal = 0.0;  // [N] of all points, across the ramp, mean of the second half
  double weight = 0.0;  // [N]
};

Slide slide_for_a_second(double slope, double friction) {
  ScenarioRobot robot(make_ramp(slope, friction));
  const Matrix3d R_WR = make_rotation_from_rpy({0.0, slope, 0.0});
  Slide slide;
  for (const LinkSpec& link : robot.robot.tree.links) slide.weight += kGravity * link.inertia.mass;
  Vector3d p_before = robot.simulator.state().p_WB;
  for (int i = 0; i < 1000; ++i) {
    p_before = robot.simulator.state().p_WB;
    EXPECT_EQ(robot.step(), StepStatus::kOk);
    if (i < 500) continue;
    for (const PairForce& pair : robot.simulator.contact_forces()) {
      slide.normal += R_WR.col(2).dot(pair.total.tail<3>()) / 500.0;
    }
  }
  slide.speed = R_WR.col(0).dot(robot.simulator.state().p_WB - p_before) / 1e-3;
  return slide;
}

// Four heights from 2 to 5 mm above the plane, in turn: edges of up to 3 mm that no footstep of the plan knows.
std::string make_plates() {
  std::string text = "obstacles:\n";
  const double heights[] = {0.003, 0.005, 0.002, 0.004};  // [m]
  for (int k = 0; k < 12; ++k) {
    text += "  plate" + std::to_string(k) + ": {size: [0.6, 1.5, 0.02], position: [" + std::to_string(0.6 + 0.6 * k) + ", 0, " +
            std::to_string(heights[k % 4] - 0.01) + "]}\n";
  }
  return text;
}

TrialResult walk_over(const std::string& obstacles) {
  const Scenario flat = load_scenario(std::string(HRP_SOURCE_DIR) + "/models/scenarios/default.yaml");
  return Trial(parse_scenario(flat.text + obstacles, flat.path)).run();
}

TEST(Terrain, ABoxOnAnInclineIsCarriedByItsWeightTimesTheCosine) {
  for (const double slope : {0.1, 0.2, 0.3}) {
    const Slide slide = slide_for_a_second(slope, 0.5);
    // 0.1 %: the box has settled after half a second; 1e6 N/m and 12 kg swing with less than 10 ms.
    EXPECT_NEAR(slide.normal, slide.weight * std::cos(slope), 1e-3 * slide.weight) << slope;
  }
}

TEST(Terrain, ABoxRestsBelowTheFrictionAngle) {
  const double friction = 0.4;
  const Slide slide = slide_for_a_second(std::atan(friction) - 0.03, friction);
  EXPECT_NEAR(slide.speed, 0.0, 1e-4) << "a thousandth of what it would have without friction after 0.03 s";
}

TEST(Terrain, ABoxSlidesAboveTheFrictionAngleWithCoulombsAcceleration) {
  const double friction = 0.4, slope = std::atan(friction) + 0.1;
  const Slide slide = slide_for_a_second(slope, friction);
  const double acceleration = kGravity * (std::sin(slope) - friction * std::cos(slope));
  EXPECT_NEAR(slide.speed, acceleration, 0.02 * acceleration) << "after 1 s; the box first sinks in for milliseconds";
}

TEST(Terrain, TheWalkOfTheDefaultScenarioStaysUprightOverPlatesOfMillimetres) {
  const TrialResult r = walk_over(make_plates());
  EXPECT_FALSE(r.fallen) << r.fault;
  EXPECT_NEAR(r.duration, 12.0, 1e-9) << r.fault;
  EXPECT_NEAR(r.travelled.x(), 1.6, 0.15) << "eight steps of 0.2 m; settling moves the base by some centimetres";
  const TrialResult flat = walk_over("");
  // The last step ends on the edge from 5 mm down to 2 mm.
  EXPECT_GT(r.travelled.z(), flat.travelled.z() + 0.001) << "it stands on plates in the end";
  EXPECT_LT(r.travelled.z(), flat.travelled.z() + 0.006) << "and the highest is 5 mm";
  std::printf("plane: %.3f m forward, %.4f m up, lean %.4f rad\n", flat.travelled.x(), flat.travelled.z(), flat.largest_lean);
  std::printf("plates: %.3f m forward, %.4f m up, lean %.4f rad\n", r.travelled.x(), r.travelled.z(), r.largest_lean);
}

TEST(Terrain, TheWalkOfTheDefaultScenarioClimbsARampOfTwoDegrees) {
  // Rises from x = 0.2 m on: its upper side there is at height 0.
  const TrialResult r = walk_over("obstacles: {ramp: {size: [8, 2, 0.02], position: [4.2, 0, 0.1296], rpy: [0, -0.0349, 0]}}\n");
  EXPECT_FALSE(r.fallen) << r.fault;
  EXPECT_NEAR(r.travelled.z(), 0.0349 * (1.6 - 0.2), 0.005) << "1.6 m of steps, 1.4 m of them on the ramp; feet may stop 0.14 m off";
  std::printf("ramp: %.3f m forward, %.4f m up, lean %.4f rad\n", r.travelled.x(), r.travelled.z(), r.largest_lean);
}

}  // namespace
}  // namespace hrp
