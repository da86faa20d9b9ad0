// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/bristles.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// [rad or m] Range of a joint's positions, all recordings.
double calc_travel(const TorqueData& data, int joint) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const TorqueRecording& r : data.recordings) {
    if (r.q.rows() > 0) {
      low = std::min(low, r.q.col(joint).minCoeff());
      high = std::max(high, r.q.col(joint).maxCoeff());
    }
  }
  return high - low;
}

Finding* find_at(const Where& where, EffectId id, std::vector<Finding>* findings) {
  const auto at = std::find_if(findings->begin(), findings->end(),
                               [&](const Finding& f) { return f.where == where && f.effect == get_effect(id).name; });
  return at == findings->end() ? nullptr : &*at;
}

// The torque that the hysteresis yields at is friction, too; its error is that of the stiffness. How much slips at once
// is not told, so the interval reaches from that to the whole.
void join(const Experiment& e, int joint, const Finding& hysteresis, Finding* dry) {
  const Estimate &stiffness = hysteresis.parameters[0], &yield = hysteresis.parameters[1];
  std::string values;
  for (Estimate& level : dry->parameters) {
    if (level.unit != dry->parameters[0].unit) continue;  // a speed
    const double yields = stiffness.value[0] * yield.value[0],
                 error = level.std.empty() ? 0.0 : kNinetyFive * level.std[0];
    const std::pair<double, double> at_once =
        level.ends.empty() ? std::make_pair(level.value[0] - error, level.value[0] + error) : level.ends[0];
    level.value[0] += yields;
    if (!level.std.empty() && !stiffness.std.empty())
      level.std[0] = std::hypot(level.std[0], stiffness.std[0] * yield.value[0]);
    if (!level.std.empty())
      level.ends = {{at_once.first, std::max(at_once.second + yields, level.value[0] + kNinetyFive * level.std[0])}};
    values += ", " + level.name + " " + number(level.value[0], 3) + " " + level.unit;
  }
  dry->share = std::min(1.0, dry->share + hysteresis.share);
  dry->weight += hysteresis.weight;
  dry->alternatives.insert(dry->alternatives.begin(), {hysteresis.effect, hysteresis.family, hysteresis.where,
                                                       hysteresis.parameters, "small reversals about one position"});
  const JointSpec& spec = e.robot.tree.joint(joint);
  dry->statement = spec.name + ": dry friction" + values + " (" + get_grade_name(dry->grade) +
                   "). It slips gradually, within " + number(yield.value[0], 2) + " " + get_joint_unit(spec, "rad") +
                   " of a reversal. It takes away " + number(std::round(100.0 * dry->share), 3) +
                   " % of the missing torque on held-out data.";
}

}  // namespace

void join_bristles(const TorqueData& data, std::vector<Finding>* findings) {
  const Experiment& e = *data.experiment;
  for (int joint = 0; joint < e.num_joints(); ++joint) {
    const Where where = {{"joint", e.robot.tree.joint(joint).name}};
    Finding* dry = find_at(where, EffectId::kCoulomb, findings);
    if (!dry) dry = find_at(where, EffectId::kStribeck, findings);
    Finding* hysteresis = find_at(where, EffectId::kHysteresis, findings);
    if (!dry || !hysteresis || hysteresis->parameters.size() < 2) continue;
    if (hysteresis->parameters[1].value[0] > kTrace * calc_travel(data, joint)) continue;
    join(e, joint, *hysteresis, dry);
    findings->erase(findings->begin() + (hysteresis - findings->data()));
  }
}

}  // namespace hrp::diagnosis
