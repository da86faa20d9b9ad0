// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "diagnosis/report.h"

namespace hrp::diagnosis {
namespace {

// Empty when the joints of a robot on a standing base can be simulated from the recordings, else why not.
std::string find_obstacle(const Experiment& e) {
  if (e.scenario.floating_base) {
    return "a floating base needs, at every foot, a recorded wrench, and an IMU with attitude, angular velocity and acceleration; this "
           "experiment does not record them";
  }
  if (e.num_joints() == 0) return "the robot has no joints";
  if (!e.scenario.feet.empty() && e.scenario.ground.present) return "a foot of a robot on a rail or stand touches the ground, and contact is not predicted here";
  if (e.scenario.drive == "motion") return "the joints are taken as recorded and no other signal of a fixed base is predicted";
  for (const Recording& r : e.recordings) {
    for (size_t j = 0; j < r.joints.size(); ++j) {
      const std::string& name = e.robot.tree.joint(static_cast<int>(j)).name;
      if (!r.joints[j].has(Quantity::kPosition)) return r.spec.name + " has no position of joint " + name;
      if (e.scenario.drive == "effort" && !r.joints[j].has(Quantity::kEffort) && e.robot.tree.joint(static_cast<int>(j)).actuated) {
        return r.spec.name + " has no effort of joint " + name + ", which drives it";
      }
    }
  }
  return "";
}

std::vector<std::string> make_foot_lines(const StandOutcome& outcome) {
  std::vector<std::string> lines;
  if (!outcome.explained) return lines;
  for (size_t i = 0; i < outcome.chosen.size(); ++i) {
    if (outcome.chosen[i].effect != "foot_compliance") continue;
    if (lines.empty()) lines.push_back("foot_bush:");
    std::string line = "  " + outcome.chosen[i].where + ": {";
    for (size_t k = 0; k < outcome.values[i].size(); ++k) {
      char text[80];
      std::snprintf(text, sizeof text, "%s%s: %.8g", k ? ", " : "", outcome.values[i][k].name.c_str(), std::max(0.0, outcome.values[i][k].value[0]));
      line += text;
    }
    lines.push_back(line + "}");
  }
  return lines;
}

// Effects that the model itself can take up.
Hypothesis find_updates(const Problem& problem, const StandOutcome& outcome) {
  Hypothesis found;
  const TreeSpec& tree = problem.experiment->robot.tree;
  if (!outcome.explained) return found;
  for (size_t i = 0; i < outcome.chosen.size(); ++i) {
    const auto& c = outcome.chosen[i];
    for (int id = 0; id < static_cast<int>(EffectId::kTiming); ++id) {
      const EffectInfo& info = get_effect(static_cast<EffectId>(id));
      if (info.name != c.effect || c.where_kind == "sensor") continue;
      Effect effect{info.id, c.where_kind == "joint" ? tree.find_joint(c.where) : tree.find_link(c.where), {}};
      for (const auto& value : outcome.values[i]) effect.p.insert(effect.p.end(), value.value.begin(), value.value.end());
      effect.p.resize(info.parameters.size(), 0.0);
      if (effect.place >= 0) found.push_back(effect);
    }
  }
  return found;
}

}  // namespace

Diagnosis diagnose(const Problem& problem, const Progress& progress) {
  Diagnosis diagnosis;
  const Experiment& e = *problem.experiment;
  if (upright::diagnose_upright(problem, progress, &diagnosis)) return diagnosis;
  if (can_stand_on_paper(e)) {
    const StandOutcome outcome = search_standing(problem, progress);
    diagnosis.reports = make_standing_reports(problem, outcome);
    diagnosis.found = find_updates(problem, outcome);
    diagnosis.lines = make_foot_lines(outcome);
    return diagnosis;
  }
  const std::string obstacle = find_obstacle(e);
  if (!obstacle.empty()) {
    diagnosis.reports = make_empty_reports(problem, obstacle);
    return diagnosis;
  }
  const Outcome outcome = search(problem, progress);
  diagnosis.reports = make_reports(problem, outcome);
  if (outcome.explained || outcome.partly) diagnosis.found = outcome.chosen.hypothesis;
  return diagnosis;
}

}  // namespace hrp::diagnosis
