// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/unit_doubts.h"

#include <algorithm>

#include "common/base/rounding.h"
#include "common/effects/units.h"

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

void warn(const std::string& text, Reports* reports) {
  reports->report["warnings"].push_back(text), reports->series["notes"].push_back(text);
}

}  // namespace

std::vector<int> list_untold_units(const TorqueData& data, const std::vector<EffortUnit>& units) {
  std::vector<int> untold;
  bool told = false;
  for (size_t j = 0; j < data.source.size() && !data.recordings.empty(); ++j) {
    const int joint = static_cast<int>(j);
    if (!data.experiment->robot.tree.joint(joint).actuated || data.source[j] != EffortSource::kRecorded) continue;
    if (tells_unit(data, joint)) told = true;
    else if (std::none_of(units.begin(), units.end(), [&](const EffortUnit& u) { return u.joint == joint; })) untold.push_back(joint);
  }
  return told && units.empty() ? std::vector<int>{} : untold;
}

void doubt_untold_units(const Experiment& e, const std::vector<int>& untold, Reports* reports) {
  for (int joint : untold) {
    const std::string name = e.robot.tree.joint(joint).name, unit = get_joint_unit(e.robot.tree.joint(joint), "N m");
    reports->report["untold_units"].push_back(name);
    warn(e.signal_name(joint, Quantity::kEffort) + ": this motion does not tell its unit; what is found at " + name +
             " is in the unit of the log, and in " + unit + " only if that is " + unit, reports);
    mark_findings(name, "in_log_unit", " Values are in the unit of the log.", &reports->report);
  }
}

void doubt_least_units(const Experiment& e, const std::vector<EffortUnit>& units, Reports* reports) {
  for (const EffortUnit& u : units) {
    if (!u.at_least) continue;
    const std::string name = e.robot.tree.joint(u.joint).name, unit = get_joint_unit(e.robot.tree.joint(u.joint), "N m");
    reports->report["least_units"].push_back(name);
    warn(e.signal_name(u.joint, Quantity::kEffort) + ": one unit is " + number(u.scale, 3) + " " + unit +
             " if the drive has no rotor and the model's inertia is right; torques and inertias found at " + name + " grow with it", reports);
    mark_findings(name, "at_least", " With a rotor, the unit and this value are larger.", &reports->report);
  }
}

}  // namespace hrp::diagnosis
