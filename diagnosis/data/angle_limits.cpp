// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/angle_limits.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/diagnostics.h"
#include "common/base/format.h"
#include "common/base/rounding.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/range.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

std::string text_of(double value) { return format("%.3g", value); }

// Larger absolute limit of the joint [rad].
double get_reach(const JointSpec& spec) { return std::max(std::abs(spec.lower), std::abs(spec.upper)); }

// True beyond three times the joint's limits and beyond a whole turn.
bool is_far_beyond(const JointSpec& spec, double angle) {
  const double reach = get_reach(spec);
  return spec.kind == JointKind::kRevolute && std::isfinite(reach) &&
         std::abs(angle) > std::max(3.0 * reach, 2.0 * M_PI);
}

// Largest absolute reading of a joint's position; 0 without one.
double find_largest_angle(const Recording& r, int j) {
  return find_largest(r.joints[static_cast<size_t>(j)].signal[0]);
}

// True if the joint moves by a part of its range that nobody overlooks, within its limits: its log is in rad.
bool reads_radians(const Experiment& e, const Recording& r, int j) {
  const JointSpec& spec = e.robot.tree.joint(j);
  const std::vector<double>& q = r.joints[static_cast<size_t>(j)].signal[0];
  const double range = std::isfinite(get_reach(spec)) ? spec.upper - spec.lower : HUGE_VAL;
  return spec.kind == JointKind::kRevolute && !q.empty() && find_largest_angle(r, j) <= get_reach(spec) &&
         calc_range(q) > 0.25 * range;
}

// What a reading far beyond the limits may be. A log that has other joints in rad is in rad, and degrees stay within 57
// times the limits: else it is the angle of the motor, before the gear.
std::string ask_angle(const Experiment& e, const Recording& r, int j) {
  const double ratio = find_largest_angle(r, j) / get_reach(e.robot.tree.joint(j));
  bool others = false;
  for (int i = 0; i < e.num_joints(); ++i) others = others || (i != j && reads_radians(e, r, i));
  const std::string motor = "the angle of the motor, before a gear of at least " + text_of(ratio) +
                            "? Then divide it, and its velocity, by the gear's ratio";
  if (others) return "other joints of this log are in rad, so is this " + motor;
  if (!may_be_degrees(e.robot.tree.joint(j), find_largest_angle(r, j)))
    return "degrees would be beyond them, too: is this " + motor;
  return "degrees instead of rad? Or " + motor;
}

}  // namespace

double find_largest(const std::vector<double>& values) {
  double largest = 0.0;
  for (double value : values) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  }
  return largest;
}

bool may_be_degrees(const JointSpec& joint, double largest) {
  return is_far_beyond(joint, largest) && largest <= (1.0 + kDetail) * kDegrees * get_reach(joint);
}

void check_limits(const Experiment& e, const Recording& r, int j) {
  const JointSpec& spec = e.robot.tree.joint(j);
  if (!r.joints[static_cast<size_t>(j)].has(Quantity::kPosition)) return;
  const double largest = find_largest_angle(r, j);
  if (!is_far_beyond(spec, largest)) return;
  refuse_input(r.find_place(e.signal_name(j, Quantity::kPosition)),
               "reaches " + text_of(largest) + ", far beyond the joint's limits of " + text_of(get_reach(spec)) +
                   " rad: " + ask_angle(e, r, j));
}

void check_commanded_limits(Experiment* e, const Recording& r, int j) {
  const JointSpec& spec = e->robot.tree.joint(j);
  const std::vector<double>& command = r.joints[static_cast<size_t>(j)].command;
  const auto far =
      std::find_if(command.begin(), command.end(), [&](double angle) { return is_far_beyond(spec, angle); });
  if (far == command.end()) return;
  e->warnings.push_back(r.spec.name + ": /joint_commands/" + spec.name + "/position is " + text_of(*far) + " at " +
                        number(r.time[static_cast<size_t>(far - command.begin())], 6) +
                        " s, far beyond the joint's limits of " + text_of(get_reach(spec)) + " rad");
}

}  // namespace hrp::diagnosis
