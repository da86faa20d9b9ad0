// SPDX-License-Identifier: BSD-3-Clause
// Every effect that the diagnosis tool can name can be written into a scenario and changes what is simulated; effects
// of links and feet against statics and oscillations computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "common/multibody/kinematics.h"
#include "common/multibody/momentum.h"
#include "servers/dynamics/joint_effects.h"
#include "tests/physics/rigs.h"
#include "tests/physics/scenario_robot.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

std::string read_stand() {
  std::ifstream file(source_dir() + "/models/scenarios/hrp2p_stand.yaml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Named {
  const char* effect;
  const char* where;
  const char* parameters;
};

std::ostream& operator<<(std::ostream& out, const Named& named) { return out << named.effect; }

const Named kEffects[] = {
    {"viscous_friction", "{joint: R_KNEE}", "{coefficient: 20}"},
    {"coulomb_friction", "{joint: R_KNEE}",
     "{level: {value: 5, std: 0.1, ci95: [4.8, 5.2], unit: N m}, asymmetry: 0.1}"},
    {"stribeck_friction", "{joint: R_KNEE}", "{coulomb: 5, static: 8, stribeck_velocity: 0.1}"},
    {"load_dependent_friction", "{joint: R_KNEE}", "{ratio: 0.2}"},
    {"backdriving_friction", "{joint: R_KNEE}", "{ratio: 0.4}"},
    {"rotor_inertia", "{joint: R_KNEE}", "{inertia: 0.5}"},
    {"joint_elasticity", "{joint: R_KNEE}", "{stiffness: 8000, damping: 20, rotor_inertia: 0.3}"},
    {"backlash", "{joint: R_KNEE}", "{gap: 0.01}"},
    {"torque_constant_error", "{joint: R_KNEE}", "{scale: 0.9}"},
    {"torque_saturation", "{joint: R_KNEE}", "{limit: 20}"},
    {"velocity_limit", "{joint: R_KNEE}", "{stall_torque: 60, max_speed: 0.1}"},
    {"dead_zone", "{joint: R_KNEE}", "{width: 5}"},
    {"constant_torque", "{joint: R_KNEE}", "{torque: 5}"},
    {"base_tilt", "{}", "{roll: 0.01, pitch: 0.02}"},
    {"gravity_compensation", "{}", "{share: 0.2}"},
    {"actuator_lag", "{joint: R_KNEE}", "{time_constant: 0.005}"},
    {"command_delay", "{joint: R_KNEE}", "{delay: 0.02}"},
    {"parallel_spring", "{joint: R_KNEE}", "{stiffness: 50, rest: 0.1}"},
    {"cogging", "{joint: R_KNEE}", "{amplitude: 3, periods: 40, phase: 0.2}"},
    {"hysteresis", "{joint: R_KNEE}", "{stiffness: 300, yield_angle: 0.01}"},
    {"joint_offset", "{joint: R_KNEE}", "{offset: 0.02}"},
    {"payload", "{link: WAIST_P_LINK}", "{mass: 5, com: [0.1, 0, 0]}"},
    {"mass_error", "{link: WAIST_P_LINK}", "{scale: 1.1}"},
    {"com_error", "{link: WAIST_P_LINK}", "{offset: [0.02, 0, 0]}"},
    {"inertia_error", "{link: WAIST_P_LINK}", "{scale: 3.0}"},
    {"external_force", "{link: WAIST_P_LINK}", "{force: [20, 0, 0]}"},
    {"foot_compliance", "{foot: L_ANKLE_R_LINK}",
     "{kz: 3e5, cz: 800, k_roll: 700, c_roll: 15, k_pitch: 900, c_pitch: 15}"},
    {"foot_hardening", "{foot: L_ANKLE_R_LINK}",
     "{kz: 3e5, cz: 800, k_roll: 700, c_roll: 15, k_pitch: 900, c_pitch: 15, hardening_angle: 0.01}"},
    {"ground_slope", "{}", "{roll: 0.01, pitch: 0.02}"},
    {"ground_friction", "{}", "{coefficient: 0.01}"},
    {"restitution", "{}", "{coefficient: 0.3}"},
    {"sensor_bias", "{sensor: /wrench/left_foot/torque}", "{value: [0, 0.5, 0]}"},
    {"sensor_scale", "{sensor: /wrench/left_foot/force}", "{scale: 1.05}"},
    {"sensor_delay", "{sensor: /wrench/left_foot}", "{delay: 0.012}"},
    {"sensor_misalignment", "{sensor: /imu/chest/linear_acceleration}", "{rpy: [0, 0.03, 0]}"},
    {"clock_skew", "{sensor: left_foot}", "{skew: -0.01}"}};

// Everything that a recording would show, over half a second of shaking knees.
std::vector<double> record(const std::string& yaml) {
  ScenarioRobot run(yaml);
  const int knee = run.robot.tree.find_joint("R_KNEE");
  const Eigen::VectorXd q0 = run.command.q;
  std::vector<double> recorded;
  for (int k = 0; k < 500; ++k) {
    run.command.q = q0;
    run.command.q[knee] += 0.05 * std::sin(0.02 * k);
    EXPECT_EQ(run.step(), StepStatus::kOk) << run.simulator.fault_text();
    if (k % 5 != 4) continue;
    const SensorSample& sensors = run.simulator.sensors();
    recorded.push_back(sensors.q[knee]);
    recorded.push_back(sensors.effort[knee]);
    for (const auto& wrench : sensors.wrenches) {
      for (int i = 0; i < 3; ++i) {
        recorded.push_back(wrench.force[i]);
        recorded.push_back(wrench.torque[i]);
      }
    }
    for (int i = 0; i < 3; ++i) recorded.push_back(sensors.imus[0].linear_acceleration[i]);
  }
  return recorded;
}

class NamedEffect : public ::testing::TestWithParam<Named> {};

TEST_P(NamedEffect, CanBeWrittenIntoAScenarioAndShowsInARecording) {
  const Named& named = GetParam();
  static const std::vector<double> nominal = record(read_stand());
  const std::string yaml = read_stand() + "effects:\n  - {effect: " + named.effect + ", where: " + named.where +
                           ", parameters: " + named.parameters + "}\n";
  const std::vector<double> changed = record(yaml);
  ASSERT_EQ(changed.size(), nominal.size());
  double largest = 0.0;
  for (size_t i = 0; i < nominal.size(); ++i) {
    ASSERT_TRUE(std::isfinite(changed[i]));
    largest = std::max(largest, std::abs(changed[i] - nominal[i]));
  }
  EXPECT_GT(largest, 1e-3) << "rad, N m, N or m/s^2, whichever differs most";
}

INSTANTIATE_TEST_SUITE_P(All, NamedEffect, ::testing::ValuesIn(kEffects),
                         [](const auto& info) { return std::string(info.param.effect); });

TEST(NamedEffects, AreAllThatAScenarioMayState) {
  std::set<std::string> names;
  for (const Named& named : kEffects) names.insert(named.effect);
  for (const EffectInfo& effect : list_effects()) {
    if (!effect.reported) continue;
    EXPECT_EQ(names.count(effect.name), 1u) << effect.name;
  }
}

TEST(NamedEffects, ADelayOfWrenchIsThatOfEveryForceSensor) {
  const std::string delay = ", parameters: {delay: 0.012}}\n", begin = "effects:\n";
  const auto late = [&](const char* path) {
    return std::string("  - {effect: sensor_delay, where: {sensor: ") + path + "}" + delay;
  };
  EXPECT_EQ(record(read_stand() + begin + late("/wrench")),
            record(read_stand() + begin + late("/wrench/left_foot") + late("/wrench/right_foot")));
}

// ---- links ----------------------------------------------------------------------------------------------------------

struct Stood {
  double force = 0.0;    // [N] on both feet
  double lever_x = 0.0;  // [m] centre of pressure
  double friction_x = 0.0;
};

// A standing biped after four seconds, with the world's reaction about the origin.
Stood stand_with(const std::string& link, const StatedEffect& law) {
  rigs::Biped biped = rigs::make_biped();
  Scenario scenario = rigs::make_biped_scenario();
  scenario.servo_default = {2e5, 2e3};  // the statics are those of the rigid pose
  if (!law.effect.empty()) scenario.link_laws[link].push_back(law);
  rigs::CornerFinder finder = rigs::make_finder(biped);
  Simulator simulator(biped.robot, scenario);
  const Model model(simulator.tree());
  const JointCommand command = rigs::make_command(simulator.state());
  for (int k = 0; k < 4000; ++k) {
    EXPECT_EQ(simulator.step(finder.find(model, simulator.state()), command), StepStatus::kOk);
  }
  Stood stood;
  for (const PairForce& pair : simulator.contact_forces()) {
    for (const PointForce& point : pair.points) {
      stood.force += point.total.z();
      stood.lever_x += point.total.z() * point.p_WC.x();
      stood.friction_x += point.total.x();
    }
  }
  stood.lever_x /= stood.force;
  return stood;
}

constexpr double kWeight = 58.0 * 9.81;
// The pose gives a little under servos of 200 kN m/rad: levers move by less than this.
constexpr double kLeverTolerance = 2e-4;  // [m]

TEST(LinkEffects, APayloadWeighsAndMovesTheCentreOfPressure) {
  const Stood nominal = stand_with("", {});
  const Stood loaded = stand_with("body", {"payload", {{"mass", 5.0}, {"com_x", 0.1}, {"com_y", 0}, {"com_z", 0.2}}});
  EXPECT_NEAR(nominal.force, kWeight, 1e-3 * kWeight);
  EXPECT_NEAR(loaded.force, kWeight + 5.0 * 9.81, 1e-3 * kWeight);
  EXPECT_NEAR(loaded.lever_x, (58.0 * nominal.lever_x + 5.0 * 0.1) / 63.0, kLeverTolerance);
}

TEST(LinkEffects, AMassErrorWeighs) {
  const Stood heavy = stand_with("body", {"mass_error", {{"scale", 1.1}}});
  EXPECT_NEAR(heavy.force, kWeight + 0.1 * 42.0 * 9.81, 1e-3 * kWeight);
}

TEST(LinkEffects, ACentreOfMassErrorMovesTheCentreOfPressureByItsShareOfTheMass) {
  const Stood nominal = stand_with("", {}),
              moved = stand_with("body", {"com_error", {{"offset_x", 0.03}, {"offset_y", 0}, {"offset_z", 0}}});
  EXPECT_NEAR(moved.force, kWeight, 1e-3 * kWeight);
  EXPECT_NEAR(moved.lever_x - nominal.lever_x, 42.0 / 58.0 * 0.03, kLeverTolerance);
}

TEST(LinkEffects, AnExternalForceIsHeldByFrictionAndMovesTheCentreOfPressure) {
  const Stood nominal = stand_with("", {}),
              pulled = stand_with("body", {"external_force", {{"force_x", 10}, {"force_y", 0}, {"force_z", 0}}});
  EXPECT_NEAR(pulled.friction_x, -10.0, 0.05);
  const double height = 0.8 + 0.25;  // [m] of the trunk's centre of mass above the soles
  EXPECT_NEAR(pulled.lever_x - nominal.lever_x, 10.0 * height / kWeight, kLeverTolerance);
}

TEST(LinkEffects, OfALinkWithoutAMassOfItsOwnAreRefused) {
  rigs::Biped biped = rigs::make_biped();
  biped.robot.tree.frames.push_back({"camera", 0, Transform{}});
  Scenario scenario = rigs::make_biped_scenario();
  scenario.link_laws["camera"].push_back({"payload", {{"mass", 1.0}, {"com_x", 0}, {"com_y", 0}, {"com_z", 0}}});
  EXPECT_NEAR(Simulator(biped.robot, scenario).tree().links[0].inertia.mass, 43.0, 1e-12) << "a payload may be there";
  scenario.link_laws["camera"].push_back({"mass_error", {{"scale", 1.1}}});
  EXPECT_THROW(Simulator(biped.robot, scenario), InputError);
}

// ---- a bush from the scenario
// -----------------------------------------------------------------------------------------

struct Rocking {
  double period = 0.0;        // [s]
  double force_sensor = 0.0;  // [N] z of both sensors, mean
};

// Free rocking forward and back after a push, of the HRP-2P-like robot with rigid joints on bushes.
Rocking rock(ScenarioRobot* run) {
  std::vector<double> pitch, force;
  for (int k = 0; k < 6000; ++k) {
    ExternalWrenches push(1);
    push[0].F_W[3] = k < 100 ? 30.0 : 0.0;  // [N] for 0.1 s
    EXPECT_EQ(run->step(push), StepStatus::kOk) << run->simulator.fault_text();
    if (k < 200 || k % 5 != 4) continue;
    pitch.push_back(run->simulator.state().R_WB.y());
    const auto& wrenches = run->simulator.sensors().wrenches;
    force.push_back(wrenches[0].force.z() + wrenches[1].force.z());
  }
  Rocking rocking;
  std::vector<double> highs;
  for (size_t i = 1; i + 1 < pitch.size(); ++i) {
    if (pitch[i] > pitch[i - 1] && pitch[i] >= pitch[i + 1]) {
      const double a = pitch[i - 1], b = pitch[i], c = pitch[i + 1];  // top of the parabola through three samples
      highs.push_back(0.005 * (static_cast<double>(i) + 0.5 * (a - c) / (a - 2.0 * b + c)));
    }
  }
  if (highs.size() >= 3) rocking.period = (highs.back() - highs.front()) / static_cast<double>(highs.size() - 1);
  for (double f : force) rocking.force_sensor += f / static_cast<double>(force.size());
  return rocking;
}

TEST(FootBushOfAScenario, RocksAtTheFrequencyComputedByHandWithTheForceSensorAbove) {
  ScenarioRobot run(read_stand() +
                    "perfect_joints: true\nfoot_bush: {default: {kz: 3e5, cz: 2000, k_roll: 900, c_roll: 5, "
                    "k_pitch: 900, c_pitch: 5}}\n");
  const TreeSpec& tree = run.simulator.tree();
  double soles = 0.0;
  Vector3d centre = Vector3d::Zero();
  const Model model(tree);
  Data data(model);
  State unit = run.simulator.state();
  unit.V_WB[1] = 1.0;  // the whole body turns about y
  update_kinematics(model, unit, &data);
  for (const char* sole : {"L_ANKLE_R_LINK_sole", "R_ANKLE_R_LINK_sole"}) {
    ASSERT_GE(tree.find_link(sole), 0);
    soles += tree.links[static_cast<size_t>(tree.find_link(sole))].inertia.mass;
    centre += 0.5 * get_pose(data, tree.find_link(sole)).p;
  }
  const Vector3d r = calc_centre_of_mass(model, data) - centre;
  const double m = model.mass();
  const double inertia = calc_centroidal_momentum(model, data)[1] + m * (r.x() * r.x() + r.z() * r.z());
  const double expected = 2.0 * 3.14159265358979 * std::sqrt(inertia / (2.0 * 900.0 - m * 9.81 * r.z()));
  const Rocking rocking = rock(&run);
  // The soles stand still but are counted with the body, and the vertical springs give a little.
  EXPECT_NEAR(rocking.period / expected, 1.0, 0.02);
  // 1 %: not a whole number of swings. What is below the sensors is more than that.
  EXPECT_GT(soles, 0.02 * m);
  EXPECT_NEAR(rocking.force_sensor, (m - soles) * 9.81, 0.01 * m * 9.81);
}

TEST(FootBushOfAScenario, HardensByTheLaw) {
  RobotDescription robot = rigs::make_body(rigs::make_box_inertia(1e6, {1, 1, 1}));
  rigs::add_link(&robot, "f_bush_roll", 0, Vector3d::Zero(), Vector3d::UnitX(),
                 rigs::make_box_inertia(0.1, {0.1, 0.1, 0.1}));
  JointSpec& joint = robot.tree.joint(0);
  joint.name = "f_bush_roll";
  joint.actuated = false;
  joint.spring.stiffness = 500.0;
  Scenario scenario = rigs::make_scenario();
  scenario.gravity_W.setZero();
  scenario.floating_base = false;
  scenario.time_step = 1e-5;
  scenario.foot_bush["f"].hardening_angle = 0.01;
  scenario.initial_joints["f_bush_roll"] = 0.02;
  Simulator simulator(robot, scenario);
  ASSERT_EQ(simulator.step({}, rigs::make_command(simulator.state())), StepStatus::kOk);
  // -K q (1 + (q / h)^2) = -500 x 0.02 x 5; the step of 10 us moves it by 1e-3 of that.
  EXPECT_NEAR(simulator.joint_efforts()[0], -50.0, 0.5);
}

// ---- clocks
// -----------------------------------------------------------------------------------------------------------

// A sensor whose clock runs behind by 1 % reads at 1 s what was true at 0.99 s; one that runs ahead is right at the
// end.
TEST(ClockSkew, ReadsTheTruthOfAnotherTime) {
  for (double skew : {-0.01, 0.01}) {
    RobotDescription robot = rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1}));
    Scenario scenario = rigs::make_scenario();
    scenario.gravity_W.setZero();
    scenario.duration = 1.0;
    scenario.sensors.imus.push_back({"imu", "body", Vector3d::Zero(), {}, {}});
    scenario.sensors.imus[0].gyro.clock_skew = skew;
    Simulator simulator(robot, scenario);
    std::vector<double> truth, read;
    for (int k = 0; k < 1000; ++k) {
      ExternalWrenches push(1);
      push[0].F_W[0] = 0.001;  // [N m] about x: the rate grows evenly
      ASSERT_EQ(simulator.step({}, rigs::make_command(simulator.state()), push), StepStatus::kOk);
      truth.push_back(simulator.state().V_WB[0]);
      read.push_back(simulator.sensors().imus[0].angular_velocity.x());
    }
    const double slope = truth[999] / 1000.0;  // per step
    EXPECT_NEAR((truth[999] - read[999]) / slope, skew < 0 ? 10.0 : 0.0, 0.05);
    EXPECT_NEAR((truth[499] - read[499]) / slope, 5.0, 0.05);
  }
}

}  // namespace
}  // namespace hrp
