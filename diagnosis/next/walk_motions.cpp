// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/walk_motions.h"

#include <optional>

#include "common/base/diagnostics.h"
#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "common/robot/sole.h"
#include "controller/walking/pattern.h"
#include "controller/walking/stabilizer.h"
#include "controller/walking/whole_body.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis {
namespace {

// Steps and their times: long and slow, or short and quicker. Two cadences tell what goes with the speed of joints from
// what goes with the load on them. The weight moves slowly from foot to foot, because no sensor damps the sway that
// follows. On four nominal robots the zero-moment point of the slow gait stays 1.6 to 3.2 cm inside the soles.
struct Gait {
  double length, single_support, double_support;  // [m], [s], [s]
};
constexpr Gait kGaits[] = {{0.12, 0.9, 0.7}, {0.06, 0.7, 0.5}};
constexpr double kSwingHeight = 0.04;  // [m] of a foot over the ground
constexpr double kInward = 0.012;      // [m] of the planned zero-moment point: landings throw it outward
constexpr int kMostPairs = 4;          // of steps forward

// Left is where the base's y axis points.
WalkSpec make_spec(const Experiment& e, const MotionPlan& plan, double width, bool first_is_left) {
  const Gait& gait = kGaits[1 - plan.seed % 2];
  WalkSpec spec;
  spec.left_foot = e.scenario.feet[first_is_left ? 0 : 1];
  spec.right_foot = e.scenario.feet[first_is_left ? 1 : 0];
  spec.single_support = gait.single_support;
  spec.double_support = gait.double_support;
  spec.swing_height = kSwingHeight;
  spec.length = plan.size * gait.length;
  spec.zmp_y = kInward;
  spec.min_width = 0.5 * width;
  spec.max_width = 1.5 * width;
  return spec;
}

// `pairs` steps forward, as many back, and one that brings the feet together.
void list_steps(int pairs, double width, WalkSpec* spec) {
  spec->footsteps.clear();
  for (int n = 0; n <= 2 * pairs; ++n) {
    FootstepSpec step;
    step.side = n % 2 == 0 ? "right" : "left";
    step.x = n < pairs ? spec->length : n < 2 * pairs ? -spec->length : 0.0;
    step.y = n % 2 == 0 ? -width : width;
    spec->footsteps.push_back(step);
  }
}

// The pattern with the most steps that end in time, and rest for as long as it settles.
std::optional<walking::WalkPattern> make_pattern(WalkSpec spec, const walking::PatternStart& start, double zc,
                                                 double width, double seconds) {
  for (int pairs = kMostPairs; pairs > 0; --pairs) {
    list_steps(pairs, width, &spec);
    walking::WalkPattern pattern(spec, start, zc);
    if (pattern.duration() + spec.settle <= seconds) return pattern;
  }
  return std::nullopt;
}

// How far each servo yields under the weight that the pattern puts on the feet. A walk without sensors needs this: a
// hip that sags when the other foot lifts throws the zero-moment point to the edge of the sole.
class Sag {
 public:
  explicit Sag(const Experiment& e)
      : model_(e.robot.tree, e.scenario.gravity_W), data_(model_), state_(make_state(model_)), tau_(model_.nv()) {
    for (int j = 0; j < e.num_joints(); ++j)
      stiffness_.push_back(get_servo_gains(e.scenario, e.robot.tree.joint(j).name).kp);
  }

  // [rad] by joint, to be added to the commands for these positions.
  Eigen::VectorXd calc(const walking::PatternSample& now, const walking::WholeBody& body, const int links[2],
                       const Eigen::VectorXd& q) {
    state_.q = q;
    state_.R_WB = Eigen::Quaterniond(now.R_WB);
    state_.p_WB = now.com - now.R_WB * body.get_com();
    update_kinematics(model_, state_, &data_);
    const bool left = now.support != walking::Support::kRight, right = now.support != walking::Support::kLeft;
    const double weight = body.mass() * model_.gravity_W().norm();
    const walking::LoadReference loads = walking::distribute(now.zmp, now.soles, left, right, weight);
    LinkWrenches wrenches(static_cast<size_t>(model_.num_links()), Vector6d::Zero());
    for (int side : {walking::kLeft, walking::kRight}) {
      Vector6d ground;
      ground << now.soles[side].R * Vector3d(loads.torque[side].x(), loads.torque[side].y(), 0.0), 0.0, 0.0,
          loads.force[side];
      wrenches[static_cast<size_t>(links[side])] =
          calc_wrench_about_origin(data_, links[side], now.soles[side].p, ground);
    }
    calc_inverse_dynamics(model_, Eigen::VectorXd::Zero(model_.nv()), &wrenches, &data_, &tau_);
    Eigen::VectorXd sag(q.size());
    for (long j = 0; j < q.size(); ++j)
      sag[j] = stiffness_[static_cast<size_t>(j)] > 0.0 ? tau_[6 + j] / stiffness_[static_cast<size_t>(j)] : 0.0;
    return sag;
  }

 private:
  Model model_;
  Data data_;
  State state_;
  Eigen::VectorXd tau_;
  std::vector<double> stiffness_;
};

// As in the controller, the first half of the settling leads from the start pose. The motion ends the same way.
Commands play(const Experiment& e, const walking::WalkPattern& pattern, const WalkSpec& spec, double period,
              walking::WholeBody* body, const Eigen::VectorXd& start) {
  Commands out;
  out.position.resize(static_cast<size_t>(start.size()));
  const TreeSpec& tree = e.robot.tree;
  const int links[2] = {tree.frames[static_cast<size_t>(tree.find_frame(spec.left_foot))].link,
                        tree.frames[static_cast<size_t>(tree.find_frame(spec.right_foot))].link};
  Sag sag(e);
  const double end = pattern.duration() + spec.settle;
  Eigen::VectorXd q = start;
  for (size_t k = 0; static_cast<double>(k) * period <= end; ++k) {
    const double t = static_cast<double>(k) * period;
    const walking::PatternSample now = pattern.sample(t);
    body->update(q);
    if (!body->solve(now.com, now.R_WB, now.soles, &q)) return {};
    body->update(q);
    const Eigen::VectorXd command = q + sag.calc(now, *body, links, q);
    const double share = walking::calc_blend(2.0 * t / spec.settle) * walking::calc_blend((end - t) / spec.settle);
    out.time.push_back(t);
    for (size_t j = 0; j < out.position.size(); ++j) {
      const double from = start[static_cast<long>(j)];
      out.position[j].push_back(from + share * (command[static_cast<long>(j)] - from));
    }
  }
  return out;
}

}  // namespace

bool is_walking(const Experiment& experiment) {
  return floating::find_contacts(floating::make_legged_log(experiment, floating::Half::kEven)).walks;
}

Commands make_walk(const Experiment& experiment, const MotionPlan& plan, const Limits& limits, double lowered) {
  if (experiment.scenario.feet.size() != 2) return {};
  State state = make_start_state(experiment.robot, experiment.scenario);
  for (size_t j = 0; j < limits.joints.size(); ++j) state.q[static_cast<long>(j)] = limits.joints[j].start;
  try {
    for (bool first_is_left : {true, false}) {
      walking::WholeBody body(experiment.robot, make_spec(experiment, plan, 0.0, first_is_left), state.q);
      const Matrix3d R_WB = state.R_WB.toRotationMatrix();
      const walking::PatternStart start =
          walking::make_pattern_start(body, walking::calc_pattern_axes(body, R_WB) * R_WB);
      const double width = start.soles[walking::kLeft].p.y() - start.soles[walking::kRight].p.y();
      if (width <= 0.0) continue;
      const WalkSpec spec = make_spec(experiment, plan, width, first_is_left);
      const auto pattern = make_pattern(spec, start, start.com.z() - lowered, width, plan.seconds);
      return pattern ? play(experiment, *pattern, spec, plan.period, &body, state.q) : Commands{};
    }
  } catch (const InputError&) {
    // No such legs, or no such steps.
  }
  return {};
}

}  // namespace hrp::diagnosis
