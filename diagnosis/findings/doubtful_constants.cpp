// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/doubtful_constants.h"

#include <algorithm>

#include "common/effects/effect_info.h"
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

}  // namespace hrp::diagnosis
