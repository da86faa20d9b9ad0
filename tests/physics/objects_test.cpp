// SPDX-License-Identifier: BSD-3-Clause
// Movable objects: friction, momentum, weight, and the same bits again.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/physics/run_trial.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

const std::string kModels = source_dir() + "/models/";
constexpr double kGravity = 9.81;

// Beside a pendulum that hangs far away.
Trial make_trial(const std::string& yaml) {
  return Trial(parse_scenario("robot: " + kModels +
                                  "test_robots/pendulum.urdf\nbase: fixed\ncontroller: {type: hold}\n"
                                  "initial: {position: [0, 50, 50]}\nservo: {default: {kp: 10, kd: 1}}\n" +
                                  yaml,
                              kModels + "scenarios/s.yaml"));
}

// [N] vertical, of all that touches the ground.
double sum_on_ground(const Trial& trial) {
  double sum = 0.0;
  for (const PairForce& pair : trial.engine().contact_forces()) {
    if (pair.body_b == kGround) sum += pair.total[5];
  }
  return sum;
}

TEST(Objects, ABoxSlidesDownASlopeWithCoulombsAcceleration) {
  constexpr double kSlope = 0.3, kFriction = 0.2;
  Trial trial = make_trial(
      "ground: {pitch: 0.3, friction: 0.9}\nobjects: {box: {size: [0.3, 0.2, 0.1], mass: 4, friction: 0.2, "
      "position: [" +
      std::to_string(0.05 * std::sin(kSlope)) + ", 0, " + std::to_string(0.05 * std::cos(kSlope)) +
      "], rpy: [0, 0.3, 0]}}\n");
  const Vector3d down(std::cos(kSlope), 0, -std::sin(kSlope));
  run(&trial, 0.5);
  const double v = down.dot(trial.engine().objects()[0].V_WB.tail<3>());
  run(&trial, 0.5);
  const double acceleration = (down.dot(trial.engine().objects()[0].V_WB.tail<3>()) - v) / 0.5;
  // The regularised friction of the law is short of Coulomb's by the spring's last micrometre.
  EXPECT_NEAR(acceleration, kGravity * (std::sin(kSlope) - kFriction * std::cos(kSlope)), 0.01);
}

TEST(Objects, ABoxSticksBelowTheAngleOfFriction) {
  Trial trial = make_trial(
      "ground: {pitch: 0.3, friction: 0.5}\nobjects: {box: {size: [0.3, 0.2, 0.1], mass: 4, position: [0.0148, 0, "
      "0.0478], rpy: [0, 0.3, 0]}}\n");
  run(&trial, 0.5);
  const Vector3d p = trial.engine().objects()[0].p_WB;
  run(&trial, 1.0);
  EXPECT_LT((trial.engine().objects()[0].p_WB - p).norm(), 1e-6);
}

TEST(Objects, TwoBoxesThatCollideKeepTheirMomentum) {
  Trial trial = make_trial(
      "gravity: [0, 0, 0]\nground: {type: none}\nobjects:\n"
      "  a: {size: [0.2, 0.2, 0.2], mass: 2, position: [0, 0, 0], velocity: [1, 0, 0], angular_velocity: [0, 0, 0.4]}\n"
      "  b: {size: [0.2, 0.2, 0.2], mass: 3, position: [0.4, 0.05, 0]}\n");
  const auto find_momentum = [&] {
    const ObjectStates& o = trial.engine().objects();
    return Vector3d(2.0 * o[0].V_WB.tail<3>() + 3.0 * o[1].V_WB.tail<3>());
  };
  run(&trial, 1.0);
  EXPECT_LT((find_momentum() - Vector3d(2, 0, 0)).norm(), 1e-12);
  EXPECT_GT(trial.engine().objects()[1].V_WB[3], 0.2) << "it was hit";
  EXPECT_LT(trial.engine().objects()[0].V_WB[3], trial.engine().objects()[1].V_WB[3]) << "and they part";
}

const std::string kFreeBoxes =
    "gravity: [0, 0, 0]\nground: {type: none}\nobjects:\n"
    "  a: {size: [0.2, 0.2, 0.2], mass: 2, position: [0, 0, 0]}\n  b: {size: [0.2, 0.2, 0.2], mass: 3, position: [5, "
    "0, 0]}\n";

TEST(Objects, APushedObjectGainsForceTimesTime) {
  Trial trial = make_trial(kFreeBoxes);
  trial.push("b", Vector3d::Zero(), {0, 6, 0}, 250);
  run(&trial, 1.0);
  const ObjectStates& objects = trial.engine().objects();
  EXPECT_NEAR(objects[1].V_WB[4], 6.0 * 0.25 / 3.0, 1e-12);
  EXPECT_EQ(objects[0].V_WB.norm(), 0.0) << "only the pushed one moves";
  EXPECT_TRUE(trial.engine().pushes().empty()) << "it is over";
  trial.push("b", {0.1, 0, 0}, {0, 0, 1}, 100);
  run(&trial, 0.1);
  ASSERT_EQ(trial.engine().pushes().size(), 1u);
  EXPECT_EQ(trial.engine().pushes()[0].link, "b");
  EXPECT_LT(objects[1].V_WB[1], -0.1) << "beside its middle: it turns";
}

TEST(Objects, APushOfTheScenarioOnAnObjectIsTheSameToTheBit) {
  Trial live = make_trial(kFreeBoxes),
        written = make_trial(kFreeBoxes + "pushes: {shove: {link: b, force: [0, 6, 0], start: 0, duration: 0.25}}\n");
  live.push("b", Vector3d::Zero(), {0, 6, 0}, 250);
  run(&live, 0.5);
  run(&written, 0.5);
  EXPECT_EQ(live.engine().state_hash(), written.engine().state_hash());
}

TEST(Objects, APushOnNothingIsRefused) {
  EXPECT_THROW(make_trial(kFreeBoxes + "pushes: {shove: {link: c, force: [0, 6, 0], duration: 0.25}}\n"), InputError);
  Trial trial = make_trial(kFreeBoxes);
  EXPECT_THROW(trial.push("c", Vector3d::Zero(), {0, 6, 0}, 250), InputError);
}

TEST(Objects, AStackStandsAndTheLowestCarriesAll) {
  Trial trial = make_trial(
      "objects:\n  low: {size: [0.4, 0.4, 0.2], mass: 8, position: [0, 0, 0.1]}\n"
      "  middle: {size: [0.3, 0.3, 0.2], mass: 4, position: [0, 0.02, 0.3]}\n"
      "  top: {size: [0.2, 0.1, 0.2], mass: 2, position: [0.03, 0, 0.5]}\n");
  run(&trial, 2.0);
  const ObjectStates& objects = trial.engine().objects();
  for (size_t k = 0; k < 3; ++k) {
    // Between objects contacts are soft, half a millimetre here: they act explicitly.
    EXPECT_NEAR(objects[k].p_WB.z(), 0.1 + 0.2 * static_cast<double>(k), 2e-3) << k;
    EXPECT_LT(objects[k].V_WB.norm(), 1e-3) << k;
  }
  EXPECT_NEAR(sum_on_ground(trial), 14.0 * kGravity, 0.01 * 14.0 * kGravity);
}

// Two cylinders on a box: until 2026-11-29 each touched in one point, and chattered.
TEST(Objects, CylindersStandOnABoxAndOnEachOther) {
  Trial trial = make_trial(
      "objects:\n  table: {size: [0.6, 0.6, 0.2], mass: 20, position: [0, 0, 0.1]}\n"
      "  can: {shape: cylinder, radius: 0.05, length: 0.2, mass: 2, position: [0.1, 0, 0.3]}\n"
      "  cup: {shape: cylinder, radius: 0.04, length: 0.1, mass: 0.5, position: [0.1, 0, 0.45]}\n");
  run(&trial, 2.0);
  const ObjectStates& objects = trial.engine().objects();
  EXPECT_NEAR(objects[1].p_WB.z(), 0.3, 2e-3) << "contacts between objects are soft, as in a stack of boxes";
  EXPECT_NEAR(objects[2].p_WB.z(), 0.45, 3e-3);
  for (const State& object : objects) {
    EXPECT_LT(object.V_WB.tail<3>().norm(), 1e-3);
    EXPECT_LT(object.V_WB.head<3>().norm(), 1e-2);
  }
  EXPECT_NEAR(sum_on_ground(trial), 22.5 * kGravity, 0.01 * 22.5 * kGravity);
}

TEST(Objects, ARobotPushesWhatStandsInItsWay) {
  Trial trial(load_scenario(kModels + "scenarios/push_box.yaml"));
  const TrialResult result = trial.run();
  EXPECT_EQ(result.fault, "");
  const ObjectStates& objects = trial.engine().objects();
  EXPECT_GT(result.travelled.x(), 0.2);
  EXPECT_GT(objects[0].p_WB.x(), 0.6) << "the crate was pushed";
  EXPECT_GT(objects[1].p_WB.z(), 0.24) << "the parcel stayed on it";
  EXPECT_GT(objects[2].p_WB.x(), 1.15) << "and the ball rolled off";
}

TEST(Objects, ARunThatIsRestoredGoesOnWithTheSameBits) {
  Trial trial(load_scenario(kModels + "scenarios/push_box.yaml"));
  run(&trial, 0.9);
  const unsigned long long hash = expect_same_bits_when_restored(&trial, 0.5);
  trial.reset();
  run(&trial, 1.4);
  EXPECT_EQ(trial.engine().state_hash(), hash);
}

TEST(Objects, NoContactLeavesObjectsAlone) {
  Trial trial = make_trial(
      "no_contact: {ghost: [all]}\nobjects: {ghost: {shape: sphere, radius: 0.1, mass: 1, position: [0, 0, 0.2]}}\n");
  run(&trial, 0.5);
  EXPECT_NEAR(trial.engine().objects()[0].p_WB.z(), 0.2 - 0.5 * kGravity * 0.25, 0.005)
      << "it falls through the ground";
}

}  // namespace
}  // namespace hrp
