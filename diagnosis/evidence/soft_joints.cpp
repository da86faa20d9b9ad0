// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/soft_joints.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/odds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/gear_loads.h"
#include "diagnosis/evidence/loose_gears.h"
#include "diagnosis/measurement/soft_gears.h"
#include "diagnosis/search/significance.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kWithEffort = "the same motion with the drive's effort or current in the log";
constexpr double kLeastRotor = 1e-4;  // [kg m^2] behind which a simulation is stable

Finding make_soft_finding(const Experiment& e, const SoftGear& gear, EffortSource source) {
  const EffectInfo& row = get_effect(EffectId::kElasticity);
  const JointSpec& joint = e.robot.tree.joint(gear.joint);
  // An effort is known to kKnown, and the stiffness with it.
  const double stiffness = 1.0 / gear.give, std = stiffness * std::hypot(gear.std / gear.give, kKnown);
  Finding f = make_finding(row, {{"joint", joint.name}},
                           {make_one("stiffness", get_joint_unit(joint, "N m/rad"), stiffness, std)});
  const bool measured = source == EffortSource::kRecorded;
  f.grade = gear.applied && measured && std < stiffness / kSignificantInJoint ? Grade::kSupported : Grade::kAmbiguous;
  f.probability = kSurest;
  f.share = std::clamp(1.0 - gear.left, 0.0, 1.0);
  f.weight = f.share / e.num_joints();
  f.statement = joint.name + ": " + row.phrase + ", stiffness " + number(stiffness, 4) + " +- " +
                number(kNinetyFive * std, 2) + " " + f.parameters[0].unit + " (" + get_grade_name(f.grade) +
                "). With the links moved by its twist, the missing torque of all joints is " +
                number(100.0 * gear.left, 2) + " % of that with a rigid gear (squares), on held-out data.";
  const auto add = [&](EffectId id, const char* motion) {
    f.alternatives.push_back(make_alternative(get_effect(id), f.where, {}, motion));
  };
  if (!gear.applied) add(EffectId::kBacklash, kHeldLink);
  for (EffectId id : {EffectId::kTorqueConstant, EffectId::kLag, EffectId::kDelay}) {
    if (!measured) add(id, kWithEffort);
  }
  return f;
}

// True if some joint leaves more than efforts are known to. Below, details of laws and filters look like anything.
bool is_much_left(const TorqueDesign& design, const TorqueFit& fit) {
  for (size_t i = 0; i < design.joints.size(); ++i) {
    if (std::sqrt(fit.held[i]) > kKnown * design.joints[i].spread) return true;
  }
  return false;
}

}  // namespace

void soften_gears(int jobs, TorqueDesign* design, Choice* choice) {
  for (size_t i = 0; i < design->joints.size() && is_much_left(*design, choice->fit); ++i) {
    std::optional<SoftGear> gear = find_soft_gear(*design->data);
    if (!gear) return;
    TorqueDesign softened = make_torque_design(soften(*design->data, *gear));
    if (softened.joints.size() != design->joints.size()) return;
    const Choice again = choose_torque_model(softened, jobs);
    if (calc_gain({softened, again.model, again.fit}, {*design, choice->model, choice->fit}) < kOneValue + kWholeGain)
      return;
    gear->left = calc_held_left(softened, again.fit) / std::max(1e-300, calc_held_left(*design, choice->fit));
    if (gear->left > kLargely) return;
    if (gear->left > kHalf) {
      design->data->soft.push_back(*gear);
      continue;
    }
    softened.data->soft.back().left = gear->left;
    *design = std::move(softened);
    *choice = again;
  }
}

void add_soft_gear(const Experiment& e, const SoftGear& gear, EffortSource source, std::vector<Finding>* findings,
                   Hypothesis* model) {
  // Of a gear that was only noted, a compliance that may be zero says nothing.
  if (!gear.applied && gear.give < kNinetyFive * gear.std) return;
  findings->push_back(make_soft_finding(e, gear, source));
  if (!gear.applied) return;
  double rotor = gear.motor[0];
  const auto is_rotor = [&](const Effect& e) { return e.place == at_joint(gear.joint) && is_rigid_rotor(e); };
  for (const Effect& e : *model) {
    if (is_rotor(e)) rotor = get_rotor(e);
  }
  model->erase(std::remove_if(model->begin(), model->end(), is_rotor), model->end());
  const EffectInfo& row = get_effect(EffectId::kElasticity);
  std::vector<double> p(row.parameters.size());
  row.give.start_at(std::max(kLeastRotor, rotor), 1.0 / gear.give, p.data());
  model->push_back({row.id, gear.joint, p});
}

}  // namespace hrp::diagnosis
