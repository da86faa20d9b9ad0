// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/turned_efforts.h"

#include <algorithm>
#include <string>

#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/conventions/mounting.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/measurement/joint_zeros.h"

namespace hrp::diagnosis {
namespace {

// True if positions and rates of this joint with the other sign, in place of its effort, explain as much: a pendulum
// that hangs is the mirror image of itself.
bool may_be_angle(const Experiment& e, const TurnedEffort& turned, const ListFit& by_effort, int jobs) {
  const Experiment mirrored = turn_efforts(convert_zeros(e, {{turned.joint, 0.0, 0.0, true}}), {turned});
  return compare(by_effort, fit_list(mirrored, jobs)) < kWholeGain;
}

}  // namespace

Experiment turn_efforts(Experiment e, const std::vector<TurnedEffort>& turned) {
  for (const TurnedEffort& t : turned) e = turn_effort(std::move(e), t.joint);
  return e;
}

std::vector<TurnedEffort> list_efforts(const Experiment& e) {
  std::vector<TurnedEffort> all;
  for (int j = 0; j < e.num_joints(); ++j) {
    const auto has = [&](const Recording& r) { return r.joints[static_cast<size_t>(j)].has(Quantity::kEffort); };
    if (std::any_of(e.recordings.begin(), e.recordings.end(), has)) all.push_back({j});
  }
  return all;
}

void add_turned_effort(const Experiment& e, int joint, int jobs, std::vector<TurnedEffort>* turned) {
  const auto known =
      std::find_if(turned->begin(), turned->end(), [&](const TurnedEffort& t) { return t.joint == joint; });
  if (known != turned->end()) {
    turned->erase(known);
    return;
  }
  TurnedEffort one{joint};
  const std::vector<TurnedEffort> all = list_efforts(e);
  const ListFit of_one = fit_list(turn_efforts(e, {one}), jobs), of_all = fit_list(turn_efforts(e, all), jobs);
  check_gravity_beside(e, {of_one, of_all}, jobs);
  if (turned->empty() && all.size() > 1 && compare(of_all, of_one) >= kWholeGain) {
    *turned = all;
    return;
  }
  one.or_angle = may_be_angle(e, one, of_one, jobs);
  turned->push_back(one);
}

Json make_turned_finding(const Experiment& e, const TurnedEffort& turned, double share) {
  const std::string joint = e.robot.tree.joint(turned.joint).name;
  const EffectInfo& effect = get_effect_of(PlaceKind::kSensor, EffectFamily::kGain);
  const Json scale = make_value(-1.0, 0.0, "1");
  Json f = make_finding_head(effect, {{"sensor", e.signal_name(turned.joint, Quantity::kEffort)}}, {{"scale", scale}},
                             Grade::kSupported, share);
  f["of_log"] = true;
  f["statement"] = joint +
                   ": the recorded effort has the opposite sign of the torque that the motion takes. The recordings "
                   "are judged with the other sign" +
                   (turned.or_angle ? std::string("; turned positions and velocities would do the same.") : ".");
  f["alternatives"] = Json::array();
  if (turned.or_angle)
    f["alternatives"].push_back(
        state_alternative(effect, {{"sensor", e.signal_name(turned.joint, Quantity::kPosition)}}, {{"scale", scale}}));
  return f;
}

}  // namespace hrp::diagnosis
