// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/report/report.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/model/nominal.h"

#include <algorithm>
#include <cmath>

#include "common/effects/units.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/report/effect_shares.h"
#include "diagnosis/report/series.h"
#include "diagnosis/search/dependence.h"
#include "diagnosis/search/outcome.h"
#include "diagnosis/search/subtrees.h"

namespace hrp::diagnosis {
namespace {

// Stretches [s, s] in which the residual stays above `level`, in bins of 50 samples or fewer.
std::vector<std::pair<double, double>> find_stretches(const Recording& recording, const std::vector<double>& residuals,
                                                      size_t width, size_t c, double level) {
  std::vector<std::pair<double, double>> list;
  const std::vector<double>& column = recording.joints[c / kQuantities].signal[c % kQuantities];
  const size_t bin = std::max<size_t>(5, recording.size() / 200);
  for (size_t k = 0; k < recording.size(); k += bin) {
    double sum = 0.0, count = 0.0;
    const size_t end = std::min(recording.size(), k + bin);
    for (size_t i = k; i < end; ++i) {
      if (!std::isfinite(column[i])) continue;
      sum += residuals[i * width + c] * residuals[i * width + c];
      count += 1.0;
    }
    if (count == 0.0 || std::sqrt(sum / count) < level) continue;
    const double from = recording.time[k], to = recording.time[end - 1];
    if (!list.empty() && from - list.back().second < 2.5 * (to - from) + 1e-9)
      list.back().second = to;
    else
      list.emplace_back(from, to);
  }
  if (list.size() > 12) list.resize(12);
  return list;
}

// Where the mean square residual is largest in comparison.
std::string find_regime(const Problem& problem, int r, size_t c, const std::vector<double>& residuals) {
  const SmoothRecording& smooth = problem.smooth[static_cast<size_t>(r)];
  const size_t j = c / kQuantities, width = problem.weights.size();
  const SmoothJoint& joint = smooth.joints[j];
  const std::vector<double>& u = smooth.effort[j];
  double fastest = 1e-12, hardest = 1e-12;
  for (size_t k = 0; k < joint.qd.size(); ++k) {
    fastest = std::max(fastest, std::abs(joint.qd[k]));
    if (!u.empty()) hardest = std::max(hardest, std::abs(u[k]));
  }
  const char* const names[] = {"motion", "velocity reversal", "high load", "high speed"};
  double sum[4] = {0, 0, 0, 0}, count[4] = {0, 0, 0, 0};
  for (size_t k = smooth.start; k < joint.qd.size(); ++k) {
    const double v = std::abs(joint.qd[k]) / fastest, load = u.empty() ? 0.0 : std::abs(u[k]) / hardest;
    const int regime = v < 0.06 ? 1 : load > 0.75 ? 2 : v > 0.75 ? 3 : 0;
    const double x = residuals[k * width + c];
    sum[regime] += x * x;
    count[regime] += 1.0;
  }
  int best = 0;
  double highest = 0.0, all = 0.0, n = 0.0;
  for (int i = 0; i < 4; ++i) {
    all += sum[i];
    n += count[i];
    if (count[i] >= 20.0 && sum[i] / count[i] > highest) {
      highest = sum[i] / count[i];
      best = i;
    }
  }
  return best != 0 && highest < 1.5 * all / std::max(1.0, n) ? "motion" : names[best];
}

std::vector<Mismatch> list_mismatches(const Problem& problem, const Outcome& outcome) {
  std::vector<Mismatch> list;
  if (!outcome.mismatch) return list;
  const Experiment& e = *problem.experiment;
  struct Entry {
    double score;
    int r;
    size_t c;
  };
  std::vector<Entry> entries;
  std::vector<std::vector<double>> residuals(e.recordings.size());
  const size_t width = problem.weights.size();
  for (size_t r = 0; r < e.recordings.size(); ++r) {
    if (!calc_residuals(problem, outcome.nominal.full(), static_cast<int>(r), &residuals[r])) continue;
    const Score s = calc_score(problem, outcome.nominal.full(), {static_cast<int>(r)});
    for (size_t c = 0; c < width; ++c) {
      // 4 / sqrt(n / 50): beyond chance over all signals and recordings at a correlation length of 50 samples.
      if (s.rms(c) > 1.5 + 4.0 / std::sqrt(std::max(1.0, s.signal_count[c] / 50.0)) * 0.5)
        entries.push_back({s.rms(c), static_cast<int>(r), c});
    }
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.score > b.score; });
  if (entries.size() > 24) entries.resize(24);
  for (const Entry& entry : entries) {
    const Recording& recording = e.recordings[static_cast<size_t>(entry.r)];
    const auto& x = residuals[static_cast<size_t>(entry.r)];
    list.push_back({signal_name(e, entry.c), recording.spec.name, entry.score,
                    find_stretches(recording, x, width, entry.c, std::max(2.0, 0.7 * entry.score)),
                    find_regime(problem, entry.r, entry.c, x)});
  }
  return list;
}

// ", 0.54 forward and 0.32 backward" of a value that differs by direction by more than its own interval; else empty.
std::string describe_directions(const Effect& effect, double std) {
  const std::vector<EffectParameter>& infos = list_infos(effect.id);
  const auto at = std::find_if(infos.begin(), infos.end(), [](const EffectParameter& p) { return p.by_direction; });
  if (at == infos.end()) return "";
  const double level = effect.p[0], more = level * effect.p[static_cast<size_t>(at - infos.begin())];
  return std::abs(more) > 2.0 * std
             ? ", " + number(level + more, 3) + " forward and " + number(level - more, 3) + " backward"
             : "";
}

std::string make_statement(const Problem& problem, const Outcome& outcome, const Effect& effect,
                           const std::vector<double>& std) {
  const Experiment& e = *problem.experiment;
  const std::vector<EffectParameter>& infos = list_infos(effect.id);
  std::string text = get_place_text(e, effect) + ": " + get_effect(effect.id).phrase + ".";
  for (size_t i = 0; i < effect.p.size(); ++i) {
    if (infos[i].nuisance) continue;
    text += std::string(i == 0 ? " " : ", ") + infos[i].key();
    if (2.0 * std[i] > kTenTimes * std::abs(effect.p[i])) {
      text += " not shown by this motion";
      continue;
    }
    text += " " + number(effect.p[i]) + " +- " + number(2.0 * std[i], 2) +
            (infos[i].unit == "1" ? "" : " " + get_place_unit(e, effect, infos[i]));
  }
  text += describe_directions(effect, std[0]) + ". Held-out error falls from " + number(outcome.nominal.rms, 3) +
          " to " + number(outcome.chosen.rms, 3) + " times the noise.";
  for (const Trial& rival : outcome.rivals) {
    if (rival.hypothesis.size() != outcome.chosen.hypothesis.size() || rival.rms <= outcome.chosen.rms) continue;
    const auto is_same = [&](const Trial& t) { return make_set(t.hypothesis) == make_set(rival.hypothesis); };
    if (is_same(outcome.chosen) ||
        std::any_of(outcome.indistinguishable.begin(), outcome.indistinguishable.end(), is_same))
      continue;
    text += " The next best explanation, " + get_label(e, rival.hypothesis) + ", leaves " + number(rival.rms, 3) + ".";
    break;
  }
  return text;
}

// Share of the held-out squares above the noise that each effect of the chosen model takes away.
std::vector<double> calc_shares(const Problem& problem, const Outcome& outcome) {
  return calc_effect_shares(outcome.chosen.hypothesis, outcome.nominal.rms, [&](const Hypothesis& part) {
    Trial trial = outcome.chosen;
    trial.hypothesis = part;
    const Score score = calc_score(problem, part.empty() ? outcome.nominal.full() : trial.full(), get_judged(problem));
    return score.ok ? score.rms() : outcome.nominal.rms;
  });
}

constexpr const char* kOtherMotion =
    "slow and fast sweeps of the joint over its whole range with stops in between, in postures of different load";

// Effects that do as well in the place of one, all others as they are; with how they were fitted. A rival of one
// subtree holds the effects of that subtree only. Of a set that differs by more, those that no set has beside this
// effect.
std::vector<Alternative> list_alternatives(const Problem& problem, const Outcome& outcome, const Effect& effect) {
  std::vector<Alternative> list;
  const Experiment& e = *problem.experiment;
  Hypothesis listed;
  const Hypothesis& chosen = outcome.chosen.hypothesis;
  for (const Trial& rival : outcome.indistinguishable) {
    const auto is_in = [](const Hypothesis& all, const Effect& one) { return contains(all, one.id, one.place); };
    std::vector<size_t> others;
    for (size_t i = 0; i < rival.hypothesis.size(); ++i) {
      if (!is_in(chosen, rival.hypothesis[i])) others.push_back(i);
    }
    if ((others.size() != 1 && !outcome.as_set) || is_in(rival.hypothesis, effect)) continue;
    for (size_t i : others) {
      const Effect& other = rival.hypothesis[i];
      const auto has_both = [&](const Trial& t) { return is_in(t.hypothesis, other) && is_in(t.hypothesis, effect); };
      if (outcome.as_set && (is_in(listed, other) ||
                             std::any_of(outcome.indistinguishable.begin(), outcome.indistinguishable.end(), has_both)))
        continue;
      listed.push_back(other);
      list.push_back(make_alternative(get_effect(other.id), make_where(e, other),
                                      list_estimates(e, other, get_std(rival, i)), kOtherMotion));
    }
  }
  return list;
}

std::vector<Finding> list_findings(const Problem& problem, const Outcome& outcome) {
  std::vector<Finding> list;
  if (!outcome.explained && !outcome.partly) return list;
  const Experiment& e = *problem.experiment;
  const std::vector<double> shares = calc_shares(problem, outcome);
  for (size_t i = 0; i < outcome.chosen.hypothesis.size(); ++i) {
    const Effect& effect = outcome.chosen.hypothesis[i];
    const std::vector<double> std = get_std(outcome.chosen, i);
    list.push_back(make_finding(get_effect(effect.id), make_where(e, effect), list_estimates(e, effect, std)));
    Finding& f = list.back();
    f.share = f.weight = std::clamp(shares[i], 0.0, 1.0);
    f.probability = std::min(kSurest, outcome.chosen.probability * (outcome.explained ? 1.0 : 0.8));
    f.statement = make_statement(problem, outcome, effect, std);
    f.alternatives = list_alternatives(problem, outcome, effect);
    f.also_fitted = list_also_fitted(effect);
    if (!outcome.as_set) continue;
    f.grade = Grade::kAmbiguous;
    f.statement += " What is left has another cause, so it is not supported.";
  }
  return list;
}

// The effects that come closest with their values, and what they leave, where nothing is explained; null if none come
// close.
Json make_closest(const Problem& problem, const Outcome& outcome) {
  const Trial* closest = outcome.explained || outcome.partly ? nullptr : find_told_closest(problem, outcome);
  if (!closest) return nullptr;
  const Experiment& e = *problem.experiment;
  Json effects = Json::array(), others = Json::array();
  for (size_t i = 0; i < closest->hypothesis.size(); ++i) {
    const Effect& effect = closest->hypothesis[i];
    effects.push_back({{"effect", get_effect(effect.id).name},
                       {"where", make_where(e, effect)},
                       {"parameters", make_estimates(list_estimates(e, effect, get_std(*closest, i)))}});
  }
  for (const Trial* other : list_as_close(outcome, *closest)) others.push_back(get_label(e, other->hypothesis));
  return {{"effects", effects},
          {"others", others},
          {"times_noise", {{"before", round_to(outcome.nominal.rms, 4)}, {"after", round_to(closest->rms, 4)}}}};
}

std::vector<Unexplained> list_unexplained(const Problem& problem, const Outcome& outcome) {
  std::vector<Unexplained> list;
  if (!outcome.mismatch || outcome.explained) return list;
  const Experiment& e = *problem.experiment;
  const Trial& base = outcome.partly ? outcome.chosen : outcome.nominal;
  for (const Dependence& d : find_dependence(problem, base.hypothesis, base.validate)) {
    const std::string& words = d.relation.words;
    list.push_back({{{"joint", e.robot.tree.joint(d.joint).name}},
                    d.relation.names,
                    e.robot.tree.joint(d.joint).name + ": about " + number(d.effort, 3) + " " +
                        get_joint_unit(e.robot.tree.joint(d.joint), "N m") +
                        " (root mean square) are missing that no effect of the list explains; they follow " +
                        (words.empty() ? "none of position, velocity, direction, load or time alone" : words) + "."});
  }
  if (list.empty()) return list;
  if (outcome.spent)
    list.back().statement +=
        " Not all sets of effects were tried: the search ended at its usual work (hrp-diagnose --patience 4 goes four "
        "times as far).";
  return list;
}

std::vector<NotIdentifiable> list_not_identifiable(const Problem& problem, const Outcome& outcome) {
  std::vector<NotIdentifiable> list;
  const bool named = outcome.explained || outcome.partly;
  const std::string data = problem.validate.empty() ? "recordings" : "held-out recordings";
  const std::string why = named ? "explains the " + data + " about as well as what is reported"
                                : "is in one of several sets of effects that explain the " + data +
                                      " about equally; none of them is reported";
  for (const Trial& rival : outcome.indistinguishable) {
    for (const Effect& effect : rival.hypothesis) {
      if (contains(outcome.chosen.hypothesis, effect.id, effect.place)) continue;
      list.push_back({get_effect(effect.id).name, make_where(*problem.experiment, effect), why, kOtherMotion});
    }
  }
  return list;
}

}  // namespace

Json list_also_fitted(const Effect& effect) {
  Json values = Json::object();
  const std::vector<EffectParameter>& infos = list_infos(effect.id);
  for (size_t i = 0; i < infos.size(); ++i) {
    const bool open = infos[i].scanned && effect.p[i] == infos[i].value;  // nobody asked
    if (infos[i].nuisance && infos[i].stated && !open) values[infos[i].name] = round_to(effect.p[i], 8);
  }
  return values;
}

double calc_channel_spread(const Experiment& e, const std::vector<int>& recordings, size_t channel) {
  Spread spread;
  for (int r : recordings) {
    for (double y : e.recordings[static_cast<size_t>(r)].joints[channel / kQuantities].signal[channel % kQuantities])
      spread.add(y);
  }
  return spread.get();
}

Fit calc_simulation_fit(const Problem& problem, const Trial& before, const Trial& after) {
  static const char* const units[] = {"rad", "rad/s", "N m"};
  const Experiment& e = *problem.experiment;
  Fit fit{before.train.rms(), after.train.rms(), before.rms, after.rms, {}};
  for (size_t c = 0; c < problem.weights.size(); ++c) {
    const double spread = calc_channel_spread(e, get_judged(problem), c), noise = 1.0 / problem.weights[c];
    if (spread <= 0.0) continue;
    const JointSpec& joint = e.robot.tree.joint(static_cast<int>(c / kQuantities));
    fit.signals.push_back({signal_name(e, c), get_joint_unit(joint, units[c % kQuantities]),
                           noise * before.validate.rms(c), noise * after.validate.rms(c), spread});
  }
  return fit;
}

Reports make_reports(const Problem& problem, const Outcome& outcome) {
  const Experiment& e = *problem.experiment;
  const bool driven = is_effort_driven(e);
  const Trial& after = outcome.explained || outcome.partly || outcome.modelled ? outcome.chosen : outcome.nominal;
  Evidence evidence;
  evidence.verdict = find_verdict(outcome.mismatch, outcome.explained, outcome.partly);
  evidence.mismatch = list_mismatches(start_as(problem, outcome.nominal), outcome);
  evidence.findings = list_findings(problem, outcome);
  evidence.unexplained = list_unexplained(problem, outcome);
  evidence.not_identifiable = list_not_identifiable(problem, outcome);
  evidence.fit = calc_simulation_fit(problem, outcome.nominal, after);
  evidence.method =
      driven ? "simulation from the recorded efforts, drawn to the recorded motion at 8 rad/s"
             : "simulation from the recording's commands over the whole recording but its first 0.6 s (a tenth of a "
               "short one), which settle the state it starts from; while a drive is at its limit the simulated joint "
               "is drawn to the recorded one at 8 rad/s";
  evidence.horizon = driven ? 0.125 : e.recordings[0].duration();
  evidence.warnings = e.warnings;
  Reports reports;
  reports.report = make_graded_report(!problem.validate.empty(), evidence);
  if (outcome.as_set) reports.report["as_set"] = true;
  if (Json closest = make_closest(problem, outcome); !closest.is_null()) reports.report["closest"] = std::move(closest);
  reports.series = make_series(problem, outcome, after);
  reports.series["prediction"] = reports.report["prediction"];
  return reports;
}

Reports make_empty_reports(const Problem& problem, const std::string& reason) {
  const Experiment& e = *problem.experiment;
  Evidence evidence;
  evidence.summary = "The recordings could not be judged: " + reason + ".";
  evidence.method = "none";
  evidence.warnings = e.warnings;
  Reports reports;
  reports.report = make_report(evidence);
  reports.series = {{"schema", 1}, {"experiment", e.robot.tree.name}, {"notes", e.warnings}};
  return reports;
}

}  // namespace hrp::diagnosis
