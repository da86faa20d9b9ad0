// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/doubtful_constants.h"

#include <algorithm>

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/grading.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

bool is_of_mass(const Json& finding) { return finding.value("family", "") == get_family_name(EffectFamily::kMass); }

bool is_constant_torque(const Json& finding) {
  const EffectInfo* info = find_effect(finding.value("effect", ""));
  return info && info->place == PlaceKind::kJoint && info->family == EffectFamily::kZero && info->linear;
}

// Value and standard deviation of a finding's only parameter; {0, 0} if it has others.
std::pair<double, double> read_constant(const Json& finding) {
  const Json& parameters = finding["parameters"];
  if (parameters.size() != 1 || !parameters.begin().value().contains("std") ||
      !parameters.begin().value()["value"].is_number())
    return {0.0, 0.0};
  return {parameters.begin().value()["value"], parameters.begin().value()["std"]};
}

// Masses and their places that ambiguous findings may be, as alternatives. What several of them may be is listed once.
std::vector<Json> list_masses(const Json& findings) {
  std::vector<Json> masses;
  const auto add = [&](const Json& mass) {
    const auto is_same = [&](const Json& m) { return m["effect"] == mass["effect"] && m["where"] == mass["where"]; };
    if (is_of_mass(mass) && std::none_of(masses.begin(), masses.end(), is_same)) masses.push_back(mass);
  };
  for (const Json& f : findings) {
    if (f.value("grade", "") != get_grade_name(Grade::kAmbiguous)) continue;
    if (is_of_mass(f)) add(state_as_alternative(f));
    for (const Json& a : f.value("alternatives", Json::array())) add(a);
  }
  return masses;
}

}  // namespace

void doubt_constants_of_masses(const Experiment& experiment, Json* report) {
  if (!experiment.scenario.floating_base) return;
  Json& findings = (*report)["findings"];
  const std::vector<Json> masses = list_masses(findings);
  if (masses.empty()) return;
  for (Json& f : findings) {
    if (!is_constant_torque(f) || f.value("grade", "") != get_grade_name(Grade::kSupported)) continue;
    make_ambiguous(&f);
    f["statement"] = f.value("statement", "") + " It may be the weight of what is not where the model has it.";
    for (const Json& mass : masses) f["alternatives"].push_back(mass);
  }
}

void doubt_constants_of_commands(const Experiment& e, Json* report) {
  Json& findings = (*report)["findings"];
  for (int j = 0; j < e.num_joints() && e.scenario.drive == "servo"; ++j) {
    const std::string joint = e.robot.tree.joint(j).name;
    const double kp = get_servo_gains(e.scenario, joint).kp;
    Json *of_log = nullptr, *of_joint = nullptr;
    for (Json& f : findings) {
      if (f["effect"] == get_effect(EffectId::kSensorBias).name &&
          f["where"].value("sensor", "") == e.signal_name(j, Quantity::kEffort))
        of_log = &f;
      if (is_constant_torque(f) && f["where"].value("joint", "") == joint) of_joint = &f;
    }
    if (!of_log || !of_joint || !(kp > 0.0)) continue;
    const auto [bias, bias_std] = read_constant(*of_log);
    const auto [torque, torque_std] = read_constant(*of_joint);
    if (!(bias * torque < 0.0) || std::abs(bias + torque) > kNinetyFive * std::hypot(bias_std, torque_std)) continue;
    for (Json* f : {of_log, of_joint}) {
      make_ambiguous(f);
      (*f)["statement"] = f->value("statement", "") + " Or the zero of the commands is " + number(bias / kp, 3) +
                          " off that of the positions: then there is neither this nor the opposite " +
                          (f == of_log ? "torque." : "zero of the log.");
    }
    (*of_log)["alternatives"].push_back(state_as_alternative(*of_joint)),
        (*of_joint)["alternatives"].push_back(state_as_alternative(*of_log));
  }
}

}  // namespace hrp::diagnosis
