// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/mounting.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/base/diagnostics.h"
#include "common/base/rounding.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/joint_zeros.h"

namespace hrp::diagnosis {
namespace {

Experiment turn_gravity(Experiment e, const Vector3d& direction) {
  e.scenario.gravity_W = e.scenario.gravity_W.norm() * direction.normalized();
  return e;
}

bool is_other(const Experiment& e, const Vector3d& g_W) {
  return std::atan2(g_W.cross(e.scenario.gravity_W).norm(), g_W.dot(e.scenario.gravity_W)) >= kMounted;
}

// Mean square of what weight and inertia leave of each judged joint's effort, with nothing else at the joints [(N
// m)^2].
std::vector<double> calc_left_squares(const TorqueData& data) {
  std::vector<double> out;
  for (size_t j = 0; j < data.source.size(); ++j) {
    const int joint = static_cast<int>(j);
    double sum = 0.0, n = 0.0;
    for (const TorqueRecording& r : data.recordings) {
      for (long k = 0; k < r.kept() && data.is_judged(joint); ++k) {
        if (r.use(k, joint)) {
          sum += std::pow(r.effort(r.full_row(k), joint) - r.tau(r.full_row(k), joint), 2);
          n += 1.0;
        }
      }
    }
    out.push_back(n > 0.0 ? sum / n : 0.0);
  }
  return out;
}

// Springs and constants stand for weight near one posture, and so for any direction of gravity. That which is right
// leaves less without them: over all joints, each by its ratio. `before`: squares under the stated one.
bool fits_bare(const std::vector<double>& before, const TorqueData& turned) {
  const std::vector<double> after = calc_left_squares(turned);
  double nats = 0.0;
  for (size_t j = 0; j < std::min(before.size(), after.size()); ++j) {
    if (before[j] > 0.0 && after[j] > 0.0) nats += std::log(before[j] / after[j]);
  }
  return nats > 0.0;
}

// The gravity that fits by least squares, if it is as large as gravity is. Zero otherwise.
Vector3d find_by_squares(const Experiment& e, const TorqueData& data) {
  const FoundGravity found = find_gravity(data);
  const double size = found.g_W.norm() / e.scenario.gravity_W.norm();
  // Gravity that efforts ask for is as large as it is.
  const bool other = found.left <= kNearlyAll && std::abs(size - 1.0) <= kMinority && is_other(e, found.g_W);
  return other ? found.g_W : Vector3d::Zero();
}

// Floors, walls and ceilings: the base's axes. Along a short motion, friction and a constant of each joint hide which
// gravity fits by least squares; its size and six directions are known beforehand.
struct Mounting {
  Vector3d g_W = Vector3d::Zero();  // zero: no other one
  ListFit by_joints;                // what effects of joints alone explain under it
};

// `before`: what weight and inertia leave under the stated gravity.
Mounting find_best(const Experiment& e, const std::vector<double>& before, int jobs) {
  Mounting best;
  for (int axis = 0; axis < 3; ++axis) {
    for (double sign : {1.0, -1.0}) {
      const Vector3d g_W = sign * Vector3d::Unit(axis);
      if (!is_other(e, g_W)) continue;
      const Experiment turned = turn_gravity(e, g_W);
      TorqueData data = make_torque_data(turned);
      if (!fits_bare(before, data)) continue;
      const ListFit own = fit_list(make_torque_design(std::move(data)), jobs, Of::kJoints);
      if (own.cross.empty() || (!best.g_W.isZero() && compare_torques(own, best.by_joints) <= 0.0)) continue;
      best = {turned.scenario.gravity_W, own};
    }
  }
  return best;
}

// A wrong direction of gravity is no detail: some joint's effort remains, whatever its drive does.
bool leaves_much(const ListFit& by_joints) {
  return std::any_of(by_joints.cross.begin(), by_joints.cross.end(), [](double left) { return left > kDetail; });
}

[[noreturn]] void refuse_gravity(const Experiment& e, const Vector3d& g_W) {
  const auto digits = [](double x) { return number(std::round(x * 100.0) / 100.0 + 0.0, 3); };  // no "-0"
  throw InputError(e.scenario.make_diagnostic(
      "gravity", "does not fit the efforts, which are those of gravity [" + digits(g_W.x()) + ", " + digits(g_W.y()) +
                     ", " + digits(g_W.z()) + "] m/s^2: is the robot mounted otherwise?"));
}

}  // namespace

// No load and no force is named for a robot that hangs on a wall.
void check_mounting(const Experiment& e, int jobs) {
  const TorqueData data = make_torque_data(e);
  if (data.recordings.empty() || e.scenario.gravity_W.norm() == 0.0) return;
  const Vector3d squares = find_by_squares(e, data);
  const TorqueDesign design = make_torque_design(TorqueData(data));
  const std::vector<double> before = calc_left_squares(data);
  if (!squares.isZero()) {
    const Experiment turned = turn_gravity(e, squares);
    TorqueData other = make_torque_data(turned);
    const bool bare = fits_bare(before, other);
    if (bare &&
        compare_torques(fit_list(make_torque_design(std::move(other)), jobs), fit_list(design, jobs)) >= kWholeGain)
      refuse_gravity(e, turned.scenario.gravity_W);
  }
  const ListFit by_joints = fit_list(design, jobs, Of::kJoints);
  if (!leaves_much(by_joints)) return;
  // One of six would beat a rich set of effects by chance, if it had the same effects: it has to do without loads and
  // forces.
  const Mounting best = find_best(e, before, jobs);
  if (best.g_W.isZero() || compare_torques(best.by_joints, by_joints) < kWholeGain) return;
  if (compare_torques(best.by_joints, fit_list(design, jobs)) >= kWholeGain) refuse_gravity(e, best.g_W);
}

void check_gravity_beside(const Experiment& e, const std::vector<ListFit>& others, int jobs) {
  const Mounting best = find_best(e, calc_left_squares(make_torque_data(e)), jobs);
  const auto beats = [&](const ListFit& other) { return compare_torques(best.by_joints, other) >= kWholeGain; };
  if (!best.g_W.isZero() && std::all_of(others.begin(), others.end(), beats)) refuse_gravity(e, best.g_W);
}

}  // namespace hrp::diagnosis
