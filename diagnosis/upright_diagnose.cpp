// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diagnosis/report.h"
#include "diagnosis/upright_search.h"

namespace hrp::diagnosis::upright {
namespace {

// Value of a parameter by the name that the hypothesis gives it: "com_x" is the first of "com".
bool find_value(const Json& parameters, const std::string& name, double* value) {
  if (parameters.contains(name) && parameters[name]["value"].is_number())
    return *value = parameters[name]["value"].get<double>(), true;
  const size_t cut = name.rfind('_');
  if (cut == std::string::npos || cut + 2 != name.size()) return false;
  const std::string vector = name.substr(0, cut);
  const size_t axis = static_cast<size_t>(name.back() - 'x');
  if (axis > 2 || !parameters.contains(vector) || !parameters[vector]["value"].is_array()) return false;
  return *value = parameters[vector]["value"][axis].get<double>(), true;
}

// What the scenario and the URDF can take up: effects of joints and links.
Hypothesis find_updates(const Experiment& e, const Json& findings) {
  Hypothesis found;
  for (const Json& f : findings) {
    const bool joint = f["where"].contains("joint"), link = f["where"].contains("link");
    if (!joint && !link) continue;
    const std::string name = f["where"].begin().value().get<std::string>();
    for (int id = 0; id < static_cast<int>(EffectId::kTiming); ++id) {
      const EffectInfo& info = get_effect(static_cast<EffectId>(id));
      if (f["effect"] != info.name) continue;
      Effect effect{info.id, joint ? e.robot.tree.find_joint(name) : e.robot.tree.find_link(name), {}};
      for (const ParameterInfo& p : info.parameters) {
        double value = 0;
        find_value(f["parameters"], p.name, &value);
        effect.p.push_back(value);
      }
      if (effect.place >= 0) found.push_back(effect);
    }
  }
  return found;
}

// Bushes of the soles as the scenario writes them. How a sole damps up and down the data do not say: critical damping
// of a tenth of what a foot carries stands in.
std::vector<std::string> make_bush_lines(const Json& findings) {
  std::vector<std::string> lines;
  for (const Json& f : findings) {
    if (f["effect"] != "foot_compliance" && f["effect"] != "foot_hardening") continue;
    if (lines.empty()) lines.push_back("foot_bush:");
    const auto value = [&](const char* key, double absent) {
      return f["parameters"].contains(key) ? std::max(0.0, f["parameters"][key]["value"].get<double>()) : absent;
    };
    const double kz = value("kz", 3e5);
    char text[300];
    std::snprintf(text, sizeof text,
                  "  %s: {kz: %.6g, cz: %.6g, k_roll: %.6g, c_roll: %.6g, k_pitch: %.6g, c_pitch: %.6g}",
                  f["where"]["foot"].get<std::string>().c_str(), kz, 2 * std::sqrt(kz * 2.0), value("k_roll", 0),
                  value("c_roll", 0), value("k_pitch", 0), value("c_pitch", 0));
    lines.push_back(text);
  }
  return lines;
}

}  // namespace

bool diagnose_upright(const Problem& problem, const std::function<void(const std::string&)>& progress, Diagnosis* out) {
  StandProblems stands;
  std::string why;
  if (!make_stand_problem(*problem.experiment, Parity::kAll, &stands.all, &why)) return false;
  make_stand_problem(*problem.experiment, Parity::kEven, &stands.even, &why);
  make_stand_problem(*problem.experiment, Parity::kOdd, &stands.odd, &why);
  const StandProblem& stand = stands.all;
  if (progress) progress("standing robot: " + std::to_string(list_channels(stand).size()) + " equations a sample");
  const StandOutcome outcome = search_standing(stands, problem.jobs, progress);
  out->reports.report = make_stand_report(stand, outcome);
  out->reports.series = make_stand_series(stand, outcome);
  out->reports.series["experiment"] = problem.experiment->path;
  for (const std::string& warning : problem.experiment->warnings) out->reports.series["notes"].push_back(warning);
  out->found = find_updates(*problem.experiment, out->reports.report["findings"]);
  out->lines = make_bush_lines(out->reports.report["findings"]);
  return true;
}

}  // namespace hrp::diagnosis::upright
