// SPDX-License-Identifier: BSD-3-Clause
// Four legs with torques, encoders and an IMU carry a body that sways, and no sensor feels the ground.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "common/spatial/transform.h"
#include "diagnosis/floating/conventions/turned_efforts.h"
#include "diagnosis/floating/diagnose.h"
#include "diagnosis/floating/equations/leg_forces.h"
#include "diagnosis/floating/equations/leg_friction.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kStep = 0.008, kDuration = 8, kHeight = 0.3, kBall = 0.02;
const char* const kLegs[] = {"fl", "fr", "rl", "rr"};

std::string make_joint(const std::string& leg, const std::string& name, const std::string& parent,
                       const std::string& child, const std::string& xyz, const std::string& axis) {
  return "<joint name=\"" + leg + name + "\" type=\"revolute\"><parent link=\"" + parent + "\"/><child link=\"" + leg +
         child + "\"/><origin xyz=\"" + xyz + "\"/><axis xyz=\"" + axis +
         "\"/><limit lower=\"-3\" upper=\"3\" effort=\"90\" velocity=\"20\"/></joint>";
}

std::string make_urdf() {
  std::string out = "<robot name=\"four\">" + make_link("trunk", 7, 0);
  const std::string at[] = {"0.2 0.05 0", "0.2 -0.05 0", "-0.2 0.05 0", "-0.2 -0.05 0"};
  for (int l = 0; l < 4; ++l) {
    const std::string leg = kLegs[l], out_y = l % 2 == 0 ? "0 0.08 0" : "0 -0.08 0";
    out += make_link(leg + "_hip", 0.6, 0) + make_link(leg + "_thigh", 1, -0.05) +
           make_link(leg + "_foot", 0.3, -0.1,
                     "<collision><origin xyz=\"0 0 -0.2\"/><geometry><sphere radius=\"0.02\"/></geometry></collision>");
    out += make_joint(leg, "_roll", "trunk", "_hip", at[l], "1 0 0") +
           make_joint(leg, "_pitch", leg + "_hip", "_thigh", out_y, "0 1 0") +
           make_joint(leg, "_knee", leg + "_thigh", "_foot", "0 0 -0.2", "0 1 0");
  }
  return out + "</robot>";
}

// What is hidden: a load [kg] on the trunk at `place` [m], a factor of all logged efforts, what the front left leg's
// pitch joint reads too much [rad], what its effort does [N m], and a joint whose effort is logged with the other sign.
struct Off {
  double load = 0, efforts = 1;
  Vector3d place{0, 0, 0};
  double zero = 0, constant = 0;
  int turned = -1;
};
constexpr int kPitch = 1;

class Quadruped {
 public:
  explicit Quadruped(const Off& off) : off_(off) {
    e_.scenario = parse_scenario(
        "robot: four.urdf\nbase: floating\ndrive: effort\nfeet: [fl_foot, fr_foot, rl_foot, rr_foot]\n"
        "sensors: {imu: {body: {link: trunk}}}\n",
        "four.yaml");
    e_.robot = parse_robot(make_urdf(), "four.urdf", e_.scenario);
    e_.path = "four.yaml";
    e_.sample_time = kStep;
    TreeSpec tree = e_.robot.tree;
    LinkInertia& trunk = tree.links[0].inertia;
    const Vector3d c = off.load / (trunk.mass + off.load) * off.place;
    const double reduced = trunk.mass * off.load / (trunk.mass + off.load);
    trunk.I_LLcm_L += reduced * (off.place.squaredNorm() * Matrix3d::Identity() - off.place * off.place.transpose());
    trunk.mass += off.load;
    trunk.p_LLcm_L = c;
    model_ = std::make_unique<Model>(tree, e_.scenario.gravity_W);
    for (const char* leg : kLegs) feet_.push_back(tree.find_link(std::string(leg) + "_foot"));
  }

  Experiment run() {
    for (int r = 0; r < 3; ++r) add_recording(r);
    return e_;
  }

 private:
  // Place and attitude of the trunk over feet that stand.
  Transform find_pose(double t) const {
    const double s = turn_;
    const Vector3d p(0.03 * std::sin(2.1 * t + s), 0.02 * std::sin(1.7 * t + 2 * s),
                     kHeight + 0.015 * std::sin(3.3 * t + s));
    return {
        make_rotation_from_rpy({0.06 * std::sin(1.9 * t), 0.07 * std::sin(2.3 * t + s), 0.06 * std::sin(1.3 * t + s)}),
        p};
  }

  Vector3d find_ball(const Data& data, size_t f) const { return get_pose(data, feet_[f]) * Vector3d(0, 0, -0.2); }

  // Joints by Newton's method, from those of the sample before.
  Eigen::VectorXd find_joints(double t, Eigen::VectorXd q) {
    State state = make_state(*model_);
    Data data(*model_);
    const Transform X = find_pose(t);
    state.p_WB = X.p;
    state.R_WB = Eigen::Quaterniond(X.R);
    Eigen::MatrixXd J(6, model_->nv());
    for (int i = 0; i < 8; ++i) {
      state.q = q;
      update_kinematics(*model_, state, &data);
      for (size_t f = 0; f < feet_.size(); ++f) {
        const double side = f % 2 == 0 ? 1 : -1, front = f < 2 ? 1 : -1;
        const Vector3d p = find_ball(data, f), goal(0.2 * front, 0.13 * side, kBall);
        calc_point_jacobian(*model_, data, feet_[f], p, J);
        const auto at = static_cast<long>(3 * f);
        q.segment<3>(at) += Matrix3d(J.block<3, 3>(3, 6 + at)).lu().solve(goal - p);
      }
    }
    return q;
  }

  void add_recording(int r) {
    turn_ = r;
    Recording out;
    out.spec.name = "sway_" + std::to_string(r) + ".csv";
    out.spec.train = r < 2;
    out.joints.resize(12);
    Eigen::VectorXd q(12);
    for (int f = 0; f < 4; ++f) q.segment<3>(3 * f) = Vector3d(0, 0.7, -1.4);
    for (double t = 0; t < kDuration; t += kStep) q = add_sample(t, q, &out);
    e_.recordings.push_back(std::move(out));
  }

  Eigen::VectorXd add_sample(double t, const Eigen::VectorXd& near, Recording* out) {
    constexpr double h = 1e-3;
    Eigen::VectorXd q = find_joints(t, near);
    const Eigen::VectorXd before = find_joints(t - h, q), after = find_joints(t + h, q);
    const Transform X = find_pose(t), X_before = find_pose(t - h), X_after = find_pose(t + h);
    const auto rate = [&](const Matrix3d& from, const Matrix3d& to, double dt) -> Vector3d {
      const Eigen::AngleAxisd turn(Matrix3d(to * from.transpose()));
      return turn.axis() * turn.angle() / dt;
    };
    State state = make_state(*model_);
    Eigen::VectorXd vdot(model_->nv()), tau(model_->nv());
    state.R_WB = Eigen::Quaterniond(X.R);
    state.p_WB = X.p;
    state.q = q;
    state.qd = (after - before) / (2 * h);
    state.V_WB << rate(X_before.R, X_after.R, 2 * h), (X_after.p - X_before.p) / (2 * h);
    vdot << (rate(X.R, X_after.R, h) - rate(X_before.R, X.R, h)) / h, (X_after.p - 2 * X.p + X_before.p) / (h * h),
        (after - 2 * q + before) / (h * h);
    Data data(*model_);
    update_kinematics(*model_, state, &data);
    calc_inverse_dynamics(*model_, vdot, nullptr, &data, &tau);
    subtract_ground(data, &tau);
    out->time.push_back(t);
    const Vector3d felt = X.R.transpose() * (vdot.segment<3>(3) - e_.scenario.gravity_W),
                   w = X.R.transpose() * state.V_WB.head<3>();
    for (int i = 0; i < 3; ++i) {
      out->other[std::string("/imu/body/angular_velocity/") + "xyz"[i]].push_back(w(i) + 1e-3 * normal_(random_));
      out->other[std::string("/imu/body/linear_acceleration/") + "xyz"[i]].push_back(felt(i) + 0.02 * normal_(random_));
    }
    for (int j = 0; j < 12; ++j) {
      JointColumns& c = out->joints[static_cast<size_t>(j)];
      c.signal[0].push_back(q(j) + (j == kPitch ? off_.zero : 0.0) + 2e-5 * normal_(random_));
      c.signal[2].push_back((j == off_.turned ? -1 : off_.efforts) * tau(6 + j) + (j == kPitch ? off_.constant : 0.0) +
                            0.05 * normal_(random_));
    }
    return q;
  }

  // The least forces on the balls' lowest points that carry the whole.
  void subtract_ground(const Data& data, Eigen::VectorXd* tau) const {
    Eigen::MatrixXd J(12, model_->nv()), one(6, model_->nv());
    for (size_t f = 0; f < feet_.size(); ++f) {
      calc_point_jacobian(*model_, data, feet_[f], find_ball(data, f) - Vector3d(0, 0, kBall), one);
      J.middleRows<3>(static_cast<long>(3 * f)) = one.bottomRows<3>();
    }
    const Eigen::MatrixXd B = J.leftCols(6).transpose();
    const Eigen::VectorXd force = B.transpose() * (B * B.transpose()).ldlt().solve(tau->head<6>());
    *tau -= J.transpose() * force;
  }

  Off off_;
  Experiment e_;
  std::unique_ptr<Model> model_;
  std::vector<int> feet_;
  double turn_ = 0;
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

Evidence diagnose(const Off& off) { return diagnose_legged(Quadruped(off).run(), nullptr).evidence; }

TEST(ForcesOfLegs, LeaveNoForceOfTheGroundInTheBalanceOfTheBody) {
  Eigen::MatrixXd A(3, 3);
  A << 0.2, 0.05, 0.3, -0.25, 0.1, 0.02, 0.04, 0.3, -0.1;
  const Eigen::MatrixXd B = Eigen::MatrixXd::Random(6, 3);
  const Vector3d force(12, -7, 60);
  const Eigen::MatrixXd share = calc_share_of_base(A, B, 0.3);
  ASSERT_EQ(share.cols(), 3);
  EXPECT_LT((-B * force - share * (-A * force)).norm(), 1e-9);
}

TEST(ForcesOfLegs, AreNotToldByALegThatIsStraightOrHasTooFewJoints) {
  Eigen::MatrixXd A = 0.3 * Eigen::MatrixXd::Identity(3, 3);
  A(2, 2) = 0.01;  // [m] of a force along the leg: its torques are errors
  EXPECT_EQ(calc_share_of_base(A, Eigen::MatrixXd::Zero(6, 3), 0.3).size(), 0);
  EXPECT_EQ(calc_share_of_base(A.topRows(2), Eigen::MatrixXd::Zero(6, 3), 0.3).size(), 0);
}

TEST(ForcesOfLegs, CarryWhatTheModelWeighsAndNameNothing) { EXPECT_TRUE(diagnose({}).findings.empty()); }

TEST(ForcesOfLegs, NameALoadOnTheTrunkAndItsPlaceWithoutForceSensors) {
  const Vector3d place(0.1, 0.04, 0.05);
  const Evidence evidence = diagnose({.load = 2, .place = place});
  ASSERT_EQ(evidence.findings.size(), 1u);
  const Finding& load = evidence.findings[0];
  EXPECT_EQ(load.effect, "payload");
  EXPECT_EQ(load.where.at("link"), "trunk");
  EXPECT_NEAR(load.parameters[0].value[0], 2, 0.1);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(load.parameters[1].value[static_cast<size_t>(i)], place(i), 0.01);
}

TEST(ForcesOfLegs, TellAFactorOfAllEffortsOnlyBesideAWrongMass) {
  const Evidence evidence = diagnose({.efforts = 1.25});
  ASSERT_FALSE(evidence.findings.empty());
  const Finding& f = evidence.findings[0];
  const bool named = f.effect == "sensor_scale" && f.where.at("sensor") == "/joint_states";
  const bool listed = std::any_of(f.alternatives.begin(), f.alternatives.end(), [](const Alternative& a) {
    return a.where.contains("sensor") && a.where.at("sensor") == "/joint_states";
  });
  EXPECT_TRUE(named || listed) << f.statement;
  EXPECT_EQ(f.grade, Grade::kAmbiguous) << f.statement;
}

TEST(ForcesOfLegs, NameTheZeroOfAThighsEncoder) {
  const Evidence evidence = diagnose({.zero = 0.04});
  ASSERT_EQ(evidence.findings.size(), 1u);
  EXPECT_EQ(evidence.findings[0].effect, "joint_offset");
  EXPECT_EQ(evidence.findings[0].where.at("joint"), "fl_pitch");
  EXPECT_NEAR(evidence.findings[0].parameters[0].value[0], 0.04, 0.005);
}

TEST(ForcesOfLegs, TellAConstantOfAnEffortOnlyBesideFrictionThatTheGearHolds) {
  const Evidence evidence = diagnose({.constant = 4});
  ASSERT_FALSE(evidence.findings.empty());
  const Finding& f = evidence.findings[0];
  EXPECT_EQ(f.where.at("sensor"), "/joint_states/fl_pitch/effort") << f.statement;
  EXPECT_TRUE(std::any_of(f.alternatives.begin(), f.alternatives.end(), [](const Alternative& a) {
    return a.effect == "coulomb_friction";
  })) << f.statement;
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
}

TEST(ForcesOfLegs, ShowAnEffortThatCountsTheOtherWay) {
  EXPECT_EQ(find_turned_efforts(Quadruped({.turned = kPitch}).run()).joints, std::vector<int>{kPitch});
}

// One equation of a joint that turns in every second row, with a lever of 2.
TEST(ForcesOfLegs, AreExactToTheFrictionThatAJointHoldsWhileItStands) {
  const LeggedLog log = make_legged_log(Quadruped({}).run(), Half::kEven);
  const ColumnLayout layout(log);
  constexpr double kFriction = 0.6, kLever = 2;
  ChannelRows c;
  c.info.equation = {EquationKind::kLegForce, 0};
  for (const int column : {kViscousColumn, kDryColumn, kLoadColumn, kRotorColumn, kGainColumn, kConstantColumn})
    c.columns.push_back(layout.joint(0, column));
  for (int i = 0; i < 400; ++i) {
    const double way = i % 2 == 0   ? 0
                       : i % 4 == 1 ? 1
                                    : -1,
                 speed = way * (1 + 0.5 * std::sin(i)), held = kFriction * std::sin(0.7 * i);
    c.x.insert(c.x.end(), {kLever * speed, kLever * way, 0, kLever * std::cos(1.3 * i), 0, kLever});
    c.y.push_back(kLever * (way == 0 ? held : way * kFriction));
    c.train.push_back(1);
    c.block.push_back(i / 20);
  }
  std::vector<ChannelRows> channels{c};
  leave_out_leg_friction(layout, &channels);
  // An even draw from -1 to 1 has a deviation of 1 / sqrt(3); half of the rows stand.
  EXPECT_NEAR(channels[0].info.error, kLever * kFriction / std::sqrt(6), 0.05);
  // One look tells none of the four losses: nobody knows what the joint may hold.
  c.block.assign(c.block.size(), 0);
  channels = {c};
  leave_out_leg_friction(layout, &channels);
  EXPECT_EQ(channels[0].info.error, 0);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
