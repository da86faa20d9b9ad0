// SPDX-License-Identifier: BSD-3-Clause
// Claims about robots on their feet: readings are made from the equations of motion of a biped of our own, so that each
// case hides exactly what its name says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "common/spatial/turn.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/measurement/floating/body_units.h"
#include "diagnosis/measurement/floating/checks.h"
#include "diagnosis/measurement/floating/contacts.h"
#include "diagnosis/measurement/floating/least_squares.h"
#include "diagnosis/measurement/floating/correct_log.h"
#include "diagnosis/measurement/floating/diagnose.h"
#include "diagnosis/measurement/floating/landings.h"
#include "diagnosis/measurement/floating/load_share.h"
#include "diagnosis/evidence/torque_findings.h"
#include "diagnosis/measurement/floating/candidate_laws.h"
#include "diagnosis/measurement/floating/regimes.h"
#include "diagnosis/measurement/floating/remaining.h"
#include "diagnosis/measurement/floating/search/search.h"
#include "diagnosis/measurement/floating/sensor_frames.h"
#include "diagnosis/measurement/floating/tracks.h"
#include "diagnosis/many_drives/joint_torques.h"
#include "servers/model_parser/robot_loader.h"
#include "test_places.h"

namespace hrp::diagnosis::floating {
namespace {

std::string make_link(const std::string& name, double mass, double z, const std::string& more = "") {
  const double i = 0.02 * mass;
  return "<link name=\"" + name + "\"><inertial><origin xyz=\"0 0 " + std::to_string(z) + "\"/><mass value=\"" +
         std::to_string(mass) + "\"/><inertia ixx=\"" + std::to_string(i) + "\" iyy=\"" + std::to_string(i) + "\" izz=\"" +
         std::to_string(i) + "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>" + more + "</link>";
}

std::string make_joint(const std::string& name, const std::string& parent, const std::string& child, const std::string& xyz) {
  return "<joint name=\"" + name + "\" type=\"revolute\"><parent link=\"" + parent + "\"/><child link=\"" + child +
         "\"/><origin xyz=\"" + xyz + "\"/><axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"500\" velocity=\"20\"/></joint>";
}

std::string make_urdf() {
  std::string out = "<robot name=\"biped\">" + make_link("pelvis", 20, 0.1);
  for (const std::string side : {"l", "r"}) {
    const std::string y = side == "l" ? "0.1" : "-0.1";
    out += make_link(side + "_thigh", 4, -0.15) + make_link(side + "_shank", 3, -0.15) +
           make_link(side + "_foot", 0.5, -0.03, "<collision><origin xyz=\"0 0 -0.05\"/><geometry><box size=\"0.2 0.1 0.02\"/></geometry></collision>");
    out += make_joint(side + "_hip", "pelvis", side + "_thigh", "0 " + y + " 0");
    out += make_joint(side + "_knee", side + "_thigh", side + "_shank", "0 0 -0.3");
    out += make_joint(side + "_ankle", side + "_shank", side + "_foot", "0 0 -0.3");
  }
  return out + "</robot>";
}

constexpr const char* kScenario =
    "robot: biped.urdf\nbase: floating\ndrive: motion\nfeet: [l_foot, r_foot]\n"
    "sensors: {imu: {waist: {link: pelvis}}, wrench: {l: {link: l_foot}, r: {link: r_foot}}}\n";

// What is hidden from the model.
struct Hidden {
  double load = 0;            // [kg] on the pelvis
  Vector3d place{0, 0, 0};    // [m]
  double dry = 0;             // [N m] in the left knee
  double rotor = 0;           // [kg m^2] there
  double every = 0;           // [N m] dry friction of every joint
  double force_scale = 1;     // of the left foot's sensor
  double lower = 0;           // [m] by which the left thigh's centre of mass lies lower
  double zero_y = 0;          // [N m] that the left foot's sensor reads about y without a load
  Vector3d turn{0, 0, 0};     // [rad] of the left foot's sensor against its link, a rotation vector
  double heavier = 1;         // factor of all masses
  double give = 0;            // [rad/(N m)] of the left hip: its link falls behind its encoder
  double slope = 0;           // [rad] of the ground about y
  double push = 0;            // [N] amplitude of somebody's hand at the base's origin, along y
  double tether = 0;          // [N/m] of a spring to the world at the pelvis's centre of mass, along x
  double bend = 0;            // [rad/(N m)] of what carries the left hip, about x, across its axis
};

// What is recorded beside encoders and IMU.
struct Recorded {
  bool six_axes = true, effort = true;
  double unit = 1, zero = 0;  // of the vertical forces, where six_axes is false
  bool imu = true;
  bool leans = false;         // both feet stay where they are
  bool right_foot = true;     // has a force sensor
  bool moments = true;        // of the force sensors
};

class Maker {
 public:
  Maker(const Hidden& hidden, const Recorded& recorded) : hidden_(hidden), recorded_(recorded) {
    e_.scenario = parse_scenario(kScenario, "biped.yaml");
    e_.robot = parse_robot(make_urdf(), "biped.urdf", e_.scenario);
    e_.path = "biped.yaml", e_.sample_time = kStep;
    level_ = e_.scenario.gravity_W;
    e_.scenario.gravity_W = turn_y(hidden.slope) * level_;  // seen from the ground
    tree_ = e_.robot.tree;
    for (const char* foot : {"l_foot", "r_foot"}) {  // below the sensors
      tree_.links[static_cast<size_t>(tree_.find_link(foot))].inertia = {1e-9, Vector3d::Zero(), 1e-12 * Matrix3d::Identity()};
    }
    tree_.links[static_cast<size_t>(tree_.find_link("l_thigh"))].inertia.p_LLcm_L.z() -= hidden.lower;
    LinkInertia& pelvis = tree_.links[0].inertia;
    const Vector3d c = (pelvis.mass * pelvis.p_LLcm_L + hidden.load * hidden.place) / (pelvis.mass + hidden.load);
    const auto about = [&](double m, const Vector3d& p) {
      const Vector3d d = p - c;
      return Matrix3d(m * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose()));
    };
    pelvis.I_LLcm_L += about(pelvis.mass, pelvis.p_LLcm_L) + about(hidden.load, hidden.place);
    pelvis.mass += hidden.load, pelvis.p_LLcm_L = c;
    for (LinkSpec& link : tree_.links) link.inertia.mass *= hidden.heavier, link.inertia.I_LLcm_L *= hidden.heavier;
  }

  Experiment run() {
    for (int r = 0; r < 3; ++r) add_recording(r);
    e_.scenario.gravity_W = level_;
    return e_;
  }

 private:
  static constexpr double kStep = 0.004, kDuration = 8;

  // Angles of the joints, attitude and place of the base: a few sinusoids each.
  // Ankles keep the feet level.
  double angle(int j, double t) const {
    if (recorded_.leans) return lean(j % 3, t);
    if (j % 3 == 2) return -angle(j - 2, t) - angle(j - 1, t);
    return 0.25 * std::sin((2.1 + 0.7 * j + 0.3 * turn_) * t + j) + 0.1 * std::sin(5.3 * t + 2 * j);
  }
  // Hip, knee, ankle of both legs: a body that leans and squats over feet that stand.
  double lean(int part, double t) const {
    const double at[] = {-0.3, 0.6, -0.3}, size[] = {0.15, 0.12, 0.06}, rate[] = {1.7 + 0.2 * turn_, 1.1, 2.3};
    return at[part] + size[part] * std::sin(rate[part] * t + part);
  }
  static Matrix3d turn_y(double angle) { return Eigen::AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix(); }
  Matrix3d attitude(double t) const {
    if (recorded_.leans) return turn_y(-lean(0, t) - lean(1, t) - lean(2, t));
    return make_rotation_from_rpy({0.05 * std::sin(2.3 * t + turn_), 0.08 * std::sin(1.7 * t), 0.05 * std::sin(1.1 * t)});
  }
  Vector3d place(double t) const {
    const Vector3d leg(0, 0, -0.3);
    if (recorded_.leans) return -(attitude(t) * (turn_y(lean(0, t)) * (leg + turn_y(lean(1, t)) * leg)));
    return {0.05 * std::sin(1.9 * t + turn_), 0.06 * std::sin(2.6 * t), 0.8 + 0.02 * std::sin(3.1 * t)};
  }

  void add_recording(int r) {
    turn_ = r;
    Recording out;
    out.spec.name = "walk_" + std::to_string(r) + ".csv", out.spec.train = r < 2;
    out.joints.resize(6);
    const Model model(tree_, e_.scenario.gravity_W);
    Data data(model);
    State state = make_state(model);
    Eigen::VectorXd vdot(model.nv()), tau(model.nv());
    constexpr double h = 1e-4;
    for (double t = 0; t < kDuration; t += kStep) {
      const Matrix3d R = attitude(t);
      const auto rate_at = [&](double s) -> Vector3d {  // world axes
        const Eigen::AngleAxisd turn(Matrix3d(attitude(s + h) * attitude(s - h).transpose()));
        return turn.axis() * turn.angle() / (2 * h);
      };
      const Vector3d w = rate_at(t), alpha = (rate_at(t + 1e-3) - rate_at(t - 1e-3)) / 2e-3;
      const Vector3d a = (place(t + 1e-3) - 2 * place(t) + place(t - 1e-3)) / 1e-6;
      state.R_WB = Eigen::Quaterniond(R), state.p_WB.setZero(), state.V_WB.setZero();
      state.V_WB.head<3>() = w;
      vdot.head<3>() = alpha, vdot.segment<3>(3) = a;
      for (int j = 0; j < 6; ++j) {
        state.q(j) = angle(j, t), state.qd(j) = (angle(j, t + h) - angle(j, t - h)) / (2 * h);
        vdot(6 + j) = (angle(j, t + 1e-3) - 2 * angle(j, t) + angle(j, t - 1e-3)) / 1e-6;
      }
      update_kinematics(model, state, &data);
      calc_inverse_dynamics(model, vdot, nullptr, &data, &tau);
      tau(4) -= hidden_.push * std::sin(1.3 * t);
      const Vector3d pull(-hidden_.tether * (place(t).x() - place(0).x()), 0, 0);
      tau.head<3>() -= (R * tree_.links[0].inertia.p_LLcm_L).cross(pull), tau.segment<3>(3) -= pull;
      if (hidden_.bend == 0) {
        add_sample(t, a, model, state, vdot, &data, tau, &out);
      } else {
        add_bent_sample(t, a, state, vdot, tau, &data, &out);
      }
    }
    e_.recordings.push_back(std::move(out));
  }

  // The leg hangs askew by the moment that the ground's force makes about x at the hip.
  void add_bent_sample(double t, const Vector3d& a, const State& state, const Eigen::VectorXd& vdot, const Eigen::VectorXd& needed,
                       Data* data, Recording* out) {
    const auto thigh = static_cast<size_t>(tree_.find_link("l_thigh"));
    const Transform hip = get_pose(*data, static_cast<int>(thigh));
    const Vector3d about = find_share(t) * (needed.head<3>() - hip.p.cross(needed.segment<3>(3)));
    const double moment = get_joint_wrench(*data, static_cast<int>(thigh)).x() - state.R_WB.toRotationMatrix().col(0).dot(about);
    TreeSpec bent = tree_;
    Matrix3d& R = bent.links[thigh].joint.X_PF.R;
    R = R * make_turn(Vector3d(-hidden_.bend * moment, 0, 0)).toRotationMatrix();
    const Model model(bent, e_.scenario.gravity_W);
    Data moved(model);
    Eigen::VectorXd tau(model.nv());
    update_kinematics(model, state, &moved);
    calc_inverse_dynamics(model, vdot, nullptr, &moved, &tau);
    add_sample(t, a, model, state, vdot, &moved, tau, out);
  }

  double find_share(double t) const { return 0.5 + 0.3 * std::sin(1.3 * t + turn_); }  // of what the feet bear, the left one's

  void add_sample(double t, const Vector3d& a, const Model& model, const State& state, const Eigen::VectorXd& vdot, Data* data,
                  const Eigen::VectorXd& needed, Recording* out) {
    out->time.push_back(t);
    const Matrix3d R = state.R_WB.toRotationMatrix();
    if (recorded_.imu) put(out, "/imu/waist/angular_velocity", R.transpose() * state.V_WB.head<3>(), 1e-3);
    if (recorded_.imu) put(out, "/imu/waist/linear_acceleration", R.transpose() * (a - e_.scenario.gravity_W), 0.02);
    LinkWrenches wrenches(tree_.links.size(), Vector6d::Zero());
    const double share = find_share(t);
    for (const std::string side : {"l", "r"}) {
      const auto link = static_cast<size_t>(tree_.find_link(side + "_foot"));
      const Transform X = get_pose(*data, static_cast<int>(link));
      const double part = side == "l" ? share : 1 - share;
      const Vector3d force = part * needed.segment<3>(3);
      const Vector3d moment = part * (needed.head<3>() - X.p.cross(needed.segment<3>(3)));
      wrenches[link] << moment, force;
      const double scale = side == "l" ? hidden_.force_scale : 1;
      const Matrix3d R_SW = (side == "l" ? make_turn(hidden_.turn).toRotationMatrix().transpose() : Matrix3d(Matrix3d::Identity())) * X.R.transpose();
      const Vector3d zero(0, side == "l" ? hidden_.zero_y : 0, 0);
      if (side == "l" || recorded_.right_foot) put_wrench(out, "/wrench/" + side, scale * (R_SW * force), R_SW * moment + zero);
    }
    Eigen::VectorXd tau(model.nv());
    calc_inverse_dynamics(model, vdot, &wrenches, data, &tau);
    for (int j = 0; j < 6; ++j) {
      JointColumns& c = out->joints[static_cast<size_t>(j)];
      c.signal[0].push_back(state.q(j) + (j == 0 ? hidden_.give * tau(6 + j) : 0.0) + 2e-5 * normal_(random_));
      const bool knee = j == 1;
      const double dry = hidden_.every + (knee ? hidden_.dry : 0);
      const double friction = dry * std::tanh(state.qd(j) / 1e-3) + (knee ? hidden_.rotor * vdot(6 + j) : 0);
      if (recorded_.effort) c.signal[2].push_back(tau(6 + j) + friction + 0.05 * normal_(random_));
    }
  }

  void put(Recording* out, const std::string& base, const Vector3d& v, double noise) {
    for (int i = 0; i < 3; ++i) out->other[base + "/" + "xyz"[i]].push_back(v(i) + noise * normal_(random_));
  }

  void put_wrench(Recording* out, const std::string& base, const Vector3d& force, const Vector3d& moment) {
    if (!recorded_.six_axes) {
      out->other[base + "/force/z"].push_back(recorded_.zero + recorded_.unit * force.z() + 0.2 * normal_(random_));
      return;
    }
    put(out, base + "/force", force, 0.3);
    if (recorded_.moments) put(out, base + "/torque", moment, 0.03);
  }

  Hidden hidden_;
  Recorded recorded_;
  Experiment e_;
  TreeSpec tree_;
  double turn_ = 0;
  Vector3d level_{0, 0, 0};
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

Evidence diagnose_biped(const Hidden& hidden, const Recorded& recorded = {}) {
  const LeggedReport report = diagnose_legged(Maker(hidden, recorded).run(), nullptr);
  EXPECT_TRUE(report.judged);
  return report.evidence;
}

TEST(Legged, NothingHiddenNamesNothing) {
  const Evidence e = diagnose_biped({});
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kNoMismatch);
}

TEST(Legged, LoadOnThePelvisHasItsMassAndPlace) {
  Hidden hidden;
  hidden.load = 2.5, hidden.place = {0.05, -0.04, 0.2};
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "payload");
  EXPECT_EQ(e.findings[0].where.at("link"), "pelvis");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 2.5, 0.05);  // 2 %: noise of 200 s of cells is far below
  EXPECT_NEAR(e.findings[0].parameters[1].value[1], -0.04, 0.01);
}

TEST(Legged, DryFrictionIsNamedInItsJoint) {
  Hidden hidden;
  hidden.dry = 3;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "coulomb_friction");
  EXPECT_EQ(e.findings[0].where.at("joint"), "l_knee");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 3, 0.3);  // 10 %: the kernel rounds each reversal
}

TEST(Legged, RotorIsNamedInItsJoint) {
  Hidden hidden;
  hidden.rotor = 0.2;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "rotor_inertia");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 0.2, 0.02);
}

// The shaft gives, or the thigh or the pelvis beside it bends: nothing that is recorded tells where.
TEST(Legged, AnElasticHipIsListedBesideTheLinksThatMayBendThere) {
  Hidden hidden;
  hidden.give = 1.0 / 800;
  const Evidence e = diagnose_biped(hidden, {.leans = true});
  ASSERT_EQ(e.findings.size(), 1u);
  const Finding& f = e.findings[0];
  EXPECT_EQ(f.effect, "joint_elasticity");
  EXPECT_EQ(f.where.at("joint"), "l_hip");
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  EXPECT_NEAR(f.parameters[0].value[0], 800, 1.96 * f.parameters[0].std[0]);  // its own interval
  std::vector<std::string> links;
  for (const Alternative& a : f.alternatives) {
    if (a.effect == "link_bending") links.push_back(a.where.at("link"));
  }
  EXPECT_EQ(links, (std::vector<std::string>{"pelvis", "l_thigh"}));
}

TEST(Legged, ForcesOfFlatFeetBalanceWithoutTheirMoments) {
  EXPECT_EQ(diagnose_biped({}, {.leans = true, .moments = false}).verdict, Verdict::kNoMismatch);
  Hidden hidden;
  hidden.push = 60;
  const Evidence e = diagnose_biped(hidden, {.leans = true, .moments = false});
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kUnexplained) << "a hand that pushes aside is no vertical force";
}

// No table holds a tether or a beam that bends: what is asked of the report is the place, and no name in their stead.
TEST(Legged, ATetherIsNoEffectButAForceAtItsLink) {
  Hidden hidden;
  hidden.tether = 600;
  const Evidence e = diagnose_biped(hidden, {.leans = true});
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kUnexplained);
  ASSERT_FALSE(e.remaining.empty());
  EXPECT_EQ(e.remaining[0].where.at("link"), "pelvis");
  EXPECT_NE(e.remaining[0].statement.find("pulls"), std::string::npos);
}

TEST(Legged, AHipThatBendsAcrossItsAxisIsToldAtThatHip) {
  Hidden hidden;
  hidden.bend = 1.0 / 1500;
  const Evidence e = diagnose_biped(hidden, {.leans = true});
  EXPECT_TRUE(e.findings.empty());
  ASSERT_FALSE(e.remaining.empty());
  EXPECT_EQ(e.remaining[0].where.at("joint"), "l_hip");
  EXPECT_NE(e.remaining[0].statement.find("bends"), std::string::npos);
}

// Its inertia about the hip grows by a third: without that in its column, a torque constant or a rotor stands in for it.
TEST(Legged, MassThatLiesElsewhereAlsoTurnsOtherwise) {
  Hidden hidden;
  hidden.lower = 0.05;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "com_error");
  EXPECT_EQ(e.findings[0].where.at("link"), "l_thigh");
  EXPECT_NEAR(e.findings[0].parameters[0].value[2], -0.05, 0.0025);  // 5 %: to which equations are exact here
}

// I = I_cm + m (c.c 1 - c c^T) by the parallel axes; the columns about the middle of the way give all of its change.
TEST(LeggedColumns, InertiaOfAMassThatLiesElsewhereIsExact) {
  const Experiment e = Maker({}, {}).run();
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const ColumnLayout at(log);
  const std::vector<Candidate> all = list_candidates(log, find_contacts(log), at);
  const auto moved = std::find_if(all.begin(), all.end(), [](const Candidate& c) {
    return c.effect == EffectId::kComError && c.where.at("link") == "l_thigh";
  });
  ASSERT_NE(moved, all.end());
  const Vector3d d(0.02, -0.03, 0.05), c = moved->center;
  const Candidate exact = make_moved(*moved, at, d);
  const double mass = 4;
  const auto about = [&](const Vector3d& p) -> Matrix3d { return mass * (p.squaredNorm() * Matrix3d::Identity() - p * p.transpose()); };
  const Matrix3d change = about(c + d) - about(c);
  double xx = 0, yz = 0;
  for (size_t i = 0; i < 3; ++i) {
    for (const auto& [column, factor] : exact.terms[i]) {
      if (column == at.link(moved->place, 4)) xx += factor * d(static_cast<long>(i));
      if (column == at.link(moved->place, 8)) yz += factor * d(static_cast<long>(i));
    }
  }
  EXPECT_NEAR(xx, change(0, 0), 1e-12);  // rounding
  EXPECT_NEAR(yz, change(1, 2), 1e-12);
}

// A lack that is the same all the time is one long error; counted so, nothing that explains it would ever be worth its name.
TEST(LeggedFit, WhatLacksAllTheTimeCountsByTheErrorsThatItsCauseLeaves) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  RowTable even(1), odd(1);
  for (RowTable* half : {&even, &odd}) {
    half->add_channel({"weight", "/wrench/l/force", "N", "link", "pelvis"}, {0});
    for (int i = 0; i < 600; ++i) {
      half->begin_cell({0.04 * i, i < 400 ? 0 : 1, i / 12, 0, i < 400, 1, 1});
      half->begin_row(0, 20 + 8 * normal(random), 400 + 40 * std::sin(0.1 * i)), half->add(0, 0, 1.0);
      half->end_cell();
    }
    half->finish();
  }
  LeggedFitter fitter(merge_halves(even, odd), 1);
  Candidate constant;
  constant.effect = EffectId::kSensorBias, constant.terms = {{{0, 1.0}}};
  const LeggedFit none = fitter.fit({}), with = fitter.fit({constant});
  const double before = fitter.calc_gain(Part::kTrain, none, with) + fitter.calc_gain(Part::kHeld, none, with);
  EXPECT_LT(before, 60);                                 // 600 rows count as some 20
  EXPECT_GT(fitter.calc_gain_after(none, with), 300);    // they are 600: 600 log((20^2 + 8^2 / 2) / (8^2 / 2)) is 1500
}

// An equation that no effect changes has no products to sum.
TEST(LeggedFit, AnEquationWithoutColumnsKeepsItsMismatch) {
  RowTable even(1), odd(1);
  for (RowTable* half : {&even, &odd}) {
    half->add_channel({"weight", "/wrench/l/force", "N", "link", "pelvis"}, {});
    for (int i = 0; i < 300; ++i) {
      half->begin_cell({0.04 * i, i < 200 ? 0 : 1, i / 12, 0, i < 200, 1, 1});
      half->begin_row(0, 7, 400), half->end_cell();
    }
    half->finish();
  }
  const LeggedFitter fitter(merge_halves(even, odd), 1);
  EXPECT_DOUBLE_EQ(fitter.fit({}).mean_square[0][0], 49);
}

// Halves whose errors oppose each other differ by more than noise does: their difference overstates it. What explains the
// readings by halves is worth the same all the same.
TEST(LeggedFit, AnEffectBelowAnOverstatedNoiseStillGains) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  RowTable even(1), odd(1);
  for (RowTable* half : {&even, &odd}) half->add_channel({"joint", "/joint_states/A/effort", "N m", "joint", "A"}, {0});
  for (int i = 0; i < 600; ++i) {
    const double x = normal(random), opposed = 8 * normal(random), noise = 2 * normal(random);
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, i < 400 ? 0 : 1, i / 12, 0, i < 400, 1, 1});
      half->begin_row(0, 3 * x + noise + (half == &even ? opposed : -opposed), 20), half->add(0, 0, x);
      half->end_cell();
    }
  }
  for (RowTable* half : {&even, &odd}) half->finish();
  LeggedFitter fitter(merge_halves(even, odd), 1);
  Candidate gain;
  gain.effect = EffectId::kRotorInertia, gain.terms = {{{0, 1.0}}};
  const LeggedFit none = fitter.fit({}), with = fitter.fit({gain});
  EXPECT_EQ(none.mean_square[0][0], 0) << "3^2 + 2^2 - 8^2 is negative";
  EXPECT_NEAR(with.x(0), 3, 0.4);  // four errors of 2 / sqrt(600)
  // 600 log((9 + 64) / 64) over all rows is 79; half of them are fitted. Chance alone gains 1.
  EXPECT_GT(fitter.calc_gain(Part::kTrain, none, with) + fitter.calc_gain(Part::kHeld, none, with), 40);
}

// One joint's rows, calm and rough. The first column explains large errors of the rough rows. The second explains small
// ones of the calm rows; in rough rows its halves oppose each other.
std::vector<ChannelRows> make_calm_and_rough() {
  std::mt19937 random(13);
  std::normal_distribution<double> normal;
  RowTable even(2), odd(2);
  for (RowTable* half : {&even, &odd}) half->add_channel({"joint", "/joint_states/A/effort", "N m", "joint", "A"}, {0, 1});
  for (int i = 0; i < 900; ++i) {
    const bool rough = (i / 3) % 2 == 1;
    const double swing = rough ? normal(random) : 0.1 * normal(random), shape = rough ? 0 : normal(random), opposed = rough ? 3 * normal(random) : 0;
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, i < 600 ? 0 : 1, i / 12, 0, i < 600, 1, rough ? 5.0 + 0.001 * i : 1.0 + 0.001 * i});
      half->begin_row(0, 100 * swing + shape + 0.1 * normal(random), 20);
      half->add(0, 0, swing), half->add(0, 1, shape + (half == &even ? opposed : -opposed));
      half->end_cell();
    }
  }
  for (RowTable* half : {&even, &odd}) half->finish();
  return merge_halves(even, odd);
}

Candidate make_candidate(EffectId effect, const char* joint, std::vector<Terms> terms) {
  static const CandidateLaw law{[](const Candidate&, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
    return std::vector<Estimate>{{"value", "1", {x(0)}, {std(0)}, false}};
  }};
  Candidate c;
  c.effect = effect, c.law = &law, c.where = {{"joint", joint}}, c.terms = std::move(terms);
  return c;
}

// A fit that no sums can tell says nothing of errors: the next fits weigh as before.
TEST(LeggedFit, AColumnThatIsNoiseAloneSpoilsNoOtherFit) {
  LeggedFitter fitter(make_calm_and_rough(), 2);
  const Candidate rotor = make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}});
  for (int round = 0; round < 4; ++round) fitter.update_weights(fitter.fit({rotor}));
  const LeggedFit noise = fitter.fit({make_candidate(EffectId::kViscous, "A", {{{1, 1.0}}})});
  ASSERT_FALSE(noise.x.allFinite()) << "1 - 3^2 is negative";
  fitter.update_weights(noise);
  EXPECT_NEAR(fitter.fit({rotor}).x(0), 100, 1);  // 1 %: errors of 1 in 450 swings of 1 are 0.05
}

// Play moves a link by the sign of its torque, give in proportion to it. Over torques that are spread evenly up to their
// largest, (E |T|)^2 / E T^2 = (1/2)^2 / (1/3); over torques of one size nothing is left to tell them apart.
TEST(LeggedFit, PlayAndGiveAreAsAlikeAsTorquesAreOfOneSize) {
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> even_spread(0, 1);
  for (const bool one_size : {false, true}) {
    RowTable even(2), odd(2);
    for (RowTable* half : {&even, &odd}) half->add_channel({"tilt, roll", "/joint_states", "rad", "foot", "A"}, {0, 1});
    for (int i = 0; i < 3000; ++i) {
      const double torque = one_size ? 1 : even_spread(random);
      for (RowTable* half : {&even, &odd}) {
        half->begin_cell({0.04 * i, i < 2000 ? 0 : 1, i / 12, 0, i < 2000, 1, 1});
        half->begin_row(0, 0, 1), half->add(0, 0, 0.5), half->add(0, 1, torque + normal(random));
        half->end_cell();
      }
    }
    for (RowTable* half : {&even, &odd}) half->finish();
    const LeggedFitter fitter(merge_halves(even, odd), 2);
    const double alike = fitter.calc_overlap(make_candidate(EffectId::kBacklash, "A", {{{0, 1.0}}}), make_candidate(EffectId::kElasticity, "A", {{{1, 1.0}}}));
    // Noise of 1 in 3000 rows leaves 2 / sqrt(3000) of a square of 1/3: a tenth.
    EXPECT_NEAR(alike, one_size ? 1.0 : 0.75, 0.1);
  }
}

TEST(LeggedLaws, AGiveThatMayBeNoneHasNoStiffness) {
  const Eigen::VectorXd x = Eigen::VectorXd::Constant(1, 4e-5), sure = 0.1 * x, unsure = 0.6 * x;
  ASSERT_EQ(get_give_law().make_estimates({}, x, sure).size(), 1u);
  EXPECT_DOUBLE_EQ(get_give_law().make_estimates({}, x, sure)[0].value[0], 25000);
  EXPECT_TRUE(get_give_law().make_estimates({}, x, unsure).empty()) << "4e-5 +- 4.7e-5 rad/(N m), two deviations";
}

// Its second column tells while rough rows weigh little. When its first one has explained them, they do not.
TEST(LeggedSearch, AnEffectThatLosesItsInformationTakesNoOtherWithIt) {
  LeggedFitter fitter(make_calm_and_rough(), 2);
  const std::vector<Candidate> all{make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}}),
                                   make_candidate(EffectId::kSpring, "A", {{{0, 1.0}}, {{1, 1.0}}})};
  const ColumnLayout layout(make_legged_log(Maker({}, {}).run(), Half::kEven));
  const LeggedOutcome found = search_legged(&fitter, all, layout, 1.0, nullptr);
  ASSERT_EQ(found.chosen.effects.size(), 1u);
  EXPECT_EQ(found.chosen.effects[0].effect, EffectId::kRotorInertia);
  EXPECT_NEAR(found.chosen.x(0), 100, 1);
}

// A drive that is 15 % too strong in an ankle, 6 N m at 40 N m, and a force of this size [N] on the body that nobody knows.
size_t count_gains_beside(double force) {
  std::mt19937 random(23);
  std::normal_distribution<double> normal;
  RowTable even(1), odd(1);
  for (RowTable* half : {&even, &odd}) {
    half->add_channel({"balance, force z", "/wrench/l/force", "N", "link", "pelvis"}, {});
    half->add_channel({"joint", "/joint_states/A/effort", "N m", "joint", "A"}, {0});
  }
  for (int i = 0; i < 900; ++i) {
    const double unknown = force * std::sin(0.9 * i), torque = 40 * normal(random);
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, i < 600 ? 0 : 1, i / 12, 0, i < 600, 1, 1.0 + 0.001 * (i % 7)});
      half->begin_row(0, unknown + normal(random), 400 + 40 * std::sin(0.1 * i));
      half->begin_row(1, 0.15 * torque + 0.2 * normal(random), torque), half->add(1, 0, torque);
      half->end_cell();
    }
  }
  for (RowTable* half : {&even, &odd}) half->finish();
  LeggedFitter fitter(merge_halves(even, odd), 1);
  Candidate gain = make_candidate(EffectId::kTorqueConstant, "A", {{{0, 1.0}}});
  gain.lever = 0.1;
  const ColumnLayout layout(make_legged_log(Maker({}, {}).run(), Half::kEven));
  return search_legged(&fitter, {gain}, layout, 1.0, nullptr).effects.size();
}

// Anywhere under a sole of 0.2 m, 150 N make moments of up to 15 N m at the ankle; 20 N make 2.
TEST(LeggedSearch, ADrivesGainThatAnUnknownForceUnderTheSoleCouldMakeIsNotNamed) {
  EXPECT_EQ(count_gains_beside(150), 0u);
  EXPECT_EQ(count_gains_beside(20), 1u);
}

// A force of which a listed effect predicts `listed` and a free law `free` of the square; the search's first effect.
bool is_first_listed(double listed, double free) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  RowTable even(2), odd(2);
  for (RowTable* half : {&even, &odd}) half->add_channel({"balance, force z", "/wrench/l/force", "N", "link", "pelvis"}, {0, 1});
  for (int i = 0; i < 900; ++i) {
    const double force = normal(random), other = normal(random), another = normal(random);
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, i < 600 ? 0 : 1, i / 12, 0, i < 600, 1, 1.0 + 0.001 * (i % 7)});
      half->begin_row(0, 20 * force + normal(random), 400 + 40 * std::sin(0.1 * i));
      half->add(0, 0, std::sqrt(listed) * force + std::sqrt(1 - listed) * other);
      half->add(0, 1, std::sqrt(free) * force + std::sqrt(1 - free) * another), half->end_cell();
    }
  }
  for (RowTable* half : {&even, &odd}) half->finish();
  LeggedFitter fitter(merge_halves(even, odd), 2);
  Candidate hold = make_candidate(EffectId::kNamed, "A", {{{1, 1.0}}});
  hold.law = &get_hold_law();
  const ColumnLayout layout(make_legged_log(Maker({}, {}).run(), Half::kEven));
  const LeggedOutcome out = search_legged(&fitter, {make_candidate(EffectId::kViscous, "A", {{{0, 1.0}}}), hold}, layout, 1.0, nullptr);
  return !out.effects.empty() && out.effects[0].effect.is_listed();
}

TEST(LeggedSearch, AFreeLawTakesThePlaceOfANameOnlyWhereItWinsOutright) {
  EXPECT_FALSE(is_first_listed(0.9, 0.999));
  EXPECT_TRUE(is_first_listed(0.999, 0.9));
  EXPECT_TRUE(is_first_listed(0.99, 0.99)) << "a tie is the effect's, which a scenario can hold";
}

// Friction, and a delay of 1 us per N m s/rad whose column is the same but for a hundredth.
size_t count_frictions(double coefficient, double known) {
  std::mt19937 random(29);
  std::normal_distribution<double> normal;
  RowTable even(2), odd(2);
  for (RowTable* half : {&even, &odd}) half->add_channel({"joint", "/joint_states/A/effort", "N m", "joint", "A"}, {0, 1});
  for (int i = 0; i < 900; ++i) {
    const double speed = std::sin(0.9 * i), other = 0.01 * normal(random);
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, i < 600 ? 0 : 1, i / 12, 0, i < 600, 1, 1.0 + 0.001 * (i % 7)});
      half->begin_row(0, coefficient * speed + 0.02 * normal(random), 2 * speed);
      half->add(0, 0, speed), half->add(0, 1, 1e6 * (speed + other)), half->end_cell();
    }
  }
  for (RowTable* half : {&even, &odd}) half->finish();
  LeggedFitter fitter(merge_halves(even, odd), 2);
  Candidate delay = make_candidate(EffectId::kDelay, "A", {{{1, 1.0}}});
  delay.known = known, delay.least = 5 * known;
  const ColumnLayout layout(make_legged_log(Maker({}, {}).run(), Half::kEven));
  return search_legged(&fitter, {make_candidate(EffectId::kViscous, "A", {{{0, 1.0}}}), delay}, layout, 1.0, nullptr).effects.size();
}

// Rows of 2.5 ms tell instants to a tenth of it: 0.2 us of delay are no mismatch, whatever else they look like.
TEST(LeggedSearch, WhatADelayFarBelowOneSampleExplainsAsWellIsNotNamed) {
  EXPECT_EQ(count_frictions(0.2, 250e-6), 0u);
  EXPECT_EQ(count_frictions(0.2, 0.1e-6), 1u);
}

// Two joints whose errors change from row to row, so that neither stands out: of this size [N m], and noise of which
// half comes back with the other sign, so that products of the halves lack 0.5 N^2 m^2.
std::vector<Remaining> list_remaining_of_noise(const std::vector<size_t>& unsteady, double size) {
  std::mt19937 random(29);
  std::normal_distribution<double> normal;
  RowTable even(1), odd(1);
  for (RowTable* half : {&even, &odd}) {
    for (const char* joint : {"A", "B"}) half->add_channel({"joint", "/joint_states/" + std::string(joint) + "/effort", "N m", "joint", joint}, {});
  }
  for (int i = 0; i < 900; ++i) {
    const double errors[] = {size * normal(random), size * normal(random)}, opposed[] = {normal(random), normal(random)};
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, i < 600 ? 0 : 1, i / 12, 0, i < 600, 1, 1});
      for (int c = 0; c < 2; ++c) half->begin_row(c, errors[c] + (half == &even ? 1 : -0.5) * opposed[c], 20);
      half->end_cell();
    }
  }
  for (RowTable* half : {&even, &odd}) half->finish();
  const LeggedFitter fitter(merge_halves(even, odd), 1);
  const LeggedFit nominal = fitter.fit({});
  return list_remaining(fitter, nominal, nominal, unsteady);
}

// A verdict that stands on an effect that was not of one size says where that was.
TEST(LeggedRemaining, AnEquationThatAnEffectOfManySizesHelpedIsListedWithItsPlace) {
  EXPECT_TRUE(list_remaining_of_noise({}, 1).empty());
  const std::vector<Remaining> left = list_remaining_of_noise({1, 1}, 1);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].where.at("joint"), "B");
  EXPECT_NEAR(left[0].before, std::sqrt(0.5), 0.1);  // 1 - 0.5; four errors of 1.4 / sqrt(300) of the square
  EXPECT_DOUBLE_EQ(left[0].after, left[0].before);
}

TEST(LeggedRemaining, AnEquationThatHasNothingBeyondNoiseByNowIsListedWithItsNoise) {
  const std::vector<Remaining> left = list_remaining_of_noise({1}, 0);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_NEAR(left[0].before, 0.25, 0.03);  // the mean of both halves
  EXPECT_DOUBLE_EQ(left[0].share(), 1);
}

// Sliding friction is as large as its law says and points against the way. A force of that size that drives a foot on, or
// points anywhere, is another's.
TEST(LeggedChecks, SlidingFeetTellFrictionOnlyWhereTheirForcePointsBack) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> angle(-M_PI, M_PI);
  std::vector<Slide> back, onward, anywhere;
  for (int i = 0; i < 400; ++i) {
    const double ratio = 0.1 * (1 + 0.2 * normal(random)), cosine = std::cos(0.2 * normal(random));
    back.push_back({0, 0.05, ratio, cosine}), onward.push_back({0, 0.05, ratio, -cosine});
    anywhere.push_back({0, 0.05, ratio, std::cos(angle(random))});
  }
  const auto [value, spread] = find_sliding_friction(back);
  EXPECT_NEAR(value, 0.1, 0.005);    // four errors of a median: 1.25 * 0.02 / sqrt(400) each
  EXPECT_NEAR(spread, 0.0135, 0.004);  // half the way between quartiles: 0.67 * 0.02
  EXPECT_EQ(find_sliding_friction(onward).first, 0);
  EXPECT_EQ(find_sliding_friction(anywhere).first, 0);
}

TEST(Legged, ScaleOfOneForceSensorIsNoMass) {
  Hidden hidden;
  hidden.force_scale = 1.06;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "sensor_scale");
  EXPECT_EQ(e.findings[0].where.at("sensor"), "/wrench/l/force");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 1.06, 0.005);
}

TEST(Legged, VerticalForcesAloneCannotTellALoadFromAScale) {
  Hidden hidden;
  hidden.load = 1.5, hidden.dry = 3;
  Recorded recorded;
  recorded.six_axes = recorded.effort = false;
  const Evidence e = diagnose_biped(hidden, recorded);
  ASSERT_FALSE(e.findings.empty());
  EXPECT_EQ(e.findings[0].grade, Grade::kAmbiguous);
  std::vector<std::string> names{e.findings[0].effect};
  for (const Alternative& a : e.findings[0].alternatives) names.push_back(a.effect);
  for (const char* name : {"mass_error", "payload", "sensor_scale", "sensor_bias"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
  for (const Finding& f : e.findings) EXPECT_NE(f.effect, "coulomb_friction");
  EXPECT_FALSE(e.missing.empty());
}

// Encoders and force sensors alone: flat feet that stand tell how the body moves.
constexpr Recorded kLeans{.effort = false, .imu = false, .leans = true};

TEST(LeggedLeans, NothingHiddenNamesNothing) {
  const Evidence e = diagnose_biped({}, kLeans);
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kNoMismatch);
}

TEST(LeggedLeans, LoadIsFoundWithoutAnImu) {
  Hidden hidden;
  hidden.load = 2.5, hidden.place = {0.05, 0, 0.2};
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_FALSE(e.findings.empty());
  std::vector<std::string> families{e.findings[0].family};
  EXPECT_EQ(e.findings[0].family, "mass and its place");
  EXPECT_EQ(e.findings[0].where.at("link"), "pelvis");
}

// Every force and every moment is 4 % larger: the masses are, or the sensors' readings.
TEST(LeggedLeans, MassesThatAreWrongByOneFactorAreListedBesideTheScaleOfAllForceSensors) {
  Hidden hidden;
  hidden.heavier = 1.04;
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_EQ(e.findings.size(), 1u);
  const Finding& f = e.findings[0];
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  bool scale = f.effect == "sensor_scale" && f.where.at("sensor") == "/wrench", mass = f.family == "mass and its place";
  for (const Alternative& a : f.alternatives) {
    scale = scale || (a.effect == "sensor_scale" && a.where.at("sensor") == "/wrench");
    mass = mass || a.family == "mass and its place";
  }
  EXPECT_TRUE(scale) << f.statement;
  EXPECT_TRUE(mass) << f.statement;
}

TEST(LeggedLeans, ZeroOfAMomentIsFoundAtItsSensor) {
  Hidden hidden;
  hidden.zero_y = 3;
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "sensor_bias");
  EXPECT_EQ(e.findings[0].where.at("sensor"), "/wrench/l/torque");
  EXPECT_NEAR(e.findings[0].parameters[0].value[1], 3, 0.15);  // 5 %: what equations are exact to
}

// Who sways a robot by hand adds a force that nobody recorded: one equation keeps it, the others are as they were.
TEST(LeggedLeans, AHandThatPushesLeavesNoDoubtAboutTheZeroOfAMoment) {
  Hidden hidden;
  hidden.zero_y = 0.4, hidden.push = 200;
  const Evidence e = diagnose_biped(hidden, kLeans);
  const auto zero = std::find_if(e.findings.begin(), e.findings.end(), [](const Finding& f) { return f.effect == "sensor_bias"; });
  ASSERT_NE(zero, e.findings.end());
  EXPECT_EQ(zero->where.at("sensor"), "/wrench/l/torque");
  ASSERT_LT(e.explained, 0.25) << "the push is most of what the equations miss";
  EXPECT_EQ(zero->statement.find("Most of what stands out is left"), std::string::npos) << zero->statement;
  EXPECT_NE(e.verdict, Verdict::kExplained);
}

// Where feet are the ground, an ankle's zero and a sensor that is turned about its axis are one.
TEST(LeggedLeans, SmallTurnOfASensorIsListedBesideItsAnklesZero) {
  Hidden hidden;
  hidden.turn = {0, 0.06, 0};
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "joint_offset");
  EXPECT_EQ(e.findings[0].grade, Grade::kAmbiguous);
  ASSERT_EQ(e.findings[0].alternatives.size(), 1u);
  const Alternative& turned = e.findings[0].alternatives[0];
  EXPECT_EQ(turned.effect, "sensor_misalignment");
  EXPECT_EQ(turned.where.at("sensor"), "/wrench/l");
  EXPECT_NEAR(turned.parameters[0].value[1], 0.06, 0.006);  // 10 %: a turn is as large as its sine to 1 %
}

// Readings of all columns that begin so are `samples` behind those of the encoders.
void delay_columns(const std::string& begin, long samples, Experiment* e) {
  for (Recording& r : e->recordings) {
    for (auto& [name, column] : r.other) {
      if (name.rfind(begin, 0) != 0) continue;
      std::rotate(column.begin(), column.end() - samples, column.end());
      std::fill(column.begin(), column.begin() + samples, column[static_cast<size_t>(samples)]);
    }
  }
}

// Of so many samples, at 250 Hz.
void expect_delay_alone(const Experiment& e, const char* sensor, long samples) {
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  ASSERT_EQ(found.findings.size(), 1u);
  const Finding& f = found.findings[0];
  EXPECT_EQ(f.effect, "sensor_delay");
  EXPECT_EQ(f.where.at("sensor"), sensor);
  const double delay = 0.004 * static_cast<double>(samples);  // [s]
  EXPECT_NEAR(f.parameters[0].value[0], delay, 0.05 * delay);  // of first order in the delay
}

// On a bus that is late all force sensors are: one delay, not one of each.
TEST(Legged, ForceSensorsThatAreLateTogetherHaveOneDelay) {
  Recorded recorded;
  recorded.effort = false;
  Experiment e = Maker({}, recorded).run();
  delay_columns("/wrench/", 7, &e);
  expect_delay_alone(e, "/wrench", 7);
}

// The rate of the body, its slope and its specific force are late together: one delay, and no lag of the drives.
TEST(Legged, AnImuThatIsLateInAWalkIsNoLagOfTheDrives) {
  Experiment e = Maker({}, {}).run();
  delay_columns("/imu/", 3, &e);
  expect_delay_alone(e, "/imu/waist", 3);
}

// Nothing but encoders and feet that stand tells how the body turns.
TEST(LeggedLeans, AnImuThatIsLateIsFoundOverStandingFeet) {
  Recorded recorded = kLeans;
  recorded.imu = true;
  Experiment e = Maker({}, recorded).run();
  delay_columns("/imu/", 3, &e);
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  ASSERT_FALSE(found.findings.empty());
  const Finding& f = found.findings[0];
  EXPECT_EQ(f.effect, "sensor_delay");
  EXPECT_EQ(f.where.at("sensor").get<std::string>().rfind("/imu/waist", 0), 0u);
  EXPECT_NEAR(f.parameters[0].value[0], 3 * 0.004, 0.0012);  // a tenth of it: 1 ms is a quarter of a sample
}

// The weight rests on the one foot that is felt while the other swings.
TEST(Legged, OneFootsForceTellsTheWeightWhileTheOtherSwings) {
  Recorded recorded;
  recorded.effort = recorded.right_foot = false;
  const LeggedReport report = diagnose_legged(Maker({}, recorded).run(), nullptr);
  EXPECT_TRUE(report.judged);
  for (const Finding& f : report.evidence.findings) EXPECT_NE(f.family, "mass and its place") << f.statement;
}

// Feet that stay on a slope: zeros of all legs, or an IMU that sits askew, are the same constant.
TEST(LeggedLeans, ASlopeUnderFeetThatStayIsListedBesideAnklesZerosAndTheImu) {
  Hidden hidden;
  hidden.slope = 0.04;
  Recorded recorded = kLeans;
  recorded.imu = true, recorded.six_axes = false;
  const Evidence found = diagnose_biped(hidden, recorded);
  ASSERT_EQ(found.findings.size(), 1u);
  const Finding& f = found.findings[0];
  EXPECT_EQ(f.effect, "ground_slope") << f.statement;
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  int zeros = 0, askew = 0;
  for (const Alternative& a : f.alternatives) zeros += a.effect == "joint_offset", askew += a.effect == "sensor_misalignment";
  EXPECT_GE(zeros, 2) << "one of each ankle";
  EXPECT_GE(askew, 1);
}

class SensorIsTurned : public testing::TestWithParam<std::pair<Vector3d, bool>> {};

// A quarter or half turn is found before anything else, and nothing else is named for it.
TEST_P(SensorIsTurned, OntoOtherAxesAndTakenBack) {
  Hidden hidden;
  hidden.turn = GetParam().first;
  Recorded recorded = kLeans;
  recorded.imu = GetParam().second;
  const Experiment e = Maker(hidden, recorded).run();
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].sensor, "/wrench/l");
  EXPECT_TRUE(frames[0].R.isApprox(make_turn(hidden.turn).toRotationMatrix(), 1e-6));
  EXPECT_EQ(frames[0].late, 0.0);
  EXPECT_TRUE(find_sensor_frames(convert_sensor_frames(e, frames)).empty());
}

INSTANTIATE_TEST_SUITE_P(Quarters, SensorIsTurned,
                         testing::Values(std::pair(Vector3d(0, 0, M_PI / 2), false), std::pair(Vector3d(0, 0, M_PI), true),
                                         std::pair(Vector3d(M_PI, 0, 0), false)));

TEST(SensorFrames, NoneIsTurnedWhereNothingIsHidden) {
  for (const bool leans : {false, true}) {
    Recorded recorded;
    recorded.leans = leans;
    EXPECT_TRUE(find_sensor_frames(Maker({}, recorded).run()).empty());
  }
}

// Its z axis points down by the model, as those of the iCub's feet do: a foot that is pressed reads negative there.
TEST(SensorFrames, ASensorThatHangsUpsideDownInTheModelIsNotTurned) {
  Experiment e = Maker({}, kLeans).run();
  std::string urdf = make_urdf(), scenario = kScenario;
  for (const std::string side : {"l", "r"}) {
    const std::string below = make_link(side + "_ft", 0.5, 0.03);  // the foot's mass, in the sensor's axes
    const std::string fixed = "<joint name=\"" + side + "_mount\" type=\"fixed\"><parent link=\"" + side + "_foot\"/><child link=\"" +
                              side + "_ft\"/><origin xyz=\"0 0 0\" rpy=\"3.14159265358979 0 0\"/></joint>";
    const size_t foot = urdf.find("<inertial>", urdf.find("<link name=\"" + side + "_foot\"")), end = urdf.find("</inertial>", foot);
    urdf.erase(foot, end + std::string("</inertial>").size() - foot);
    urdf.insert(urdf.rfind("</robot>"), below + fixed);
    scenario.replace(scenario.rfind(side + "_foot}"), 6, side + "_ft");
  }
  e.scenario = parse_scenario(scenario, "biped.yaml");
  e.robot = parse_robot(urdf, "biped.urdf", e.scenario);
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      if (name.back() == 'x') continue;
      for (double& v : column) v = -v;
    }
  }
  EXPECT_TRUE(find_body_units(e).empty());
  EXPECT_TRUE(find_sensor_frames(e).empty());
  EXPECT_TRUE(diagnose_legged(e, nullptr).evidence.findings.empty());
}

// Forces by a computer whose clock is 0.2 s behind that of the encoders.
TEST(SensorFrames, AClockThatIsFarOffIsMoved) {
  Experiment e = Maker({}, kLeans).run();
  const Experiment true_time = e;
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) std::rotate(column.begin(), column.end() - 50, column.end());
  }
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 2u);
  for (const SensorFrame& f : frames) EXPECT_NEAR(f.late, 0.2, 0.015);  // one and a half steps of the clock that is looked for
}

// No shift puts what a drifting clock stamped where it belongs: its rate is an effect of its own.
TEST(SensorFrames, AClockThatRunsFastIsNotMoved) {
  Experiment e = Maker({}, kLeans).run();
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      const std::vector<double> was = column;
      for (size_t k = 0; k < was.size(); ++k) column[k] = was[std::min(was.size() - 1, k + k / 50)];  // 2 %
    }
  }
  for (const SensorFrame& f : find_sensor_frames(e)) EXPECT_EQ(f.late, 0.0) << f.sensor;
}

TEST(Legged, RawCountsAreNoNewtons) {
  Recorded recorded;
  recorded.six_axes = recorded.effort = false;
  recorded.unit = 8;
  const Evidence e = diagnose_biped({}, recorded);
  ASSERT_EQ(e.findings.size(), 2u);
  for (const Finding& f : e.findings) {
    EXPECT_EQ(f.effect, "sensor_scale");
    EXPECT_NEAR(f.parameters[0].value[0], 8, 0.4);  // 5 %: where the load lies between the feet is not known
  }
}

// With losses in every drive each joint is judged alone, in bounded time: what its neighbours lack does not reach it.
TEST(Legged, FrictionOfEveryJointOfARobotOnItsFeetIsToldJointByJoint) {
  Experiment e = Maker({.every = 2.0}, {}).run();
  e.joint_noise.assign(6, std::vector<Noise>(kQuantities));
  standing::StandProblem problem;
  std::string why;
  ASSERT_TRUE(standing::make_stand_problem(e, {Parity::kAll}, &problem, &why)) << why;
  const TorqueVerdict verdict = judge_torque(standing::make_joint_torques(problem, {}), 1);
  ASSERT_TRUE(verdict.judged);
  EXPECT_TRUE(has_real_drives(verdict));
  int found = 0;
  for (const Finding& f : verdict.evidence.findings) {
    if (f.effect != "coulomb_friction" || f.grade != Grade::kSupported) continue;
    // The filter takes some percent of a jump's edges away, from torque and column alike.
    EXPECT_NEAR(f.parameters[0].value[0], 2.0, 0.1) << f.statement;
    ++found;
  }
  EXPECT_EQ(found, 6);
}

TEST(LeggedTracks, GapsAreFoundAndNothingCrossesThem) {
  std::vector<double> time;
  for (int i = 0; i < 100; ++i) time.push_back(0.01 * i + (i >= 60 ? 0.17 : 0.0));
  std::vector<Gap> gaps;
  const std::vector<Span> spans = find_spans(time, {}, 0.05, &gaps);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_NEAR(gaps[0].to - gaps[0].from, 0.18, 1e-9);
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_EQ(spans[0].end, 60u);
  EXPECT_EQ(spans[1].begin, 60u);
}

TEST(LeggedTracks, HeldSamplesAreNoNewReadings) {
  const std::vector<double> x{1, 1, 2, 2, 3}, y{5, 5, 5, 6, 6};
  EXPECT_EQ(find_new_samples({&x, &y}), (std::vector<char>{1, 0, 1, 1, 1}));
}

// A foot that reads 0 or 1 in the air and is read anew every second sample; a force that noise makes unique and that is
// not read for four samples.
TEST(LeggedTracks, ACountThatComesAgainIsReadAnewAndAUniqueReadingIsHeld) {
  const std::vector<double> counts{7, 7, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0}, force{.31, .31, .42, .42, .42, .42, .53, .53, .64, .64, .75, .75};
  EXPECT_EQ(find_readings({&counts}, find_new_samples({&counts})), (std::vector<char>{1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0}));
  EXPECT_EQ(find_readings({&force}, find_new_samples({&force})), (std::vector<char>{1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0}));
}

TEST(LeggedRegimes, WhatIsThereInOnePhaseOnlyIsNoLaw) {
  EXPECT_TRUE(is_steady({{"phase 1", 1.2, 0.05}, {"phase 2", 0.8, 0.05}}));
  EXPECT_FALSE(is_steady({{"phase 1", 1.2, 0.05}, {"phase 2", 0.1, 0.05}}));
  EXPECT_TRUE(is_steady({{"phase 1", 1.0, 0.05}, {"phase 2", 0.1, 0.4}}));  // phase 2 tells nothing
}

TEST(LeggedTracks, ALateTrackIsShiftedBackAndALagIsAsItsEquationHasIt) {
  // 2 Hz at 500 Hz: a line between samples errs by (2 pi 2 / 500)^2 / 8, 8e-5 of the amplitude.
  const double step = 0.002, way = 2 * M_PI * 2, time = 0.01, late = 0.013;
  Track x;
  for (int k = 0; k < 1000; ++k) {
    const double t = k * step;
    x.value.push_back(std::sin(way * t)), x.rate.push_back(way * std::cos(way * t));
    x.second.push_back(-way * way * std::sin(way * t));
  }
  const Track ahead = shift_track(x, step, late), lagged = lag_track(x, step, time);
  for (size_t k = 200; k < 800; ++k) {  // 40 time constants after the beginning
    const double t = static_cast<double>(k) * step;
    EXPECT_NEAR(ahead.value[k], std::sin(way * (t + late)), 2e-4);
    const double expected = (std::sin(way * t) - way * time * std::cos(way * t)) / (1 + way * way * time * time);
    EXPECT_NEAR(lagged.value[k], expected, 2e-4);
    EXPECT_NEAR(lagged.value[k] + time * lagged.rate[k], x.value[k], 1e-12);  // the equation itself
  }
}

TEST(LeggedRegimes, NoLawChangesItsSignFromPhaseToPhase) {
  EXPECT_FALSE(is_steady({{"phase 1", 1.2, 0.1}, {"phase 2", -0.5, 0.45}}));  // 3.3 deviations from 1
  EXPECT_TRUE(is_steady({{"phase 1", 1.2, 0.1}, {"phase 2", -0.5, 0.55}}));   // by chance
}

// Rigid feet that roll over an edge turn under a moment, too, but not while they are pressed in the middle.
TEST(LeggedRegimes, ASoleGivesWhereItIsPressedInTheMiddle) {
  EXPECT_TRUE(is_steady({{"phase 1", 0.7, 0.05}, {"pressed in the middle", 0.9, 0.05, 0.8}}));
  EXPECT_FALSE(is_steady({{"phase 1", 0.7, 0.05}, {"pressed in the middle", 0.7, 0.05, 0.8}}));
}

// A foot that bears 0 to 500 N; its sensor reads 6 % too much, or 30 N. One column tries a scale, one a zero.
bool is_fault_steady(bool is_scale, bool of_scale) {
  const ColumnLayout layout(make_legged_log(Maker({}, {}).run(), Half::kEven));
  const int scale = layout.sensor(0, kForceScaleColumn), zero = layout.sensor(0, kForceBiasColumn + 2);
  std::mt19937 random(19);
  std::normal_distribution<double> normal;
  RowTable even(layout.count()), odd(layout.count());
  for (RowTable* half : {&even, &odd}) half->add_channel({"weight", "/wrench/l/force", "N", "link", "pelvis"}, {scale, zero});
  for (int i = 0; i < 600; ++i) {
    const double bears = 250 + 250 * std::sin(0.05 * i);
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, i < 400 ? 0 : 1, i / 12, 0, i < 400, 1, 1.0 + 0.001 * (i % 7)});
      half->begin_row(0, (is_scale ? 0.06 * bears : 30) + normal(random), 500), half->add(0, scale, bears), half->add(0, zero, 1);
      half->end_cell();
    }
  }
  for (RowTable* half : {&even, &odd}) half->finish();
  LeggedFitter fitter(merge_halves(even, odd), layout.count());
  Candidate fault = make_candidate(of_scale ? EffectId::kSensorScale : EffectId::kSensorBias, "", {{{of_scale ? scale : zero, 1.0}}});
  fault.place = 0, fault.where = {{"sensor", "/wrench/l/force"}};
  fitter.update_weights(fitter.fit({fault}));
  return is_steady(list_regimes(fitter, fitter.fit({fault}), 0, layout));
}

TEST(LeggedRegimes, AZeroOfAForceThatGrowsWithWhatTheFootBearsIsNone) {
  EXPECT_FALSE(is_fault_steady(true, false));
  EXPECT_TRUE(is_fault_steady(true, true));
  EXPECT_TRUE(is_fault_steady(false, false));
}

TEST(LeggedRegimes, CalmAndRoughRowsThatDisagreeAreTwoCauses) {
  EXPECT_TRUE(is_alike({{"calm", 0.8, 0.1, 0.5}, {"rough", 1.3, 0.1, 0.5}}));
  EXPECT_FALSE(is_alike({{"calm", 0.6, 0.1, 0.5}, {"rough", 1.8, 0.1, 0.5}}));
  EXPECT_TRUE(is_alike({{"calm", 0.6, 0.45, 0.5}, {"rough", 1.8, 0.45, 0.5}}));  // by chance
}

// A leg of 8 kg falls onto its sole at 0.1 to 0.3 m/s and is then pressed by up to 300 N more, m z'' = weight + leg - F,
// F = kz z + cz z' while that is positive. The other foot is rigid. Force and height have noise of 0.5 N and 20 um. A sole
// that is `rigid` makes the same force and does not sink.
std::vector<Landing> make_landings(double kz, double cz, bool rigid, double rate) {
  constexpr double kMass = 8, kFine = 2e-5, kTouch = 0.1, kEnd = 0.25;
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  std::vector<Landing> out;
  for (int i = 0; i < 12; ++i) {
    Landing l;
    l.step = 1 / rate, l.foot = 0, l.other = 1;
    const double start = kTouch + 0.1 * i * l.step;  // anywhere between two samples
    double z = 0, v = 0.1 + 0.05 * (i % 5), next = 0;
    for (double t = 0; t < kEnd; t += kFine) {
      const double force = t >= start ? std::max(0.0, kz * z + cz * v) : 0;
      if (t >= next) {
        l.force.push_back(force + 0.5 * normal(random)), l.others.push_back(300 - force + 0.5 * normal(random));
        l.height.push_back(0.01 * i - (rigid ? 0 : z) + 2e-5 * normal(random)), l.flat.push_back(force > 50);
        next += l.step;
      }
      if (t < start) continue;
      v += kFine * (9.81 + (300 * std::min(1.0, (t - start) / 0.05) - force) / kMass), z += kFine * v;
    }
    out.push_back(std::move(l));
  }
  return out;
}

TEST(LeggedLandings, OfAMassOnASpringAndADamperTellBoth) {
  for (const double rate : {250.0, 500.0}) {
    const std::vector<SoleLaw> laws = fit_landings(make_landings(9e4, 350, false, rate), {1, 0});
    ASSERT_GT(laws[0].landings, 0u);
    EXPECT_EQ(laws[1].landings, 0u);
    EXPECT_NEAR(laws[0].kz, 9e4, 1.96 * laws[0].kz_std);
    EXPECT_NEAR(laws[0].cz, 350, 1.96 * laws[0].cz_std);
    EXPECT_LT(laws[0].kz_std, 0.02 * 9e4);
    EXPECT_LT(laws[0].cz_std, 0.15 * 350);
  }
}

TEST(LeggedLandings, OnARigidSoleTellNothing) {
  const std::vector<SoleLaw> laws = fit_landings(make_landings(9e4, 350, true, 250), {1, 0});
  std::vector<Estimate> sole;
  EXPECT_FALSE(put_law(laws[0], &sole));
  EXPECT_TRUE(sole.empty());
}

// Stances that say another stiffness than landings do are right: they need no lag.
TEST(LeggedLandings, MustAgreeWithStances) {
  const SoleLaw law{9e4, 1e3, 350, 30, 12};
  std::vector<Estimate> near{{"kz", "N/m", {9.3e4}, {5e3}, false}}, far{{"kz", "N/m", {2e5}, {5e3}, false}};
  ASSERT_TRUE(put_law(law, &near));
  ASSERT_EQ(near.size(), 2u);
  EXPECT_EQ(near[0].value[0], 9e4);
  EXPECT_EQ(near[1].name, "cz");
  EXPECT_FALSE(put_law(law, &far));
  EXPECT_EQ(far.size(), 1u);
}

TEST(LeggedChecks, RecordingsThatDifferAreSetAside) {
  const Consensus k = find_consensus({1.026, 0.95, 1.031, 1.033}, 0.008);
  EXPECT_EQ(k.odd, 1u);
  EXPECT_NEAR(k.mean, 1.03, 1e-3);
}

// Other people's recordings and cases, beside the tree.
Evidence diagnose_shared(const std::string& folder, bool* there) {
  const std::filesystem::path path = std::filesystem::path(HRP_SOURCE_DIR) / "../shared" / folder / "experiment.yaml";
  *there = std::filesystem::exists(path);
  return *there ? diagnose_legged(load_experiment(path.string()), nullptr).evidence : Evidence{};
}

TEST(LeggedShared, LoadOnTheChestOfAWalkingRobotHasItsMassAndPlace) {
  bool there = false;
  const Evidence e = diagnose_shared("cases/open/walk-03", &there);
  if (!there) GTEST_SKIP() << "no open cases beside the tree, NOTHING was checked";
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "payload");
  EXPECT_EQ(e.findings[0].where.at("link"), "CHEST");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 4.83, 0.1);  // 2 %
}

TEST(LeggedShared, RotorsOfBothKneesAreNamedFromAWalk) {
  bool there = false;
  const Evidence e = diagnose_shared("cases/open/walk-04", &there);
  if (!there) GTEST_SKIP() << "no open cases beside the tree, NOTHING was checked";
  ASSERT_EQ(e.findings.size(), 2u);
  for (const Finding& f : e.findings) {
    EXPECT_EQ(f.effect, "rotor_inertia");
    EXPECT_NE(f.where.at("joint").get<std::string>().find("KNEE"), std::string::npos);
  }
}

// Forces logged at 50 Hz beside faster encoders: the kernel that this asks for is longer than the swings of a trot, and
// what it brings in of the stance is no zero.
TEST(LeggedShared, StanceThatTheKernelBringsIntoSwingsIsNoZero) {
  const std::filesystem::path path = std::filesystem::path(HRP_SOURCE_DIR) / "../shared/recordings/go1_walk/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no recordings beside the tree, NOTHING was checked";
  Experiment e = load_experiment(path.string());
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      if (name.rfind("/wrench", 0) != 0) continue;
      for (size_t k = 1; k < column.size(); ++k) {
        if (std::floor(50 * r.time[k]) == std::floor(50 * r.time[k - 1])) column[k] = column[k - 1];
      }
    }
  }
  for (const Finding& f : diagnose_legged(e, nullptr).evidence.findings) EXPECT_NE(f.effect, "sensor_bias") << f.statement;
}

TEST(LeggedShared, WeightOfARealHumanoidIsAmbiguousAndNothingIsSaidOfItsDrives) {
  bool there = false;
  const Evidence e = diagnose_shared("recordings/icub_walking", &there);
  if (!there) GTEST_SKIP() << "no recordings beside the tree, NOTHING was checked";
  const auto weight = std::find_if(e.findings.begin(), e.findings.end(), [](const Finding& f) { return f.family == "mass and its place"; });
  ASSERT_NE(weight, e.findings.end());
  EXPECT_EQ(weight->grade, Grade::kAmbiguous);
  EXPECT_GE(weight->alternatives.size(), 3u);
  for (const Finding& f : e.findings) EXPECT_EQ(f.effect.find("friction"), std::string::npos);
  // Its feet share the load as the zero-moment point asks: correlations of .72 to .98 in the four recordings, one by one.
  EXPECT_TRUE(std::any_of(e.warnings.begin(), e.warnings.end(), [](const std::string& w) { return w.rfind("load share: ", 0) == 0; }));
}

// 10 N downwards 2 m ahead of the base: a moment of 20 N m about y holds it; the point is there, whatever plane is asked.
TEST(LoadShare, TheZeroMomentPointIsWhereAWeightHangs) {
  const Vector3d force(0, 0, 10), at(2, 0.3, -0.5);
  const Vector3d p = calc_zero_moment_point(at.cross(force), force, Vector3d::UnitZ(), Vector3d(0, 0, -0.9));
  EXPECT_LT((p - Vector3d(2, 0.3, -0.9)).norm(), 1e-12);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
