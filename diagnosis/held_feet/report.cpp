// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/held_feet/search.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis::held_feet {
namespace {

std::string get_joint(const RowProblem& problem, size_t j) {
  return problem.experiment->robot.tree.joint(static_cast<int>(j)).name;
}

const char* get_suffix(Reading reading) {
  return reading == Reading::kForce ? "/force" : reading == Reading::kTorque ? "/torque" : "";
}

Json make_where(const RowProblem& problem, const RowEffect& e) {
  const auto at = static_cast<size_t>(e.place.index);
  if (e.place.kind == PlaceKind::kJoint) return {{"joint", get_joint(problem, at)}};
  if (e.place.kind == PlaceKind::kLink) return {{"link", problem.experiment->robot.tree.links[at].name}};
  if (is_of_joint(e.place.reading)) return {{"sensor", "/joint_states/" + get_joint(problem, at) + "/effort"}};
  return {{"sensor", "/wrench/" + problem.sensors[at].name + get_suffix(e.place.reading)}};
}

std::string get_unit(const RowEffect& e, const EffectParameter& parameter) {
  if (!parameter.unit.empty()) return parameter.unit;
  return e.place.reading == Reading::kForce ? "N" : "N m";
}

Json make_parameters(const RowEffect& e, const std::vector<double>& std) {
  const ParameterValues all = make_parameter_values(e, std);
  const EffectParameter& first = *all.parameters[0];
  if (first.axis >= 0) return {{first.name, make_vector(all.value, all.std, get_unit(e, first))}};
  Json out;
  for (size_t i = 0; i < all.value.size(); ++i) {
    out[all.parameters[i]->name] = make_value(all.value[i], all.std[i], get_unit(e, *all.parameters[i]));
  }
  return out;
}

Json make_findings(const RowProblem& problem, const RowOutcome& outcome) {
  Json list = Json::array();
  for (size_t i = 0; i < outcome.chosen.hypothesis.size(); ++i) {
    const RowEffect& e = outcome.chosen.hypothesis[i];
    const EffectInfo& info = get_effect(e.id);
    const ParameterValues all = make_parameter_values(e, outcome.chosen.std[i]);
    const Json where = make_where(problem, e);
    std::string values;
    for (size_t p = 0; p < all.value.size(); ++p) {
      const std::string unit = get_unit(e, *all.parameters[p]);
      values += (p ? ", " : "") + all.parameters[p]->key() + " " + number(all.value[p], 3) + " +- " +
                number(1.96 * all.std[p], 3) + (unit == "1" ? "" : " " + unit);
    }
    const std::string rest = outcome.explained ? " With it what is left is noise."
                                               : " The value is the same in parts of the recordings looked at alone, "
                                                 "but something else is missing as well.";
    list.push_back({{"effect", info.name},
                    {"where", where},
                    {"parameters", make_parameters(e, outcome.chosen.std[i])},
                    {"probability", outcome.explained ? 0.98 : 0.9},
                    {"statement", info.name + " at " + where.begin().value().get<std::string>() + ": " +
                                      info.phrase + " (" + values + ")." + rest}});
  }
  return list;
}

// Root mean square of whitened rows of one joint over recordings (or one of them).
double calc_score(const RowProblem& problem, const RowHypothesis& hypothesis, size_t joint, int recording) {
  double sum = 0.0, count = 0.0;
  for (size_t r = 0; r < problem.recordings.size(); ++r) {
    if (recording >= 0 && static_cast<size_t>(recording) != r) continue;
    const std::vector<double> rows = calc_rows(problem, hypothesis, r);
    for (size_t k = joint; k < rows.size(); k += problem.sigma.size()) {
      if (std::isfinite(rows[k]) && problem.sigma[joint] > 0.0)
        sum += std::pow(rows[k] / problem.sigma[joint], 2), count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

std::string get_signal(const RowProblem& problem, size_t joint) {
  if (problem.experiment->robot.tree.joint(static_cast<int>(joint)).actuated)
    return "/joint_states/" + get_joint(problem, joint) + "/effort";
  return "/wrench/" + problem.sensors[0].name + "/force";  // a joint without a drive: its equation is the foot force's
}

Json make_mismatch(const RowProblem& problem, const RowOutcome& outcome) {
  Json list = Json::array();
  for (size_t j = 0; outcome.mismatch && j < problem.sigma.size(); ++j) {
    for (size_t r = 0; r < problem.recordings.size(); ++r) {
      const double score = calc_score(problem, {}, j, static_cast<int>(r));
      if (score < 1.2) continue;
      // The worst half second.
      const std::vector<RowBlock> blocks = list_blocks(problem);
      const std::vector<double> rows = calc_rows(problem, {}, r);
      double worst = -1.0, from = 0.0, to = 0.0;
      for (const RowBlock& b : blocks) {
        double sum = 0.0;
        for (size_t k = b.first; b.recording == r && k < b.end; ++k) {
          const double v = rows[k * problem.sigma.size() + j];
          sum += std::isfinite(v) ? v * v : 0.0;
        }
        if (sum > worst && b.recording == r)
          worst = sum, from = problem.recordings[r].time[b.first], to = problem.recordings[r].time[b.end - 1];
      }
      list.push_back({{"signal", get_signal(problem, j)},
                      {"recording", problem.recordings[r].file},
                      {"score", score},
                      {"intervals", {{from, to}}},
                      {"regime", "foot loaded"}});
    }
  }
  return list;
}

Json make_unexplained(const RowProblem& problem, const RowOutcome& outcome) {
  Json list = Json::array();
  if (!outcome.mismatch || outcome.explained) return list;
  for (size_t j = 0; j < problem.sigma.size(); ++j) {
    const double score = calc_score(problem, outcome.chosen.hypothesis, j, -1);
    if (score < 1.2) continue;
    std::string where;
    for (size_t r = 0; r < problem.recordings.size(); ++r) {
      const double here = calc_score(problem, outcome.chosen.hypothesis, j, static_cast<int>(r));
      if (here > 0.0) where += (where.empty() ? "" : ", ") + number(here, 3) + " in " + problem.recordings[r].file;
    }
    list.push_back({{"where", {{"joint", get_joint(problem, j)}}},
                    {"depends_on", {"load"}},
                    {"statement", "At " + get_joint(problem, j) + " the equation of motion is left with " + where +
                                      " times the noise."}});
  }
  return list;
}

Json make_not_identifiable(const RowProblem& problem) {
  Json list = Json::array();
  for (size_t j = 0; j < problem.sigma.size(); ++j) {
    bool used = false;
    for (const RowRecording& r : problem.recordings) used = used || r.rows[j];
    if (used) continue;
    list.push_back(
        {{"effect", "coulomb_friction"},
         {"why", "An unknown force acts along joint " + get_joint(problem, j) + ", or its motion was not recorded."},
         {"motion_that_would_tell", "a recording without that force, with the joint's position"}});
  }
  return list;
}

Json make_per_signal(const RowProblem& problem, const RowOutcome& outcome) {
  Json out = Json::object();
  for (size_t j = 0; j < problem.sigma.size(); ++j) {
    double mean = 0.0, square = 0.0, count = 0.0;
    for (const RowRecording& r : problem.recordings) {
      for (long k = 0; r.rows[j] && k < r.effort.rows(); ++k) {
        const double v = r.effort(k, static_cast<long>(j));
        mean += v, square += v * v, count += 1.0;
      }
    }
    const double spread =
        std::sqrt(std::max(0.0, square / std::max(1.0, count) - std::pow(mean / std::max(1.0, count), 2)));
    if (spread <= 0.0) continue;
    out[get_signal(problem, j)] = {
        {"before", problem.sigma[j] * calc_score(problem, {}, j, -1) / spread},
        {"after", problem.sigma[j] * calc_score(problem, outcome.chosen.hypothesis, j, -1) / spread}};
  }
  return out;
}

Json make_traces(const RowProblem& problem, const RowOutcome& outcome, size_t r) {
  const RowRecording& recording = problem.recordings[r];
  const std::vector<double> before = calc_rows(problem, {}, r),
                            after = calc_rows(problem, outcome.chosen.hypothesis, r);
  const size_t n = problem.sigma.size(), stride = recording.time.size() / 600 + 1;
  Json traces = Json::array();
  for (size_t j = 0; j < n; ++j) {
    if (!recording.rows[j]) continue;
    Json time = Json::array(), recorded = Json::array(), jb = Json::array(), ja = Json::array();
    for (size_t k = 0; k < recording.time.size(); k += stride) {
      const double v = recording.effort(static_cast<long>(k), static_cast<long>(j));
      if (!std::isfinite(before[k * n + j]) || !std::isfinite(after[k * n + j])) continue;
      time.push_back(recording.time[k]), recorded.push_back(v);
      jb.push_back(v - before[k * n + j]), ja.push_back(v - after[k * n + j]);
    }
    traces.push_back({{"signal", j}, {"time", time}, {"recorded", recorded}, {"before", jb}, {"after", ja}});
  }
  return traces;
}

}  // namespace

Json make_row_report(const RowProblem& problem, const RowOutcome& outcome) {
  Json report{{"schema", 1}};
  report["verdict"] = !outcome.mismatch   ? "no_mismatch"
                      : outcome.explained ? "explained"
                      : outcome.partly    ? "partly_explained"
                                          : "unexplained";
  report["mismatch"] = make_mismatch(problem, outcome);
  report["findings"] = make_findings(problem, outcome);
  report["unexplained"] = make_unexplained(problem, outcome);
  report["not_identifiable"] = make_not_identifiable(problem);
  report["fit"] = {{"train", {{"before", outcome.nominal.train}, {"after", outcome.chosen.train}}},
                   {"validate", {{"before", outcome.nominal.held}, {"after", outcome.chosen.held}}},
                   {"per_signal", make_per_signal(problem, outcome)}};
  report["prediction"] = {
      {"method",
       "equations of motion along the recorded motion with the measured foot force; validate: " + outcome.held},
      {"horizon", 0.0}};
  report["least_squares"] = {{"effects", "viscous_friction, coulomb_friction, rotor_inertia at every driven joint"},
                             {"train", outcome.baseline.train},
                             {"validate", outcome.baseline.held}};
  report["warnings"] = problem.experiment->warnings;
  return report;
}

Json make_row_series(const RowProblem& problem, const RowOutcome& outcome) {
  Json series{{"schema", 1}, {"experiment", problem.experiment->path}, {"robot", problem.experiment->robot.tree.name}};
  for (size_t j = 0; j < problem.sigma.size(); ++j) {
    const bool turns = problem.experiment->robot.tree.joint(static_cast<int>(j)).kind == JointKind::kRevolute;
    series["signals"].push_back({{"name", get_signal(problem, j)},
                                 {"unit", turns ? "N m" : "N"},
                                 {"noise", problem.sigma[j]},
                                 {"noise_source", "estimated"}});
  }
  series["recordings"] = Json::array();
  for (size_t r = 0; r < problem.recordings.size(); ++r) {
    const RowRecording& recording = problem.recordings[r];
    series["recordings"].push_back({{"file", recording.file},
                                    {"role", recording.train ? "train" : "validate"},
                                    {"start", recording.time.front()},
                                    {"end", recording.time.back()},
                                    {"traces", make_traces(problem, outcome, r)}});
  }
  series["rivals"] = Json::array();
  for (const RowTrial& trial : outcome.trials) {
    series["rivals"].push_back(
        {{"effect", get_effect(trial.added.id).name},
         {"where", make_where(problem, trial.added)},
         {"probability", trial.accepted ? 0.9 : 0.0},
         {"validate_score", trial.fit.held},
         {"complexity", trial.fit.hypothesis.size()},
         {"chosen", trial.accepted},
         {"why", trial.accepted ? "takes away most, alike in every part of the recordings" : trial.why}});
  }
  series["notes"] = problem.experiment->warnings;
  return series;
}

}  // namespace hrp::diagnosis::held_feet
