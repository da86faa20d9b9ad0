// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/explanations.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/torque/terms.h"
#include "diagnosis/next/limits.h"
#include "diagnosis/report/json.h"
#include "diagnosis/search/explore.h"
#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kLargest = 6;  // findings that are replaced in turn
constexpr double kNats = 10.0;

// Value of a parameter; the law's default or the neutral value if the report does not state one.
double find_value(const Json& parameters, const EffectParameter& info) {
  const double value = read_value(parameters, info);
  if (std::isfinite(value)) return value;
  return (info.stated && !info.required) || !std::isfinite(info.neutral) ? info.value : info.neutral;
}

Hypothesis without(const Hypothesis& hypothesis, size_t at) {
  Hypothesis rest = hypothesis;
  rest.erase(rest.begin() + static_cast<long>(at));
  return rest;
}

double find_margin(const Problem& problem, double cost) {
  // Held-out recordings as bad as the others may decide either way within it.
  return kDetail * cost + 2.0 * kNats * std::max(1.0, cost / std::max(1.0, count_readings(problem)));
}

class Finder {
 public:
  Finder(const Problem& problem, const Progress& progress)
      : problem_(problem), progress_(progress), explorer_(problem) {}

  Explanations run(const Json& report) {
    const Hypothesis model = read_model(*problem_.experiment, report);
    add(explorer_.make_lead(model), true);
    if (model.empty())
      add_first_effects(report);
    else
      add_replacements(report, model);
    choose();
    out_.discrepancy = find_discrepancy();
    return out_;
  }

 private:
  void add(const Lead& lead, bool listed) {
    const EffectSet set = make_set(lead.hypothesis);
    for (Explanation& known : out_.list) {
      if (make_set(known.hypothesis) != set) continue;
      known.listed = known.listed || listed;
      if (lead.cost < known.cost) {
        known.hypothesis = lead.hypothesis;
        known.cost = lead.cost;
      }
      return;
    }
    out_.list.push_back({lead.hypothesis, get_label(*problem_.experiment, lead.hypothesis), lead.cost, listed});
  }

  // Adds sets with one more effect; at `quiet` joints only effects that other joints show, too.
  void add_grown(const Hypothesis& rest, const std::vector<char>& quiet) {
    for (const Lead& lead : explorer_.grow({explorer_.make_lead(rest)}, kShortList, quiet)) add(lead, false);
  }

  std::vector<char> make_quiet(bool quiet) const {
    return std::vector<char>(static_cast<size_t>(problem_.experiment->num_joints()), quiet);
  }

  void add_first_effects(const Json& report) {
    if (report.value("verdict", "") != "no_mismatch") return add_grown({}, make_quiet(false));
    out_.unseen = true;
    add_hidden();
  }

  // Finds what each finding may be instead, whether the report lists it or not. Effects of the model without a finding
  // stay.
  void add_replacements(const Json& report, const Hypothesis& model) {
    size_t tried = 0;
    for (const Json& finding : report.value("findings", Json::array())) {
      Effect found;
      if (!read_effect(*problem_.experiment, finding, &found)) continue;
      const auto at = std::find_if(model.begin(), model.end(),
                                   [&](const Effect& e) { return e.id == found.id && e.place == found.place; });
      Hypothesis rest = model;
      if (at != model.end()) rest = without(model, static_cast<size_t>(at - model.begin()));
      add_listed(finding, rest);
      if (at == model.end() || ++tried > kLargest) continue;
      progress_("what may stand for " + get_label(*problem_.experiment, found));
      const int joint = find_joint(found);
      std::vector<char> quiet = make_quiet(joint >= 0);
      if (joint >= 0) quiet[static_cast<size_t>(joint)] = 0;
      add_grown(rest, quiet);
    }
  }

  void add_listed(const Json& finding, const Hypothesis& rest) {
    for (Json alternative : finding.value("alternatives", Json::array())) {
      if (!alternative.contains("where") || alternative["where"].empty()) alternative["where"] = finding["where"];
      Effect other;
      if (!read_effect(*problem_.experiment, alternative, &other) || contains(rest, other.id, other.place)) continue;
      Hypothesis together = rest;
      together.push_back(other);
      add(explorer_.make_lead(together), true);
    }
  }

  // Adds dry friction and a rotor at joints that hardly moved. They would appear as soon as the joint moves.
  void add_hidden() {
    const Experiment& e = *problem_.experiment;
    for (int j = 0; j < e.num_joints() && out_.list.size() < kShortList; ++j) {
      if (calc_travel(e, j) > kStill && !is_all_still()) continue;
      const Hypothesis friction = make_hidden_friction(e, j);
      if (!friction.empty()) out_.list.push_back({friction, get_label(e, friction), 0.0, false});
    }
  }

  bool is_all_still() const {
    for (int j = 0; j < problem_.experiment->num_joints(); ++j) {
      if (calc_travel(*problem_.experiment, j) > kStill) return false;
    }
    return true;
  }

  // Keeps the best explanation and those that are about as good. Alternatives of the report stay, even if their stated
  // values fit worse here.
  void choose() {
    if (out_.unseen) return;
    std::vector<Explanation>& list = out_.list;
    const bool named = !list[0].hypothesis.empty();
    std::stable_sort(list.begin() + (named ? 1 : 0), list.end(),
                     [](const Explanation& a, const Explanation& b) { return a.cost < b.cost; });
    double least = 1e300;
    for (const Explanation& one : list) least = std::min(least, one.cost);
    const double most = std::max(list[0].cost, least + find_margin(problem_, least));
    std::vector<Explanation> kept{list[0]};
    for (size_t i = 1; i < list.size(); ++i) {
      if (kept.size() < kShortList && !list[i].hypothesis.empty() &&
          (list[i].listed || (list[i].cost <= most && !is_given_up(list[i], list[0]))))
        kept.push_back(list[i]);
    }
    list = kept;
  }

  // True for a richer explanation that does not fit better: the report prefers the simpler one, whatever is recorded
  // next.
  bool is_given_up(const Explanation& rival, const Explanation& best) const {
    const double readings = count_readings(problem_), unit = std::max(1.0, best.cost / std::max(1.0, readings));
    const double dearer = std::min(0.0, rival.cost - best.cost) / unit + calc_own_price(rival.hypothesis, readings) -
                          calc_own_price(best.hypothesis, readings);
    const double more = static_cast<double>(count_parameters(rival.hypothesis)) -
                        static_cast<double>(count_parameters(best.hypothesis));
    const double odds = calc_odds(dearer, more);
    return odds / (1.0 + odds) <= kDetail;
  }

  double find_discrepancy() const {
    std::vector<int> all = problem_.train;
    all.insert(all.end(), problem_.validate.begin(), problem_.validate.end());
    const Score score = calc_score(problem_, out_.list[0].hypothesis, all);
    return score.ok ? std::max(1.0, score.rms()) : 1.0;
  }

  const Problem& problem_;
  const Progress& progress_;
  Explorer explorer_;
  Explanations out_;
};

}  // namespace

double count_readings(const Problem& problem) {
  double count = 0.0;
  for (const Recording& r : problem.experiment->recordings) {
    for (const JointColumns& joint : r.joints) {
      for (const auto& signal : joint.signal) count += static_cast<double>(signal.size());
    }
  }
  return count;
}

Hypothesis make_hidden_friction(const Experiment& experiment, int joint) {
  const double effort = experiment.robot.tree.joint(joint).effort_limit;
  if (!std::isfinite(effort)) return {};
  Effect friction{find_term_row(&TermRow::level).effect->id, joint, {}};
  for (const EffectParameter& info : list_infos(friction.id))
    friction.p.push_back(info.name == "level" ? kMinor * effort : info.value);
  return {friction};
}

bool read_effect(const Experiment& experiment, const Json& entry, Effect* effect) {
  const EffectInfo* info = find_effect(entry.value("effect", ""));
  if (!info || !info->apply || !entry.contains("where")) return false;
  if (info->place != PlaceKind::kJoint && info->place != PlaceKind::kLink && info->place != PlaceKind::kSensor)
    return false;
  effect->id = info->id;
  effect->place = find_place(experiment, *info, entry["where"]);
  if (effect->place.index < 0) return false;
  effect->p.clear();
  const Json parameters = entry.value("parameters", Json::object());
  for (const EffectParameter& p : list_infos(info->id)) effect->p.push_back(find_value(parameters, p));
  return true;
}

Hypothesis read_model(const Experiment& experiment, const Json& report) {
  Json list = report.value("model", Json::array());
  if (list.empty()) list = report.value("findings", Json::array());
  Hypothesis model;
  for (const Json& entry : list) {
    Effect effect;
    if (read_effect(experiment, entry, &effect) && !contains(model, effect.id, effect.place)) model.push_back(effect);
  }
  return model;
}

Explanations find_explanations(const Problem& problem, const Json& report, const Progress& progress) {
  return Finder(problem, progress).run(report);
}

}  // namespace hrp::diagnosis
