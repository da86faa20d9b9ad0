// SPDX-License-Identifier: BSD-3-Clause
// A leg on a rail whose foot is held and whose foot force is measured: what its joints hide is found from the equations
// of motion, with an unknown force on the rail and the height not recorded.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/held_feet/foot_give.h"
#include "diagnosis/held_feet/held_feet.h"

namespace hrp::diagnosis::held_feet {
namespace {

LinkSpec make_link(const std::string& name, int parent, JointKind kind, const Vector3d& axis, const Vector3d& p,
                   double mass) {
  LinkSpec link;
  link.name = name;
  link.parent = parent;
  link.inertia.mass = mass;
  link.inertia.p_LLcm_L = Vector3d(0, 0, -0.1);
  link.inertia.I_LLcm_L = mass * 2e-3 * Matrix3d::Identity();
  link.joint.name = "j_" + name;
  link.joint.kind = kind;
  link.joint.axis_F = axis;
  link.joint.X_PF.p = p;
  return link;
}

Experiment make_leg() {
  Experiment e;
  e.scenario.floating_base = false;
  TreeSpec& tree = e.robot.tree;
  tree.name = "leg";
  tree.floating_base = false;
  LinkSpec world;
  world.name = "world";
  world.inertia.mass = 1.0;
  world.inertia.I_LLcm_L = Matrix3d::Identity();
  tree.links = {world, make_link("slider", 0, JointKind::kPrismatic, Vector3d::UnitZ(), Vector3d::Zero(), 0.5),
                make_link("thigh", 1, JointKind::kRevolute, Vector3d::UnitY(), Vector3d::Zero(), 0.3),
                make_link("shank", 2, JointKind::kRevolute, Vector3d::UnitY(), Vector3d(0, 0, -0.2), 0.1)};
  tree.links[1].joint.actuated = false;
  tree.frames = {{"foot", 3, {Matrix3d::Identity(), Vector3d(0, 0, -0.2)}}};
  WrenchSpec sensor;
  sensor.name = "floor";
  sensor.link = "foot";
  e.scenario.sensors.wrenches = {sensor};
  e.keys.wrench_frame["floor"] = "world";
  e.sample_time = 0.002;
  e.joint_noise.assign(3, std::vector<Noise>(kQuantities, {1e-5, false}));
  return e;
}

// The knee's effort is logged as 1 / scale of the true torque; friction of `level` acts in it.
void add_recording(double scale, double level, unsigned seed, Experiment* e) {
  Recording r;
  r.spec.name = "held";
  r.spec.train = seed == 1;
  r.spec.feet_attached = {"foot"};
  r.spec.unknown_force = {"j_slider"};
  r.joints.resize(3);
  Model model(e->robot.tree);
  Data data(model);
  State state = make_state(model);
  Eigen::VectorXd vdot(3), tau(3);
  LinkWrenches wrenches(4, Vector6d::Zero());
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  for (int k = 0; k < 6000; ++k) {  // 12 s at 500 Hz
    const double t = 0.002 * k, w = seed == 1 ? 2.0 : 3.0, b = 0.8 + 0.4 * std::sin(w * t),
                 bd = 0.4 * w * std::cos(w * t), bdd = -0.4 * w * w * std::sin(w * t);
    state.q << 0.4 * std::cos(b), b, -2 * b, state.qd << -0.4 * std::sin(b) * bd, bd, -2 * bd;
    vdot << -0.4 * (std::cos(b) * bd * bd + std::sin(b) * bdd), bdd, -2 * bdd;
    update_kinematics(model, state, &data);
    const Vector3d force(2 * std::sin(1.3 * t), 0.5, 12 + 6 * std::sin(0.7 * t)),
        p_WF = get_pose(data, 3) * Vector3d(0, 0, -0.2);
    Vector6d F;
    F << Vector3d::Zero(), force;
    wrenches[3] = calc_wrench_about_origin(data, 3, p_WF, F);
    calc_inverse_dynamics(model, vdot, &wrenches, &data, &tau);
    tau(2) = (tau(2) + level * (state.qd(2) > 0 ? 1 : -1)) / scale;
    r.time.push_back(t);
    for (int j = 1; j < 3; ++j) {
      r.joints[static_cast<size_t>(j)].signal[0].push_back(state.q(j) + 1e-5 * noise(random));
      r.joints[static_cast<size_t>(j)].signal[2].push_back(tau(j) + 0.01 * noise(random));
    }
    const char* const axes[] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i)
      r.other[std::string("/wrench/floor/force/") + axes[i]].push_back(force[i] + 0.05 * noise(random));
  }
  e->recordings.push_back(r);
}

Json diagnose_leg(double scale, double level) {
  Experiment e = make_leg();
  for (unsigned seed : {1u, 2u}) add_recording(scale, level, seed, &e);
  Reports reports;
  std::string why;
  EXPECT_TRUE(diagnose_held_feet(e, 1, nullptr, &reports, &why)) << why;
  return reports.report;
}

const Json* find_at_knee(const Json& report, const std::string& effect) {
  for (const Json& f : report["findings"]) {
    if (f["effect"] == effect && f["where"] == Json{{"joint", "j_shank"}}) return &f;
  }
  return nullptr;
}

double get_value(const Json& finding, const char* name) { return finding["parameters"][name]["value"].get<double>(); }

// 5 %: the level's column is a sign that the filter rounds off at every reversal.
TEST(HeldFoot, DryFrictionAndTorqueConstantOfTheKneeComeBack) {
  const Json report = diagnose_leg(0.8, 0.15);
  const Json *gain = find_at_knee(report, "torque_constant_error"), *dry = find_at_knee(report, "coulomb_friction");
  ASSERT_TRUE(gain && dry) << report["findings"].dump(1);
  EXPECT_NEAR(get_value(*gain, "scale"), 0.8, 0.05 * 0.2);
  EXPECT_NEAR(get_value(*dry, "level"), 0.15, 0.05 * 0.15);
  for (const Json& f : report["findings"]) EXPECT_EQ(f["where"], (Json{{"joint", "j_shank"}})) << f.dump(1);
}

TEST(HeldFoot, NothingIsFoundWhenNothingIsHidden) {
  const Json report = diagnose_leg(1.0, 0.0);
  EXPECT_TRUE(report["findings"].empty()) << report["findings"].dump(1);
}

// A leg that squats on a free foot with the height of its rail measured; friction and a pull act on the rail.
void add_squat(double compliance, double dry, double pull, unsigned seed, Experiment* e) {
  Recording r;
  r.spec.name = "squat";
  r.spec.train = true;
  r.joints.resize(3);
  Model model(e->robot.tree);
  Data data(model);
  State state = make_state(model);
  Eigen::VectorXd vdot(3), tau(3);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  for (int k = 0; k < 8000; ++k) {  // 16 s at 500 Hz
    const double t = 0.002 * k, w = 2.0 * M_PI * 0.5, b = 0.8 + 0.35 * std::sin(w * t) + 0.05 * std::sin(4.3 * w * t);
    const double bd = 0.35 * w * std::cos(w * t) + 0.05 * 4.3 * w * std::cos(4.3 * w * t),
                 bdd = -0.35 * w * w * std::sin(w * t) - 0.05 * std::pow(4.3 * w, 2) * std::sin(4.3 * w * t);
    state.q << 0.4 * std::cos(b), b, -2 * b, state.qd << -0.4 * std::sin(b) * bd, bd, -2 * bd;
    vdot << -0.4 * (std::cos(b) * bd * bd + std::sin(b) * bdd), bdd, -2 * bdd;
    update_kinematics(model, state, &data);
    calc_inverse_dynamics(model, vdot, nullptr, &data, &tau);
    // The ground carries what the rail's motion takes, its friction and a pull of `pull` upwards.
    const double taken = dry * std::tanh(state.qd(0) / 1e-3) - pull;
    const Vector3d force(0, 0, tau(0) + taken);
    Eigen::MatrixXd J(6, 3);
    calc_frame_jacobian(model, data, 0, J);
    tau -= J.bottomRows(3).transpose() * force;
    r.time.push_back(t);
    for (int j = 0; j < 3; ++j) {
      const double sunk = j == 0 ? -compliance * force.z() : 0.0;
      r.joints[static_cast<size_t>(j)].signal[0].push_back(state.q(j) + sunk + (j == 0 ? 2e-5 : 1e-5) * noise(random));
      if (j > 0) r.joints[static_cast<size_t>(j)].signal[2].push_back(tau(j) + 0.005 * noise(random));
    }
    const char* const axes[] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i)
      r.other[std::string("/wrench/floor/force/") + axes[i]].push_back(force[i] + 0.02 * noise(random));
  }
  e->recordings.push_back(r);
}

Json diagnose_squat(double compliance, double dry, double pull) {
  Experiment e = make_leg();
  e.scenario.feet = {"foot"};
  add_squat(compliance, dry, pull, 3, &e);
  Reports reports;
  std::string why;
  EXPECT_TRUE(diagnose_held_feet(e, 1, nullptr, &reports, &why)) << why;
  return reports.report;
}

const Json* find_effect_at(const Json& report, const std::string& effect, const Json& where) {
  for (const Json& f : report["findings"]) {
    if (f["effect"] == effect && f["where"] == where) return &f;
  }
  return nullptr;
}

TEST(FreeFoot, TheRailsFrictionIsFoundThoughNothingDrivesIt) {
  const Json report = diagnose_squat(0.0, 0.6, 0.0);
  const Json* dry = find_effect_at(report, "coulomb_friction", {{"joint", "j_slider"}});
  ASSERT_TRUE(dry) << report["findings"].dump(1);
  EXPECT_NEAR(get_value(*dry, "level"), 0.6, 0.06);  // the filter rounds off its reversals
}

// The height's fall is read off directly; what the fall adds to accelerations is left out of the simulated squat.
TEST(FreeFoot, AFootThatSinksUnderItsLoadHasAStiffness) {
  const Json report = diagnose_squat(1.0 / 2000.0, 0.0, 0.0);
  const Json* give = find_effect_at(report, "foot_compliance", {{"foot", "foot"}});
  ASSERT_TRUE(give) << report["findings"].dump(1);
  EXPECT_NEAR(get_value(*give, "kz"), 2000.0, 200.0);
}

TEST(FreeFoot, ARigidFootHasNoStiffness) {
  EXPECT_EQ(find_effect_at(diagnose_squat(0.0, 0.0, 0.0), "foot_compliance", {{"foot", "foot"}}), nullptr);
}

}  // namespace
}  // namespace hrp::diagnosis::held_feet
