// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/unit_doubts.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/effect_info.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/findings/grading.h"

namespace hrp::diagnosis {
namespace {

// True if a parameter is a torque or inertia, and so as large as the log's unit.
bool is_in_log_unit(const Json& finding) {
  return std::any_of(finding["parameters"].begin(), finding["parameters"].end(), [](const Json& p) {
    const std::string unit = p.is_object() ? p.value("unit", "") : "";
    return unit.find('N') != std::string::npos || unit.find("kg") != std::string::npos;
  });
}

void mark_findings(const std::string& joint, const char* key, const std::string& words, Json* report) {
  for (Json& f : (*report)["findings"]) {
    if (f["where"].value("joint", "") != joint || !is_in_log_unit(f)) continue;
    f[key] = true;
    f["statement"] = f.value("statement", "") + words;
  }
}

// What no effect explains at this joint is no torque in `unit` either.
void mark_unexplained(const std::string& joint, const std::string& unit, Json* report) {
  const std::string words = " " + unit + " (root mean square)";
  for (Json& u : (*report)["unexplained"]) {
    std::string text = u.value("statement", "");
    const size_t at = text.find(words);
    if (u.value("where", Json::object()).value("joint", "") != joint || at == std::string::npos) continue;
    u["statement"] = text.replace(at, unit.size() + 1, " in the unit of the log");
  }
}

// Nor is what remains there.
void mark_remaining(const std::string& joint, Json* report) {
  if (!report->contains("remaining")) return;
  for (Json& r : (*report)["remaining"]) {
    if (r.value("where", Json::object()).value("joint", "") == joint)
      r["statement"] = r.value("statement", "") + " Values are in the unit of the log.";
  }
}

// A value with the relative deviation `blur` of its unit beside its own.
void widen(double blur, Json* number, Json* std, Json* ends) {
  const double own = std->get<double>(), wide = std::hypot(own, blur * number->get<double>());
  for (size_t i : {0, 1}) (*ends)[i] = (*ends)[i].get<double>() + (i == 0 ? -1.0 : 1.0) * kNinetyFive * (wide - own);
  *std = wide;
}

// Its parameters that are torques, inertias, masses or forces, with the relative deviation `blur`; of a load, also
// where it is, with that of the joints' units that tell its moments.
void widen_finding(double blur, double of_moments, Json* finding) {
  const bool link = (*finding)["where"].contains("link");
  if (!std::isfinite(blur)) return;
  for (Json& p : (*finding)["parameters"]) {
    if (!p.is_object() || !p.contains("std") || !p.contains("ci95")) continue;
    const std::string unit = p.value("unit", "");
    if (unit.find('N') == std::string::npos && unit.find("kg") == std::string::npos && !(link && unit == "m")) continue;
    const double by = unit == "m" ? std::hypot(blur, of_moments) : blur;
    if (p["value"].is_number()) widen(by, &p["value"], &p["std"], &p["ci95"]);
    for (size_t i = 0; p["value"].is_array() && i < p["value"].size(); ++i)
      widen(by, &p["value"][i], &p["std"][i], &p["ci95"][i]);
  }
}

// True if it says where a mass is. Moments tell it, and those of the joints that carry it were counted in units of the
// same motion: a joint that carries little else takes another unit for another place.
bool has_place(const Json& finding) {
  return std::any_of(finding["parameters"].begin(), finding["parameters"].end(),
                     [](const Json& p) { return p.is_object() && p.value("unit", "") == "m"; });
}

double find_blur(const EffortUnit& u) { return 0.5 * (u.high - u.low) / kNinetyFive / u.scale; }

// Of a link's mass or force: all units together do as well. Of a joint's torque: its own unit does.
void doubt_beside(const Experiment& e, const std::vector<EffortUnit>& units, const std::string& why, Json* finding) {
  const EffectInfo& gain = get_effect_of(PlaceKind::kJoint, EffectFamily::kGain);
  make_ambiguous(finding);
  (*finding)["statement"] = (*finding).value("statement", "") + why;
  for (const EffortUnit& u : units)
    (*finding)["alternatives"].push_back(
        state_alternative(gain, {{"joint", e.robot.tree.joint(u.joint).name}}, {{"scale", u.scale}}));
}

// True for friction that is a share of the load's torque.
bool is_share_of_load(const Json& finding) {
  const EffectInfo* effect = find_effect(finding["effect"].get<std::string>());
  return effect && effect->family == EffectFamily::kDryFriction && finding["parameters"].contains("ratio");
}

// True for friction whose torque is no share of the load's: nothing of bodies follows direction or speed, whatever the
// unit. Its size is as large as the unit; that it is there is sure.
bool is_own_friction(const Json& finding) {
  const EffectInfo* effect = find_effect(finding["effect"].get<std::string>());
  return effect && (effect->family == EffectFamily::kDryFriction || effect->family == EffectFamily::kSpeedLoss) &&
         !is_share_of_load(finding);
}

// A unit that is off by a share of itself leaves this share of the load's torque over. While the load brakes or drives
// the joint, it looks like friction that grows with the load by the same share.
void doubt_share_of_load(const Experiment& e, const EffortUnit& u, Json* finding) {
  const double blur = find_blur(u);
  Json& ratio = (*finding)["parameters"]["ratio"];
  if (!std::isfinite(blur) || !ratio.is_object() || !ratio.contains("std") || !ratio.contains("ci95")) return;
  const double value = ratio["value"].get<double>();
  widen(blur / std::abs(value), &ratio["value"], &ratio["std"], &ratio["ci95"]);
  if (std::abs(value) < kUnlikely * ratio["std"].get<double>())
    doubt_beside(e, {u}, " The unit of this joint's effort is not known well enough to tell this share of the load.",
                 finding);
}

// True if a force across gravity may be none: what is left of it along each axis is within its interval. The
// simulator's axes are the world's, and so is gravity's.
bool is_upright(const Vector3d& gravity_W, const Json& force) {
  if (!force.is_object() || !force.contains("ci95") || gravity_W.isZero()) return false;
  const Vector3d up = gravity_W.cwiseAbs().normalized();
  for (size_t axis = 0; axis < 3; ++axis) {
    const double low = force["ci95"][axis][0], high = force["ci95"][axis][1];
    if (up[static_cast<long>(axis)] < kNearlyAll && (low > 0.0 || high < 0.0)) return false;
  }
  return up.maxCoeff() > kNearlyAll;
}

// The finding, or another unit without it. `instead`: what there is then, up to the number. `scale`: as the report has
// it.
void doubt_beside_unit(const std::string& instead, double value, const std::string& unit, const Json& scale,
                       Json* finding) {
  Json& f = *finding;
  make_ambiguous(&f);
  f["statement"] = f.value("statement", "") + " Or there is " + instead + "one logged unit is " + number(value, 2) +
                   " " + unit + ".";
  f["alternatives"].push_back(
      state_alternative(get_effect_of(PlaceKind::kJoint, EffectFamily::kGain), f["where"], {{"scale", scale}}));
}

// A rotor much larger than the bodies: efforts of that size may be counts, and `u` their unit without any rotor. Both
// take the same torque along any motion, so the rotor is never sure.
void doubt_large_rotor(const std::string& joint, const std::string& unit, const EffortUnit& u, Json* report) {
  if (std::log(u.scale) > -kFactor) return;
  for (Json& f : (*report)["findings"]) {
    if (f["where"].value("joint", "") != joint ||
        f["effect"] != get_effect_of(PlaceKind::kJoint, EffectFamily::kReflectedInertia).name)
      continue;
    const Json scale = make_value(round_to(u.scale, 3), round_to(u.scale * std::max(kBlur, find_blur(u)), 2), "1");
    doubt_beside_unit("no rotor, and ", u.scale, unit, scale, &f);
  }
}

// Dry friction or a constant torque that takes most of the effort may be none: the unit alone does as well.
void doubt_large_level(const std::string& joint, const std::string& unit, double scale, bool of_friction,
                       Json* report) {
  if (scale == 1.0) return;
  for (Json& f : (*report)["findings"]) {
    const EffectInfo* effect = find_effect(f["effect"].get<std::string>());
    if (f["where"].value("joint", "") != joint || !effect || is_share_of_load(f) || !is_in_log_unit(f)) continue;
    if (effect->family != EffectFamily::kZero && !(of_friction && effect->family == EffectFamily::kDryFriction))
      continue;
    doubt_beside_unit(scale < 0.0 ? "none, and the log has the other sign: " : "none, and ", scale, unit,
                      round_to(scale, 2), &f);
  }
}

// Dry friction that is nearly all of an effort whose unit is not known: the effort shows a direction, and neither
// weight nor inertia. A drive at one effort does so that brings its own rotor to a speed against viscous friction.
void doubt_whole_friction(const std::string& joint, Json* report) {
  for (Json& f : (*report)["findings"]) {
    const EffectInfo* effect = find_effect(f["effect"].get<std::string>());
    if (f["where"].value("joint", "") != joint || !effect || effect->family != EffectFamily::kDryFriction ||
        is_share_of_load(f))
      continue;
    if (f.value("grade", "") != get_grade_name(Grade::kSupported) || f.value("share", 0.0) < kNearlyAll) continue;
    make_ambiguous(&f);
    f["statement"] = f.value("statement", "") +
                     " It is nearly all of the effort, whose unit is not known: viscous friction and a rotor would "
                     "need about the same effort.";
    for (EffectFamily family : {EffectFamily::kSpeedLoss, EffectFamily::kReflectedInertia})
      f["alternatives"].push_back(
          state_alternative(get_effect_of(PlaceKind::kJoint, family), f["where"], Json::object()));
  }
}

void warn(const std::string& text, Reports* reports) {
  reports->report["warnings"].push_back(text);
  reports->series["notes"].push_back(text);
}

}  // namespace

bool has_effort(const Experiment& e) {
  for (const Recording& r : e.recordings) {
    if (std::any_of(r.joints.begin(), r.joints.end(), [](const JointColumns& j) { return j.has(Quantity::kEffort); }))
      return true;
  }
  return false;
}

std::vector<EffortUnit> list_untold_units(const TorqueData& data, const std::vector<EffortUnit>& units) {
  std::vector<EffortUnit> untold;
  bool told = false;
  for (size_t j = 0; j < data.source.size() && !data.recordings.empty(); ++j) {
    const int joint = static_cast<int>(j);
    if (!data.experiment->robot.tree.joint(joint).actuated || data.source[j] != EffortSource::kRecorded) continue;
    if (tells_unit(data, joint)) {
      told = true;
    } else if (std::none_of(units.begin(), units.end(), [&](const EffortUnit& u) { return u.joint == joint; })) {
      untold.push_back(find_unit_without_rotor(data, joint).value_or(EffortUnit{joint}));
      untold.back().without_friction = find_unit_without_friction(data, joint).value_or(1.0);
      untold.back().without_constant = find_unit_without_constant(data, joint).value_or(1.0);
    }
  }
  return told && units.empty() ? std::vector<EffortUnit>{} : untold;
}

void doubt_untold_units(const Experiment& e, const std::vector<EffortUnit>& untold, Reports* reports) {
  for (const EffortUnit& u : untold) {
    const std::string name = e.robot.tree.joint(u.joint).name,
                      unit = get_joint_unit(e.robot.tree.joint(u.joint), "N m");
    reports->report["untold_units"].push_back(name);
    warn(e.signal_name(u.joint, Quantity::kEffort) + ": this motion does not tell its unit; what is found at " + name +
             " is in the unit of the log, and in " + unit + " only if that is " + unit,
         reports);
    mark_findings(name, "in_log_unit", " Values are in the unit of the log.", &reports->report);
    mark_unexplained(name, unit, &reports->report);
    mark_remaining(name, &reports->report);
    doubt_large_rotor(name, unit, u, &reports->report);
    doubt_whole_friction(name, &reports->report);
    const bool of_friction = u.without_friction != 1.0;
    doubt_large_level(name, unit, of_friction ? u.without_friction : u.without_constant, of_friction, &reports->report);
  }
}

void doubt_least_units(const Experiment& e, const std::vector<EffortUnit>& units, Reports* reports) {
  for (const EffortUnit& u : units) {
    if (!u.at_least) continue;
    const std::string name = e.robot.tree.joint(u.joint).name,
                      unit = get_joint_unit(e.robot.tree.joint(u.joint), "N m");
    reports->report["least_units"].push_back(name);
    warn(e.signal_name(u.joint, Quantity::kEffort) + ": one unit is " + number(u.scale, 3) + " " + unit +
             " if the drive has no rotor and the model's inertia is right; torques and inertias found at " + name +
             " grow with it",
         reports);
    mark_findings(name, "at_least", " With a rotor, the unit and this value are larger.", &reports->report);
  }
}

void doubt_beside_units(const Experiment& e, const std::vector<EffortUnit>& units, Reports* reports) {
  std::vector<EffortUnit> moved;  // told by the motion
  double of_load = 0.0, of_moments = 0.0;
  for (const EffortUnit& u : units) {
    if (u.of_load > 0.0) {
      moved.push_back(u);
      of_load = std::max(of_load, u.of_load);
      of_moments = std::max(of_moments, find_blur(u));
    }
  }
  for (Json& f : reports->report["findings"]) {
    const std::string joint = f["where"].value("joint", "");
    if (f["where"].contains("link") && !moved.empty() && (is_in_log_unit(f) || has_place(f))) {
      widen_finding(of_load, of_moments, &f);
      if (of_load > kPart || has_place(f))
        doubt_beside(e, moved,
                     " The efforts' units were found from the same motion: other units describe it nearly as well.",
                     &f);
    }
    for (const EffortUnit& u : moved) {
      if (joint.empty() || e.robot.tree.joint(u.joint).name != joint) continue;
      if (is_share_of_load(f)) doubt_share_of_load(e, u, &f);
      if (!is_in_log_unit(f)) continue;
      const double blur = is_load_or_unit(u) ? std::max(find_blur(u), u.by_load) : find_blur(u);
      widen_finding(blur, 0.0, &f);
      const bool sized = is_own_friction(f) && kNinetyFive * blur < 1.0;
      if (sized && blur > kPart)
        f["statement"] = f.value("statement", "") +
                         " It is there in any unit; its size is as uncertain as the unit of this joint's effort.";
      if (!sized && blur > kPart) doubt_beside(e, {u}, " The unit of this joint's effort is hardly known.", &f);
    }
  }
}

void doubt_upright_forces(const Experiment& e, Json* report) {
  if (e.scenario.floating_base || e.scenario.drive != "servo" || has_effort(e)) return;
  const EffectInfo& gain = get_effect_of(PlaceKind::kJoint, EffectFamily::kGain);
  for (Json& f : (*report)["findings"]) {
    const bool force = f["effect"] == get_effect_of(PlaceKind::kLink, EffectFamily::kZero).name &&
                       f.value("grade", "") == get_grade_name(Grade::kSupported);
    if (!force || !is_upright(e.scenario.gravity_W, f["parameters"]["force"])) continue;
    make_ambiguous(&f);
    f["statement"] = f.value("statement", "") +
                     " It acts along gravity, and no effort was logged: stated gains that are wrong look the same.";
    for (int j = 0; j < e.num_joints(); ++j) {
      if (!e.robot.tree.joint(j).actuated) continue;
      f["alternatives"].push_back(state_alternative(gain, {{"joint", e.robot.tree.joint(j).name}}, Json::object()));
    }
  }
}

}  // namespace hrp::diagnosis
