// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/held_commands.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/rivals.h"

namespace hrp::diagnosis {
namespace {

// Of viscous friction [N m s/rad] or of a rotor [kg m^2]; 0 of others.
double calc_bound(const GradedTerm& g, const ServoGains& gains, double period) {
  if (is_viscous(g.term)) return 0.5 * period * gains.kp;
  return is_rotor(g.term) ? 0.5 * period * gains.kd : 0.0;
}

}  // namespace

bool may_hold_commands(const Experiment& e, int joint) {
  if (e.scenario.drive != "servo") return false;
  return std::any_of(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) {
    const JointColumns& c = r.joints[static_cast<size_t>(joint)];
    return !c.command.empty() && c.command_rate.empty();
  });
}

// From one command to the next, the torque falls evenly by kp T v about its mean. Its second integral over the period
// is the ripple: v (1 - kp T^2 / (12 I)) at the ends of the period, half as much above the mean in its middle.
double calc_rippling_inertia(const Experiment& e, int joint, double scale) {
  if (!may_hold_commands(e, joint) || scale == 1.0) return 0.0;
  const double kp = get_servo_gains(e.scenario, e.robot.tree.joint(joint).name).kp;
  const double inertia = kp * e.sample_time * e.sample_time / (12.0 * std::abs(1.0 - scale));
  return inertia < calc_own_inertia(e.robot.tree, joint) ? 0.0 : inertia;
}

void widen_by_held_commands(const TorqueDesign& design, std::vector<GradedTerm>* graded) {
  const Experiment& e = *design.data->experiment;
  for (GradedTerm& g : *graded) {
    if (g.place.joint < 0) continue;
    const int joint = design.joints[static_cast<size_t>(g.place.joint)].joint;
    if (!may_hold_commands(e, joint)) continue;
    const double bound = calc_bound(g, get_servo_gains(e.scenario, e.robot.tree.joint(joint).name), e.sample_time);
    if (!(bound > 0.0)) continue;
    // The instant is the same in all recordings: a systematic error, which adds linearly.
    g.width[0] += bound / kNinetyFive;
    if (g.grade == Grade::kAmbiguous || std::abs(g.parameters[0]) > kNinetyFive * g.width[0]) continue;
    g.grade = Grade::kAmbiguous;
    g.doubt = "commands that the servo holds between two samples push by as much";
  }
}

}  // namespace hrp::diagnosis
