// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_motions.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "common/multibody/momentum.h"
#include "common/robot/sole.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/next/walk_motions.h"

namespace hrp::diagnosis {
namespace {

constexpr int kWays = 6;  // of the body: forward, sideways, up; about the same three axes
constexpr double kReach[kWays] = {0.04, 0.06, 0.05, 0.1, 0.1, 0.25};  // [m], [rad] amplitudes
constexpr double kSwing = 0.4;                // [rad or m] amplitude of joints that carry no foot
constexpr double kSwungMass = 0.01;           // [m] by which a joint that swings may move the centre of mass
constexpr double kBodySpeed[2] = {0.4, 1.0};  // [m/s], [rad/s]
constexpr double kClose = 1e-5;               // [m and rad] tolerance of a foot's pose
constexpr double kDamping = 1e-8;             // regularisation of the inverted squares
// Knees that are nearly straight leave the body no way up or aside. It is lowered first, by the least of these shares
// of its height that does, and raised at the end.
constexpr double kLowered[] = {0.0, 0.03, 0.06, 0.1};
constexpr double kLowering = 1.5;  // [s]

// 0 at both ends of a motion, 1 from kLowering [s] on, with a continuous rate.
double calc_share_lowered(double time, double end) {
  const double x = std::clamp(std::min(time, end - time) / kLowering, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

// Limits of a robot whose joints are the directions of the body.
Limits make_body_limits(double size) {
  Limits body;
  for (int i = 0; i < kWays; ++i) {
    JointLimits way;
    way.lower = -size * kReach[i];
    way.upper = size * kReach[i];
    way.speed = kBodySpeed[i / 3];
    body.joints.push_back(way);
  }
  return body;
}

std::vector<char> find_ways(Family family) {
  switch (family) {
    case Family::kSway: return {0, 1, 0, 0, 0, 0};
    case Family::kLean: return {1, 0, 0, 0, 0, 0};
    case Family::kSquat: return {0, 0, 1, 0, 0, 0};
    case Family::kTurn: return {0, 0, 0, 1, 1, 1};
    case Family::kSwing: return {0, 0, 0, 0, 0, 0};
    default: return {1, 1, 1, 1, 1, 1};
  }
}

// Limits of joints that swing by this share of their amplitude. `com_rates`: by joint, how far the centre of mass moves
// [m] per rad or m.
Limits make_swing_limits(Limits limits, const std::vector<double>& com_rates, double size) {
  for (size_t j = 0; j < limits.joints.size(); ++j) {
    JointLimits& joint = limits.joints[j];
    const double most = size * std::min(kSwing, kSwungMass / std::max(1e-9, com_rates[j]));
    joint.lower = std::max(joint.lower, joint.start - most);
    joint.upper = std::min(joint.upper, joint.start + most);
  }
  return limits;
}

// Keeps all feet in place by Newton steps of the joints.
class Legs {
 public:
  Legs(const Experiment& e, const Limits& limits) : model_(e.robot.tree, e.scenario.gravity_W), data_(model_) {
    state_ = make_start_state(e.robot, e.scenario);
    for (size_t j = 0; j < limits.joints.size(); ++j) state_.q[static_cast<long>(j)] = limits.joints[j].start;
    start_ = state_.p_WB;
    upright_ = state_.R_WB;
    update_kinematics(model_, state_, &data_);
    for (const std::string& foot : e.scenario.feet) {
      frames_.push_back(e.robot.tree.find_frame(foot));
      if (frames_.back() >= 0) targets_.push_back(calc_frame_pose(model_, data_, frames_.back()));
    }
  }

  // Moves the body by `moved` [m] and turns it by `turned` [rad], an axis times an angle, both in W. Returns false if a
  // foot cannot stay in place.
  bool follow(const Vector3d& moved, const Vector3d& turned) {
    if (targets_.empty() || targets_.size() != frames_.size()) return false;
    const double angle = turned.norm();
    const Vector3d axis = angle > 0.0 ? Vector3d(turned / angle) : Vector3d::UnitZ();
    state_.p_WB = start_ + moved;
    state_.R_WB = Eigen::AngleAxisd(angle, axis) * upright_;
    for (int i = 0; i < kRounds; ++i) {
      const Eigen::VectorXd error = calc_error();
      if (error.lpNorm<Eigen::Infinity>() < kClose) return true;
      const Eigen::MatrixXd J = calc_jacobian();
      const Eigen::MatrixXd A = J * J.transpose() + kDamping * Eigen::MatrixXd::Identity(J.rows(), J.rows());
      state_.q += J.transpose() * A.ldlt().solve(error);
    }
    return calc_error().lpNorm<Eigen::Infinity>() < kClose;
  }

  const Eigen::VectorXd& q() const { return state_.q; }

  // [m per rad or m] by joint: speed of the centre of mass at unit rate, with the base at rest.
  std::vector<double> calc_com_rates() {
    update_kinematics(model_, state_, &data_);
    Eigen::MatrixXd J(3, 6 + state_.q.size());
    calc_centre_of_mass_jacobian(model_, &data_, J);
    std::vector<double> rates;
    for (long j = 0; j < state_.q.size(); ++j) rates.push_back(J.col(6 + j).norm());
    return rates;
  }

  // [m] of the base above its feet.
  double calc_height() const {
    double height = 0.0;
    for (const Transform& foot : targets_) height = std::max(height, start_.z() - foot.p.z());
    return height;
  }

  // Whether a joint moves no foot.
  std::vector<char> find_free() {
    update_kinematics(model_, state_, &data_);
    const Eigen::RowVectorXd largest = calc_jacobian().cwiseAbs().colwise().maxCoeff();
    std::vector<char> free;
    for (double most : largest) free.push_back(most < kClose);
    return free;
  }

 private:
  Eigen::VectorXd calc_error() {
    update_kinematics(model_, state_, &data_);
    Eigen::VectorXd error(6 * static_cast<long>(frames_.size()));
    for (size_t f = 0; f < frames_.size(); ++f) {
      const Transform now = calc_frame_pose(model_, data_, frames_[f]);
      const Eigen::AngleAxisd turn(Matrix3d(targets_[f].R * now.R.transpose()));
      error.segment<3>(6 * static_cast<long>(f)) = turn.angle() * turn.axis();
      error.segment<3>(6 * static_cast<long>(f) + 3) = targets_[f].p - now.p;
    }
    return error;
  }

  Eigen::MatrixXd calc_jacobian() const {
    const long n = state_.q.size();
    Eigen::MatrixXd J(6 * static_cast<long>(frames_.size()), n), whole(6, 6 + n);
    for (size_t f = 0; f < frames_.size(); ++f) {
      calc_frame_jacobian(model_, data_, frames_[f], whole);
      J.middleRows(6 * static_cast<long>(f), 6) = whole.rightCols(n);
    }
    return J;
  }

  Model model_;
  Data data_;
  State state_;
  Vector3d start_;
  Eigen::Quaterniond upright_;
  std::vector<int> frames_;
  std::vector<Transform> targets_;
};

// Adds the velocities of the commands; returns false if a limit would be exceeded.
bool finish(const Limits& limits, double period, Commands* out) {
  for (size_t j = 0; j < limits.joints.size(); ++j) {
    const std::vector<double>& q = out->position[j];
    std::vector<double> v = calc_rates(q, period);
    for (size_t k = 0; k < q.size(); ++k) {
      if (q[k] < limits.joints[j].lower - kClose || q[k] > limits.joints[j].upper + kClose ||
          std::abs(v[k]) > limits.joints[j].speed)
        return false;
    }
    out->velocity.push_back(std::move(v));
  }
  return true;
}

// Joints that carry no foot, as far as the plan and its family move them.
std::vector<char> find_swinging(Legs& legs, const MotionPlan& plan, const Limits& limits) {
  std::vector<char> moves = legs.find_free();
  const bool any = plan.family == Family::kSwing || plan.family == Family::kStir;
  for (size_t j = 0; j < moves.size(); ++j)
    moves[j] = any && j < plan.moves.size() && plan.moves[j] && moves[j] && limits.joints[j].mimic.joint < 0;
  return moves;
}

// Positions of all joints while the body goes these ways, lowered by `lowered` [m]. No samples if a leg does not reach.
Commands follow(Legs legs, const Commands& ways, double lowered) {
  Commands out;
  out.position.resize(static_cast<size_t>(legs.q().size()));
  for (size_t k = 0; k < ways.time.size(); ++k) {
    const double down = lowered * calc_share_lowered(ways.time[k], ways.time.back());
    const auto at = [&](size_t way) { return ways.position[way][k]; };
    if (!legs.follow({at(0), at(1), at(2) - down}, {at(3), at(4), at(5)})) return {};
    for (size_t j = 0; j < out.position.size(); ++j) out.position[j].push_back(legs.q()[static_cast<long>(j)]);
  }
  out.time = ways.time;
  return out;
}

}  // namespace

std::vector<MotionPlan> list_stance_plans(const std::vector<Family>& families, size_t joints, double seconds) {
  constexpr unsigned kSlow = 3, kGaits = 2;
  std::vector<MotionPlan> plans;
  for (Family family : families) {
    for (unsigned seed = 1; seed <= (family == Family::kWalk ? kGaits : kSlow); ++seed) {
      MotionPlan plan;
      plan.family = family;
      plan.seed = seed;
      plan.seconds = seconds;
      plan.period = kPeriod;
      plan.moves.assign(joints, 1);
      if (seed == kSlow) plan.quickest = kSlowSines;
      plans.push_back(plan);
    }
  }
  return plans;
}

Commands make_stance_motion(const Experiment& experiment, const MotionPlan& plan, const Limits& limits) {
  MotionPlan body = plan;
  body.family = plan.seed % 2 == 1 ? Family::kMultisine : Family::kPostures;
  body.moves = find_ways(plan.family);
  body.size = 1.0;
  const Commands ways = make_motion(body, make_body_limits(plan.size));
  Legs legs(experiment, limits);
  MotionPlan limbs = body;
  limbs.moves = find_swinging(legs, plan, limits);
  if (plan.family == Family::kSwing && std::count(limbs.moves.begin(), limbs.moves.end(), 1) == 0) return {};
  const Commands swings = make_motion(limbs, make_swing_limits(limits, legs.calc_com_rates(), plan.size));
  for (double share : kLowered) {
    const double lowered = share * legs.calc_height();
    Commands out = plan.family == Family::kWalk ? make_walk(experiment, plan, limits, lowered)
                                                : follow(Legs(experiment, limits), ways, lowered);
    for (size_t j = 0; j < out.position.size(); ++j) {
      if (limbs.moves[j]) out.position[j] = swings.position[j];
    }
    if (!out.time.empty()) follow_leaders(limits, &out.position, false);
    if (!out.time.empty() && finish(limits, plan.period, &out)) return out;
  }
  return {};
}

}  // namespace hrp::diagnosis
