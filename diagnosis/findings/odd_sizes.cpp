// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/odd_sizes.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "common/multibody/tree_mass.h"
#include "common/spatial/gravity.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/model/link_reach.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLoads = 2.0;  // masses of the machine: what more could it carry?
constexpr double kSink = 1e-3;  // [m] compression of a sole under half the weight
constexpr double kTilt = 5e-3;  // [rad] tilt of a sole when half the weight moves by kMove
constexpr double kMove = 0.05;  // [m]

std::vector<double> list_numbers(const Json& value) {
  if (value.is_number()) return {value.get<double>()};
  return value.is_array() ? value.get<std::vector<double>>() : std::vector<double>{};
}

double calc_norm(const std::vector<double>& v) {
  double sum = 0.0;
  for (double x : v) sum += x * x;
  return std::sqrt(sum);
}

// Reason why one parameter's value is implausible. `reach` [m], `mass` [kg] of what the effect acts on; 0: unknown.
std::string find_odd_value(const EffectParameter& p, const std::vector<double>& value, double reach, double mass) {
  const double size = calc_norm(value);
  if (p.factor && value.size() == 1 && !(std::abs(std::log(std::max(1e-300, value[0]))) <= kFactor))
    return "a factor of " + number(value[0], 3);
  if (p.unit == "m" && reach > 0.0 && size > reach)
    return number(size, 3) + " m away, expected at most " + number(reach, 2) + " m";
  // Ropes and persons pull no harder.
  if (p.unit == "N" && mass > 0.0 && size > kSeveralTimes * kGravity * mass)
    return number(size, 3) + " N on a machine that weighs " + number(kGravity * mass, 3) + " N";
  if (p.unit == "kg" && mass > 0.0 && size > kLoads * mass)
    return number(size, 3) + " kg on a machine of " + number(mass, 3) + " kg";
  return "";
}

int find_link(const TreeSpec& tree, const Json& where) {
  if (!where.contains("link")) return -1;
  const std::string name = where["link"];
  for (size_t i = 0; i < tree.links.size(); ++i) {
    if (tree.links[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

void doubt(const std::string& why, Json* finding) {
  Json& f = *finding;
  make_ambiguous(&f);
  f["odd_size"] = why;
  f["statement"] = f.value("statement", "") + " This size is hardly possible (" + why +
                   "): the law fits, but something else is likely to be the cause.";
}

// Angle [rad] of a spring's rest beyond the joint's range; 0 for other laws.
double calc_wound(const TreeSpec& tree, const Json& finding) {
  const Json& where = finding["where"];
  const Json& rest = finding["parameters"].contains("rest") ? finding["parameters"]["rest"] : Json();
  for (const LinkSpec& link : tree.links) {
    if (!rest.is_object() || !where.contains("joint") || where["joint"] != link.joint.name ||
        link.joint.kind != JointKind::kRevolute)
      continue;
    const double value = list_numbers(rest["value"]).at(0);
    return std::max(link.joint.lower - value, value - link.joint.upper);
  }
  return 0.0;
}

bool has_odd_size(const Json& finding) { return finding.contains("odd_size"); }

bool is_stiff_sole(const Json& finding, double half_weight) {
  if (finding["effect"] != get_effect(EffectId::kFootCompliance).name) return false;
  // A stiffness that is not stated is no compliance.
  const auto get = [&](const char* name) { return read_number(finding["parameters"], name, HUGE_VAL); };
  const double tilt = std::min(get("k_roll"), get("k_pitch"));
  return half_weight / get("kz") < kSink && half_weight * kMove / tilt < kTilt;
}

// True if all parameters that define the effect are within a part of their standard deviations of neutral.
bool is_idle(const Json& finding) {
  const EffectInfo* effect = find_effect(finding["effect"].get<std::string>());
  if (!effect || !is_ambiguous(finding)) return false;
  bool any = false;
  for (const EffectParameter& p : effect->parameters) {
    if (std::isnan(p.neutral) || p.nuisance || p.axis > 0 || !finding["parameters"].contains(p.name)) continue;
    const Json& stated = finding["parameters"][p.name];
    if (!stated.is_object() || !stated.contains("std")) return false;
    const std::vector<double> value = list_numbers(stated["value"]), std = list_numbers(stated["std"]);
    for (size_t i = 0; i < value.size() && i < std.size(); ++i) {
      if (std::abs(value[i] - p.neutral) > kPart * std[i]) return false;
      any = true;
    }
  }
  return any;
}

bool names(const Json& finding, const Json& other) {
  return std::any_of(finding["alternatives"].begin(), finding["alternatives"].end(),
                     [&](const Json& a) { return is_same_effect(a, other); });
}

// True if a heavier finding at the same place names this one as what it may be, and the other way: one cause of which
// each law takes a part.
bool is_part_of_another(const Json& finding, const Json& findings) {
  return std::any_of(findings.begin(), findings.end(), [&](const Json& f) {
    return f["where"] == finding["where"] && f.value("weight", 0.0) > finding.value("weight", 0.0) &&
           names(f, finding) && names(finding, f);
  });
}

// What is hardly possible says nothing to whoever looks for the cause. A gain of any size may be the unit of a log.
void drop_odd_alternatives(const TreeSpec& tree, Json* finding) {
  if (!finding->contains("alternatives")) return;
  Json& list = (*finding)["alternatives"];
  Json kept = Json::array();
  for (const Json& a : list) {
    const bool unit = a["effect"] == get_effect_of(PlaceKind::kJoint, EffectFamily::kGain).name;
    if (unit || find_odd_size(tree, a).empty()) kept.push_back(a);
  }
  list = kept;
}

// Whether a limit of the drive's torque may be no larger than a level of dry friction, by the latter's interval.
bool is_within(const Json& limit, const Json& friction) {
  for (const auto& a : limit["parameters"].items()) {
    for (const auto& b : friction["parameters"].items()) {
      if (a.value()["unit"] != b.value()["unit"] || !b.value().contains("ci95") || !a.value()["value"].is_number())
        continue;
      if (a.value()["value"].get<double>() <= b.value()["ci95"][1].get<double>()) return true;
    }
  }
  return false;
}

}  // namespace

bool is_possible_load(const TreeSpec& tree, double mass) {
  const double own = calc_mass(tree);
  return own <= 0.0 || mass <= kLoads * own;
}

std::string find_odd_size(const TreeSpec& tree, const Json& finding) {
  const EffectInfo* effect = find_effect(finding["effect"].get<std::string>());
  if (finding.contains("of_log")) return "";
  if (!effect || (effect->place != PlaceKind::kLink && effect->place != PlaceKind::kJoint)) return "";
  const int link = find_link(tree, finding["where"]);
  const double mass = link >= 0 ? calc_mass(tree) : 0.0;
  const double reach = link < 0                ? 0.0
                       : effect->of_whole_link ? calc_link_reach(tree, link)
                                               : calc_carried_reach(tree, link);
  for (const EffectParameter& p : effect->parameters) {
    if (p.axis > 0 || p.nuisance || !finding["parameters"].contains(p.name)) continue;
    const Json& stated = finding["parameters"][p.name];
    if (!stated.is_object() || !stated.contains("value")) continue;
    std::string why = find_odd_value(p, list_numbers(stated["value"]), reach, mass);
    if (!why.empty()) return why;
  }
  const double wound = calc_wound(tree, finding);
  // By more than a turn.
  return wound > 2.0 * M_PI ? "a spring that rests " + number(wound, 3) + " rad beyond the joint's range" : "";
}

void doubt_odd_sizes(const TreeSpec& tree, Json* report) {
  Json& findings = (*report)["findings"];
  for (Json& f : findings) {
    const std::string why = find_odd_size(tree, f);
    if (!why.empty() && !has_odd_size(f)) doubt(why, &f);
    drop_odd_alternatives(tree, &f);
  }
  if (std::none_of(findings.begin(), findings.end(), has_odd_size)) return;
  for (Json& f : findings) {
    if (f.value("grade", "") == get_grade_name(Grade::kCertain)) make_ambiguous(&f);
  }
  if ((*report)["verdict"] == get_verdict_name(Verdict::kExplained))
    (*report)["verdict"] = get_verdict_name(Verdict::kMostlyExplained);
}

void doubt_stiff_soles(const TreeSpec& tree, Json* report) {
  const double half_weight = 0.5 * kGravity * calc_mass(tree);
  for (Json& f : (*report)["findings"]) {
    if (is_ambiguous(f) || !is_stiff_sole(f, half_weight)) continue;
    make_ambiguous(&f);
    f["statement"] =
        f.value("statement", "") + " This is as stiff as floors and force sensors are: what gives here is not told.";
  }
}

void doubt_limits_within_friction(Json* report) {
  Json& findings = (*report)["findings"];
  for (Json& f : findings) {
    const bool told = !is_ambiguous(f);
    if (!told || f.value("family", "") != get_family_name(EffectFamily::kLimits) || !f["where"].contains("joint"))
      continue;
    for (const Json& other : findings) {
      if (other.value("family", "") != get_family_name(EffectFamily::kDryFriction) || other["where"] != f["where"] ||
          !is_within(f, other))
        continue;
      make_ambiguous(&f);
      f["statement"] = f.value("statement", "") +
                       " A drive that gives no more than the dry friction found here would not move the joint: that "
                       "friction may vary instead.";
      f["alternatives"].push_back(state_as_alternative(other));
      break;
    }
  }
}

void drop_idle_findings(Json* report) {
  Json& findings = (*report)["findings"];
  const bool explained = report->value("verdict", "") == "explained";
  Json kept = Json::array();
  for (const Json& f : findings) {
    const bool ambiguous = is_ambiguous(f);
    const bool needed = !may_be_absent(f) && !is_part_of_another(f, findings);
    if (!is_idle(f) && (needed || !ambiguous || !explained)) kept.push_back(f);
  }
  if (!kept.empty()) findings = kept;
}

}  // namespace hrp::diagnosis
