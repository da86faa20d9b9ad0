// SPDX-License-Identifier: BSD-3-Clause
// Several robots in one world: each moves as it does alone until they touch, and then with opposite forces.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"
#include "common/multibody/tree_mass.h"
#include "common/spatial/gravity.h"
#include "tests/catch_complaint.h"
#include "tests/physics/run_trial.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kModels = source_dir() + "/models/";
const std::string kBox = "robot: " + kModels + "test_robots/box.urdf\nfeet: [box]\n";
const std::string kFree = "gravity: [0, 0, 0]\nground: {type: none}\ncontroller: {type: hold}\n";

class Robots : public ::testing::Test {
 protected:
  Robots() {
    char name[] = "/tmp/hrp-robots-test-XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~Robots() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& yaml) {
    std::ofstream(folder_ + "/" + name) << yaml;
    return folder_ + "/" + name;
  }
  Scenario load(const std::string& yaml) { return load_scenario(write("world.yaml", yaml)); }
  std::string find_refusal(const std::string& yaml) {
    return catch_complaint([&] { Trial trial(load(yaml)); });
  }
  std::string folder_;
};

bool are_equal(const State& a, const State& b) {
  return a.q == b.q && a.qd == b.qd && a.p_WB == b.p_WB && a.V_WB == b.V_WB && a.R_WB.coeffs() == b.R_WB.coeffs();
}

TEST_F(Robots, ThatDoNotTouchMoveToTheBitAsEachDoesAlone) {
  Trial alone(load_scenario(kModels + "scenarios/squat.yaml"));
  Trial together(load(kBox +
                      "initial: {position: [5, 0, 1]}\nground: {friction: 0.8}\ncontroller: {type: hold}\n"
                      "robots: {partner: {scenario: " +
                      kModels + "scenarios/squat.yaml}}\n"));
  Trial box(load(kBox + "initial: {position: [5, 0, 1]}\nground: {friction: 0.8}\ncontroller: {type: hold}\n"));
  for (Trial* trial : {&alone, &together, &box}) run(trial, 1.5);
  ASSERT_EQ(together.engine().objects().size(), 1u);
  EXPECT_TRUE(are_equal(together.engine().objects()[0], alone.engine().state()));
  EXPECT_TRUE(are_equal(together.engine().state(), box.engine().state()));
  EXPECT_GT((alone.engine().state().q - alone.controlled().initial_q).cwiseAbs().maxCoeff(), 0.01) << "it does move";
}

TEST_F(Robots, ThatCollideKeepTheirMomentum) {
  const std::string other = write("other.yaml", kBox + kFree);
  Trial trial(load(kBox + kFree +
                   "pushes: {hand: {link: box, force: [40, 0, 0], start: 0, duration: 0.1}}\n"
                   "robots: {partner: {scenario: " +
                   other + ", position: [0.3, 0.05, 0.02]}}\n"));
  run(&trial, 2.0);
  const double mass = trial.robot().tree.links[0].inertia.mass;
  const State &first = trial.engine().state(), &second = trial.engine().objects()[0];
  // The push gave 4 N s, along x.
  EXPECT_LT((mass * Vector3d(first.V_WB.tail<3>() + second.V_WB.tail<3>()) - Vector3d(4, 0, 0)).norm(), 1e-9);
  EXPECT_GT(second.V_WB[3], 0.1 * 4.0 / mass) << "it was hit";
}

TEST_F(Robots, AScenarioPushesALinkOfAnotherOne) {
  const std::string other = write("other.yaml", kBox + kFree);
  const auto make = [&](const std::string& link) {
    return kBox + kFree + "pushes: {hand: {link: " + link +
           ", force: [40, 0, 0], start: 0, duration: 0.1}}\n"
           "robots: {partner: {scenario: " +
           other + ", position: [3, 0, 0]}}\n";
  };
  Trial trial(load(make("partner/box")));
  run(&trial, 0.2);
  const double mass = trial.robot().tree.links[0].inertia.mass;
  EXPECT_NEAR(mass * trial.engine().objects()[0].V_WB[3], 4.0, 1e-9) << "40 N for 0.1 s";
  EXPECT_EQ(trial.engine().state().V_WB[3], 0.0);
  EXPECT_THAT(find_refusal(make("partner/bax")), HasSubstr("pushes.hand.link"));
  EXPECT_THAT(find_refusal(make("partnr/box")), HasSubstr("partnr/box"));
}

TEST_F(Robots, OneThatItsFeetPutOnTheGroundCannotBePlacedAboveIt) {
  const std::string other = write("other.yaml", kBox + "ground: {friction: 0.8}\ncontroller: {type: hold}\n");
  const std::string refusal = find_refusal(kBox +
                                           "ground: {friction: 0.8}\ncontroller: {type: hold}\n"
                                           "robots: {partner: {scenario: " +
                                           other + ", position: [3, 0, 0.3]}}\n");
  EXPECT_THAT(refusal, HasSubstr("robots.partner.position"));
  EXPECT_THAT(refusal, HasSubstr("initial.position"));
}

// [N m s] About the z axis of the world, of one step: what a robot's contacts give body `name`.
double calc_contact_impulse(const Trial& trial, const BodyNames& names, const std::string& name) {
  double moment = 0.0;
  for (const PairForce& pair : trial.engine().contact_forces()) {
    const double sign = names.get(pair.body_a) == name ? 1.0 : names.get(pair.body_b) == name ? -1.0 : 0.0;
    moment += sign * (pair.total.head<3>() + pair.p_WR.cross(pair.total.tail<3>())).z();
  }
  return moment * trial.scenario().time_step;
}

TEST_F(Robots, ADoorTurnsByTheMomentOfWhatWalksIntoItAndOfItsHinge) {
  Trial trial(load(kBox +
                   "ground: {friction: 0.4}\ninitial: {position: [-0.6, 0.6, 0.1]}\ncontroller: {type: hold}\n"
                   "pushes: {shove: {link: box, force: [80, 0, 0], start: 0, duration: 2}}\n"
                   "robots: {door: {scenario: " +
                   kModels + "scenarios/door.yaml}}\n"));
  const BodyNames names(trial.robot(), trial.scenario());
  double impulse = 0.0;
  for (int i = 0; i < 2000; ++i) {
    ASSERT_TRUE(trial.step()) << trial.fault();
    impulse += calc_contact_impulse(trial, names, "door/panel");
    impulse += trial.engine().other_efforts(0)[0] * trial.scenario().time_step;
  }
  const State& door = trial.engine().objects()[0];
  const double inertia = 1.069 + 20.0 * 0.4 * 0.4;  // [kg m^2] about the hinge
  // Efforts and forces are rounded 2000 times.
  EXPECT_NEAR(inertia * door.qd[0], impulse, 1e-9);
  EXPECT_LT(door.q[0], -0.5) << "it opens, away from the box";
  EXPECT_EQ(door.p_WB, Vector3d::Zero()) << "its frame stays";
}

TEST_F(Robots, TheGroundCarriesTheWeightOfEach) {
  Trial trial(load_scenario(kModels + "scenarios/several_robots.yaml"));
  run(&trial, 0.6);  // nobody walks yet
  std::map<std::string, double> carried;
  const BodyNames names(trial.robot(), trial.scenario());
  for (const PairForce& pair : trial.engine().contact_forces()) {
    const std::string name = names.get(pair.body_a);
    const size_t slash = name.find('/');
    carried[slash == std::string::npos ? "first" : name.substr(0, slash)] += pair.total[5];
  }
  ASSERT_EQ(carried.size(), 3u);
  const auto calc_weight = [](const TreeSpec& tree) { return kGravity * calc_mass(tree); };
  // A tenth: the bodies still swing a little at this time.
  const double first = calc_weight(trial.robot().tree), second = calc_weight(trial.robot().robots[0].description.tree);
  EXPECT_NEAR(carried["first"], first, 0.1 * first);
  EXPECT_NEAR(carried["walker"], second, 0.1 * second);
  EXPECT_NEAR(carried["partner"], second, 0.1 * second);
}

TEST_F(Robots, OneStartsWhereItIsPlacedAndTurned) {
  Trial trial(load_scenario(kModels + "scenarios/several_robots.yaml"));
  const ObjectStates& others = trial.engine().objects();
  ASSERT_EQ(others.size(), 2u);
  EXPECT_EQ(Vector3d(others[0].p_WB.x(), others[0].p_WB.y(), 0), Vector3d(-0.8, 1.0, 0));
  EXPECT_NEAR((others[1].R_WB * Vector3d::UnitX()).x(), -1.0, 1e-9);
  EXPECT_GT(others[1].p_WB.z(), 0.5) << "with its feet on the ground";
}

TEST_F(Robots, WalkStandAndSquatSideBySideToTheEnd) {
  Trial alone(load_scenario(kModels + "scenarios/default.yaml"));
  Trial trial(load_scenario(kModels + "scenarios/several_robots.yaml"));
  run(&alone, 12.0);
  run(&trial, 12.0);
  const ObjectStates& others = trial.engine().objects();
  EXPECT_GT(alone.engine().state().p_WB.x(), 1.0) << "it walks";
  // Sums that begin 0.8 m beside round differently; a walk amplifies that a little.
  EXPECT_LT((others[0].p_WB - alone.engine().state().p_WB - Vector3d(-0.8, 1.0, 0)).norm(), 1e-6);
  for (const State& state : {trial.engine().state(), others[0], others[1]}) {
    EXPECT_GT((state.R_WB * Vector3d::UnitZ()).z(), 0.98) << "upright";
  }
}

TEST_F(Robots, ARunThatIsRestoredGoesOnWithTheSameBits) {
  Trial trial(load_scenario(kModels + "scenarios/several_robots.yaml"));
  run(&trial, 0.2);
  expect_same_bits_when_restored(&trial, 0.2);
}

TEST_F(Robots, NoContactKeepsThemApart) {
  const std::string other = write("other.yaml", kBox + kFree);
  Trial trial(load(kBox + kFree + "no_contact: {partner: [all]}\nrobots: {partner: {scenario: " + other +
                   ", position: [0.05, 0, 0]}}\n"));
  EXPECT_TRUE(trial.calc_contacts().empty());
  run(&trial, 0.1);
  EXPECT_EQ(trial.engine().objects()[0].V_WB, Vector6d(Vector6d::Zero()));
}

TEST_F(Robots, ThatDoNotGoTogetherAreRefusedWithFileAndLine) {
  const auto with = [&](const std::string& yaml) {
    return kBox + kFree + "robots: {partner: {scenario: " + write("other.yaml", yaml) + "}}\n";
  };
  EXPECT_THAT(find_refusal(with(kBox + kFree + "steps: {time_step: 0.0005}\n")),
              AllOf(HasSubstr("world.yaml:6"), HasSubstr("robots.partner.scenario"),
                    HasSubstr("time_step 0.0005 s, expected 0.001 s")));
  EXPECT_THAT(find_refusal(with(kBox + kFree + "steps: {control_period: 0.01}\n")),
              HasSubstr("control_period 0.01 s, expected 0.005 s"));
  EXPECT_THAT(find_refusal(with(kBox + kFree + "robots: {third: {scenario: world.yaml}}\n")),
              HasSubstr("has robots of its own"));
  EXPECT_THAT(find_refusal(with(kBox + kFree + "sensors: {camera: {eye: {link: box}}}\n")),
              HasSubstr("cameras or lidars"));
  EXPECT_THAT(find_refusal(with("robot: nowhere.urdf\n")), AllOf(HasSubstr("other.yaml:1"), HasSubstr("nowhere.urdf")));
  EXPECT_THAT(find_refusal(kBox + kFree + "robots: {partner: {scenario: nowhere.yaml}}\n"),
              HasSubstr("there is no file"));
  EXPECT_THAT(find_refusal(kBox + kFree + "robots: {partner: {position: [0, 0, 0]}}\n"),
              HasSubstr("the scenario file of this robot"));
  EXPECT_THAT(find_refusal(kBox + kFree + "robots: {a/b: {scenario: world.yaml}}\n"),
              HasSubstr("'a/b' is no name of a robot"));
  EXPECT_THAT(find_refusal(kBox + kFree + "robots: {imu: {scenario: world.yaml}}\n"),
              HasSubstr("'imu' begins the topics of sensors"));
  EXPECT_THAT(find_refusal(kBox + kFree + "robots: {box: {scenario: " + write("other.yaml", kBox + kFree) + "}}\n"),
              HasSubstr("has this name, too"));
  EXPECT_THAT(find_refusal(kBox + kFree + "contact: {model: impulse}\nrobots: {a: {scenario: world.yaml}}\n"),
              HasSubstr("do not go with"));
}

}  // namespace
}  // namespace hrp
