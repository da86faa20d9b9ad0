// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/simpler_law.h"

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/findings/grading.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCurve = "stribeck_friction";

bool is_number(const Json& parameters, const char* name) {
  return parameters.contains(name) && parameters[name].contains("ci95") &&
         parameters[name].value("value", Json()).is_number();
}

enum class Curve { kNone, kTold, kUntold, kFlat };

// Untold: there may be no excess at rest, or it may end at once. Flat: it is too small to count, whatever speed it ends
// at.
Curve judge_curve(const Json& finding) {
  if (finding["effect"] != kCurve) return Curve::kNone;
  const Json& p = finding["parameters"];
  for (const char* name : {"coulomb", "static", "stribeck_velocity"}) {
    if (!is_number(p, name)) return Curve::kNone;
  }
  const double level = p["coulomb"]["value"];
  if (!holds(p["static"]["ci95"], level)) return Curve::kTold;
  if (p["static"]["ci95"][1].get<double>() <= (1.0 + kMinor) * level) return Curve::kFlat;
  return holds(p["stribeck_velocity"]["ci95"], 0.0) ? Curve::kUntold : Curve::kTold;
}

constexpr const char* kHardening = "hardening_angle";

// 1 / angle^2 has the standard deviation 2 std / angle^3. It is below two of these if angle < 4 std.
bool is_untold_hardening(const Json& finding) {
  if (!is_number(finding["parameters"], kHardening)) return false;
  const Json& angle = finding["parameters"][kHardening];
  const double std = (angle["ci95"][1].get<double>() - angle["ci95"][0].get<double>()) / (2 * kNinetyFive);
  return angle["value"].get<double>() < 4 * std;
}

std::string get_place(const Json& finding) { return finding["where"].begin().value().get<std::string>(); }

std::string make_words(const Json& estimate) {
  const double reach = 0.5 * (estimate["ci95"][1].get<double>() - estimate["ci95"][0].get<double>());
  return number(estimate["value"].get<double>(), 3) + " +- " + number(reach, 2) + " " +
         estimate["unit"].get<std::string>();
}

Json make_plain(const Json& curve, const char* effect, const char* from, const char* to) {
  Json plain = curve;
  plain["effect"] = effect;
  plain["family"] = find_family_name(effect);
  plain["parameters"] = {{to, curve["parameters"][from]}};
  if (plain.value("grade", "") == get_grade_name(Grade::kCertain)) plain["grade"] = get_grade_name(Grade::kSupported);
  return plain;
}

Json make_flat(const Json& curve) {
  Json plain = make_plain(curve, "coulomb_friction", "coulomb", "level");
  plain["grade"] = curve["grade"];
  plain["statement"] = get_place(curve) + ": dry friction of constant level, level " +
                       make_words(plain["parameters"]["level"]) + ". At rest it is no larger, to a twentieth.";
  return plain;
}

Json make_coulomb(const Json& curve) {
  Json plain = make_plain(curve, "coulomb_friction", "coulomb", "level");
  plain["alternatives"].push_back(state_alternative(*find_effect(kCurve), curve["where"], curve["parameters"],
                                                    "constant speeds from the slowest on, in both directions"));
  plain["statement"] =
      get_place(curve) + ": dry friction of constant level, level " + make_words(plain["parameters"]["level"]) +
      ". A larger friction at rest (Stribeck) would fit as well; its size and speed are not told from none.";
  return plain;
}

Json make_viscous(const Json& curve) {
  Json plain = make_plain(curve, "viscous_friction", "viscous", "coefficient");
  plain["statement"] = get_place(curve) + ": viscous friction, coefficient " +
                       make_words(plain["parameters"]["coefficient"]) +
                       ", beside dry friction. What both take away is counted for the dry friction.";
  plain["share"] = plain["weight"] = 0.0;  // counted for the dry friction
  return plain;
}

std::string list_words(const Json& parameters) {
  std::string out;
  for (const auto& [name, estimate] : parameters.items()) {
    if (is_number(parameters, name.c_str())) out += (out.empty() ? "" : ", ") + name + " " + make_words(estimate);
  }
  return out;
}

Json make_linear_sole(const Json& sole) {
  Json plain = sole;
  const EffectInfo& row = get_effect(EffectId::kFootCompliance);
  plain["effect"] = row.name;
  plain["parameters"].erase(kHardening);
  if (plain.value("grade", "") == get_grade_name(Grade::kCertain)) plain["grade"] = get_grade_name(Grade::kSupported);
  plain["alternatives"].push_back(state_alternative(*find_effect(sole["effect"].get<std::string>()), sole["where"],
                                                    sole["parameters"], "larger tilts of the foot"));
  plain["statement"] = get_place(sole) + ": " + row.phrase + " (" + list_words(plain["parameters"]) +
                       "). That it hardens as it gives is not told from none.";
  return plain;
}

}  // namespace

void name_simpler_laws(nlohmann::ordered_json* report) {
  Json list = Json::array();
  for (const Json& f : (*report)["findings"]) {
    const Curve curve = judge_curve(f);
    if (curve == Curve::kNone || curve == Curve::kTold) {
      list.push_back(is_untold_hardening(f) ? make_linear_sole(f) : f);
      continue;
    }
    list.push_back(curve == Curve::kFlat ? make_flat(f) : make_coulomb(f));
    if (is_number(f["parameters"], "viscous") && f["parameters"]["viscous"]["ci95"][0].get<double>() > 0.0)
      list.push_back(make_viscous(f));
  }
  (*report)["findings"] = list;
}

}  // namespace hrp::diagnosis
