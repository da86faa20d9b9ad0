// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/data/held_out.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/report/json.h"
#include "diagnosis/toss/search.h"

namespace hrp::diagnosis::toss {
namespace {

const char* const kSignals[] = {"/base/pose/position/x",
                                "/base/pose/position/y",
                                "/base/pose/position/z",
                                "/base/pose/orientation (turn about x)",
                                "/base/pose/orientation (turn about y)",
                                "/base/pose/orientation (turn about z)"};

Json make_where(const TossProblem& problem, EffectId id) {
  const Place& place = get_toss_row(id).place;
  if (place.kind == PlaceKind::kLink) return {{"link", problem.nominal.body.links[0].name}};
  if (place.kind == PlaceKind::kGround) return {{"ground", "ground"}};
  if (place.reading == Reading::kAll) return {{"sensor", "/base/pose"}};
  return {{"sensor", place.reading == Reading::kPosition ? "/base/pose/position" : "/base/pose/orientation"}};
}

// True for scalars: a single axis of a quantity that is no vector stands for all axes.
bool is_scalar(const TossRow& row, size_t i) {
  return row.parameters[i].info->axis < 0 || (row.parameters.size() == 1 && !get_effect(row.id).vector);
}

std::string get_unit(const TossRow& row, size_t i) {
  const std::string& unit = row.parameters[i].info->unit;
  return unit.empty() ? row.unit : unit;
}

std::vector<Estimate> list_parameters(const Effect& effect, const std::vector<double>& std) {
  const TossRow& row = get_toss_row(effect);
  std::vector<Estimate> out;
  for (size_t i = 0; i < effect.p.size(); ++i) {
    const EffectParameter& parameter = *row.parameters[i].info;
    const std::string unit = get_unit(row, i);
    if (is_scalar(row, i))
      out.push_back(make_one(parameter.name, unit, effect.p[i], std[i]));
    else if (parameter.axis == 0)
      out.push_back({parameter.name, unit, {&effect.p[i], &effect.p[i] + 3}, {&std[i], &std[i] + 3}, true});
  }
  return out;
}

std::string describe(const TossProblem& problem, const Effect& effect, const std::vector<double>& std) {
  const TossRow& row = get_toss_row(effect);
  std::string text;
  for (size_t i = 0; i < effect.p.size(); ++i) {
    const EffectParameter& parameter = *row.parameters[i].info;
    text += (i ? ", " : "") + (is_scalar(row, i) ? parameter.name : parameter.key()) + " " + number(effect.p[i], 3) +
            " +- " + number(kNinetyFive * std[i], 3);
    const std::string unit = get_unit(row, i);
    if (unit != "1") text += " " + unit;
  }
  text += ", where the model has ";
  const Effect neutral = make_neutral(problem, effect.id);
  for (size_t i = 0; i < neutral.p.size(); ++i) text += (i ? ", " : "") + number(neutral.p[i], 3);
  return text;
}

// Residuals of a fit by toss and sample; NaN outside its windows.
struct Left {
  std::vector<std::vector<double>> by_toss;  // [sample * 6 + signal], whitened
  std::vector<Regime> worst;                 // by window: regime with the most contact
};

Left calc_left(const TossProblem& problem, const TossFit& fit) {
  Left left;
  for (const Toss& t : problem.tosses) left.by_toss.emplace_back(6 * t.p.size(), std::nan(""));
  for (size_t i = 0; i < problem.windows.size(); ++i) {
    const Window& w = problem.windows[i];
    std::vector<Regime> regimes;
    const std::vector<double> r = calc_window_residuals(problem, fit.hypothesis, w, fit.starts[i], &regimes);
    std::copy(r.begin(), r.end(), left.by_toss[w.toss].begin() + static_cast<long>(6 * w.first));
    Regime worst = Regime::kFlight;
    for (Regime g : regimes) {
      if (g == Regime::kImpact || (g == Regime::kContact && worst == Regime::kFlight)) worst = g;
    }
    left.worst.push_back(worst);
  }
  return left;
}

// Rms over the samples of a role and of a toss (-1: all) in one signal (-1: all); 0 if there are none.
double calc_score(const TossProblem& problem, const Left& left, int role, int toss, int signal) {
  double sum = 0.0, count = 0.0;
  for (size_t t = 0; t < problem.tosses.size(); ++t) {
    if ((role >= 0 && problem.tosses[t].train != (role == 1)) || (toss >= 0 && static_cast<size_t>(toss) != t))
      continue;
    for (size_t i = 0; i < left.by_toss[t].size(); ++i) {
      const double r = left.by_toss[t][i];
      if (!std::isfinite(r) || (signal >= 0 && static_cast<int>(i % 6) != signal)) continue;
      sum += r * r;
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

const char* get_regime_name(Regime regime) {
  return regime == Regime::kImpact ? "impact" : regime == Regime::kContact ? "sliding, rolling or rest" : "flight";
}

std::vector<Mismatch> list_mismatches(const TossProblem& problem, const TossOutcome& outcome, const Left& before) {
  std::vector<Mismatch> list;
  if (!outcome.mismatch) return list;
  std::vector<size_t> order(problem.windows.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return outcome.nominal.misfit[a] > outcome.nominal.misfit[b]; });
  for (size_t i = 0; i < std::min<size_t>(12, order.size()); ++i) {
    const Window& w = problem.windows[order[i]];
    const Toss& t = problem.tosses[w.toss];
    int signal = 0;
    double worst = 0.0;
    for (int s = 0; s < 6; ++s) {
      double sum = 0.0;
      for (size_t k = w.first; k < w.first + w.count; ++k)
        sum += std::pow(before.by_toss[w.toss][6 * k + static_cast<size_t>(s)], 2);
      if (sum > worst) {
        worst = sum;
        signal = s;
      }
    }
    list.push_back({kSignals[signal],
                    t.file,
                    std::sqrt(outcome.nominal.misfit[order[i]]),
                    {{t.time[w.first], t.time[w.first + w.count - 1]}},
                    get_regime_name(before.worst[order[i]])});
  }
  return list;
}

// Standard deviations for intervals: they contain the spread between tosses.
std::vector<double> find_widths(const TossFit& fit, size_t effect) {
  std::vector<double> widths = fit.std[effect];
  for (size_t i = 0; i < widths.size(); ++i) widths[i] = std::hypot(widths[i], fit.spread[effect][i]);
  return widths;
}

Finding make_toss_finding(const TossProblem& problem, const Effect& effect, const std::vector<double>& widths,
                          double probability, const std::string& rest) {
  const EffectInfo& info = get_effect(effect.id);
  Finding f = make_finding(info, make_where(problem, effect.id), list_parameters(effect, widths));
  f.probability = probability;
  f.statement = info.name + ": " + info.phrase + " (" + describe(problem, effect, widths) + "). " + rest;
  return f;
}

// A finding that passes all tests but may stand in for impacts that differ from the model's law.
Finding make_doubted(const TossProblem& problem, const TossTrial& trial) {
  const size_t last = trial.fit.hypothesis.size() - 1;
  Finding f = make_toss_finding(problem, trial.fit.hypothesis[last], find_widths(trial.fit, last), 0.5,
                                std::string("Perhaps: ") + get_toss_row(trial.added).refused + ".");
  f.grade = Grade::kAmbiguous;
  const EffectInfo& law = get_effect(EffectId::kRestitution);
  f.alternatives = {make_alternative(law, make_where(problem, law.id), {},
                                     "the body swung as a pendulum, or turned by a known torque")};
  return f;
}

std::vector<Finding> list_findings(const TossProblem& problem, const TossOutcome& outcome, const Fit& fit) {
  std::vector<Finding> list;
  const Hypothesis& chosen = outcome.chosen.hypothesis;
  for (size_t e = 0; e < chosen.size(); ++e) {
    if (!get_effect(chosen[e].id).reported) continue;  // poses do not show what slows a body in flight
    const std::string rest =
        outcome.explained
            ? "With it what is left is noise."
            : "It holds alike in both halves of the tosses and in those it was not fitted to, but something else "
              "is missing as well.";
    list.push_back(
        make_toss_finding(problem, chosen[e], find_widths(outcome.chosen, e), outcome.explained ? 0.98 : 0.9, rest));
    list.back().share = list.back().weight = outcome.shares.at(chosen[e].id);  // each was added by one trial
  }
  const double each =
      calc_explained(fit) / static_cast<double>(list.size() + outcome.doubted.size());  // nothing tells theirs
  for (const TossTrial& trial : outcome.doubted) {
    list.push_back(make_doubted(problem, trial));
    list.back().share = list.back().weight = each;
  }
  return list;
}

std::vector<Unexplained> list_unexplained(const TossProblem& problem, const TossOutcome& outcome, const Left& after) {
  std::vector<Unexplained> list;
  const Hypothesis& found = outcome.chosen.hypothesis;
  if (std::any_of(found.begin(), found.end(), [](const auto& e) { return !get_effect(e.id).reported; })) {
    list.push_back(
        {{{"link", problem.nominal.body.links[0].name}},
         {"velocity"},
         "The body loses speed in flight in proportion to it; what does that (air, a thread) the poses do not say."});
  }
  if (!outcome.mismatch || outcome.explained) return list;
  double sum[3] = {0, 0, 0}, count[3] = {0, 0, 0};
  for (size_t i = 0; i < problem.windows.size(); ++i) {
    const auto g = static_cast<size_t>(after.worst[i]);
    sum[g] += outcome.chosen.misfit[i];
    count[g] += 1.0;
  }
  std::string text = "What is left, in units of the noise:";
  size_t worst = 0;
  for (size_t g = 0; g < 3; ++g) {
    const double score = count[g] > 0.0 ? std::sqrt(sum[g] / count[g]) : 0.0;
    if (count[g] > 0.0)
      text += std::string(g && text.back() != ':' ? "," : "") + " " + number(score, 3) + " in windows with " +
              get_regime_name(static_cast<Regime>(g));
    if (count[g] > 0.0 && score > (count[worst] > 0.0 ? std::sqrt(sum[worst] / count[worst]) : 0.0)) worst = g;
  }
  const Json where = worst == 0 ? Json{{"link", problem.nominal.body.links[0].name}} : Json{{"ground", "ground"}};
  text += worst == static_cast<size_t>(Regime::kImpact)
              ? ". Impacts of rigid bodies with one restitution and one friction do not describe it."
              : ".";
  list.push_back({where, {worst == 2 ? "time" : "velocity"}, text});
  return list;
}

std::vector<NotIdentifiable> list_not_identifiable(const TossProblem& problem) {
  std::vector<NotIdentifiable> list;
  list.push_back({"mass_error", nullptr,
                  "Gravity and the forces of a rigid ground act in proportion to mass: a body that is heavier by a "
                  "factor in mass and "
                  "inertia moves alike.",
                  "a push of known force, a spring, or a toss onto a force plate"});
  if (!problem.has_linear && !problem.has_angular) {
    list.push_back({"sensor_delay", nullptr,
                    "Without a second, independent sensor a delay of all poses only shifts time.",
                    "any toss with an inertial sensor on the body"});
  }
  return list;
}

std::vector<SignalFit> list_fits(const TossProblem& problem, const Left& before, const Left& after) {
  std::vector<SignalFit> out;
  for (size_t s = 0; s < 6; ++s) {
    double mean = 0.0, square = 0.0, count = 0.0;
    for (const Toss& t : problem.tosses) {
      for (size_t k = 0; k < t.p.size(); ++k) {
        const double v = s < 3 ? t.p[k][static_cast<long>(s)] : calc_turn(t.R[0], t.R[k])[static_cast<long>(s) - 3];
        mean += v;
        square += v * v;
        count += 1.0;
      }
    }
    const double spread = std::sqrt(std::max(1e-18, square / count - mean * mean / (count * count)));
    const double noise = s < 3 ? problem.sigma_p : problem.sigma_R;
    out.push_back({kSignals[s], "", noise * calc_score(problem, before, -1, -1, static_cast<int>(s)),
                   noise * calc_score(problem, after, -1, -1, static_cast<int>(s)), spread});
  }
  return out;
}

Json make_trace(const Toss& t, const std::vector<double>& before, const std::vector<double>& after, size_t s,
                double noise) {
  Json time = Json::array(), recorded = Json::array(), jb = Json::array(), ja = Json::array();
  for (size_t k = 0; k < t.p.size(); ++k) {
    const double value = s < 3 ? t.p[k][static_cast<long>(s)] : calc_turn(t.R[0], t.R[k])[static_cast<long>(s) - 3];
    if (!std::isfinite(before[6 * k + s]) || !std::isfinite(after[6 * k + s])) continue;
    time.push_back(t.time[k]);
    recorded.push_back(value);
    jb.push_back(value - noise * before[6 * k + s]);
    ja.push_back(value - noise * after[6 * k + s]);
  }
  return {{"signal", s}, {"time", time}, {"recorded", recorded}, {"before", jb}, {"after", ja}};
}

}  // namespace

Json make_toss_report(const TossProblem& problem, const TossOutcome& outcome) {
  const Left before = calc_left(problem, outcome.nominal), after = calc_left(problem, outcome.chosen);
  Evidence evidence;
  evidence.fit = {outcome.nominal.train, outcome.chosen.train, outcome.nominal.validate, outcome.chosen.validate,
                  list_fits(problem, before, after)};
  evidence.findings = list_findings(problem, outcome, evidence.fit);
  evidence.verdict = find_verdict(outcome.mismatch, outcome.explained, outcome.partly && !evidence.findings.empty());
  evidence.mismatch = list_mismatches(problem, outcome, before);
  evidence.unexplained = list_unexplained(problem, outcome, after);
  evidence.not_identifiable = list_not_identifiable(problem);
  evidence.method =
      "simulated flight and rigid contact over windows one after the other; the start state of each window is "
      "estimated from the window, before and after alike, and taken off the degrees of freedom";
  evidence.horizon = problem.horizon;
  evidence.warnings = problem.experiment->warnings;
  evidence.warnings.insert(evidence.warnings.end(), problem.notes.begin(), problem.notes.end());
  Json report = make_graded_report(has_held_out(problem.experiment->recordings), evidence);
  report["prediction"].update({{"without_the_worst_twentieth",
                                {{"before", std::max(outcome.nominal.typical_train, outcome.nominal.typical_validate)},
                                 {"after", std::max(outcome.chosen.typical_train, outcome.chosen.typical_validate)}}},
                               {"windows", problem.windows.size()},
                               {"noise",
                                {{"position", problem.sigma_p},
                                 {"turn", problem.sigma_R},
                                 {"slow_height", problem.slow_p},
                                 {"slow_tilt", problem.slow_R}}}});
  return report;
}

Json make_toss_series(const TossProblem& problem, const TossOutcome& outcome) {
  const Left before = calc_left(problem, outcome.nominal), after = calc_left(problem, outcome.chosen);
  Json series{{"schema", 1}, {"experiment", problem.experiment->path}, {"robot", problem.nominal.body.name}};
  for (size_t s = 0; s < 6; ++s) {
    series["signals"].push_back({{"name", kSignals[s]},
                                 {"unit", s < 3 ? "m" : "rad"},
                                 {"noise", s < 3 ? problem.sigma_p : problem.sigma_R},
                                 {"noise_source", problem.stated ? "stated" : "estimated"}});
  }
  series["recordings"] = Json::array();
  for (size_t t = 0; t < problem.tosses.size() && series["recordings"].size() < 8; ++t) {
    const Toss& toss = problem.tosses[t];
    if (outcome.nominal.cost[t] <= 0.0) continue;
    Json entry{{"file", toss.file},
               {"role", toss.train ? "train" : "validate"},
               {"start", toss.time.front()},
               {"end", toss.time.back()}};
    for (size_t i = 0; i < problem.windows.size(); ++i) {
      const Window& w = problem.windows[i];
      if (w.toss != t || before.worst[i] != Regime::kImpact) continue;
      entry["marks"].push_back(
          {{"kind", "impact"}, {"from", toss.time[w.first]}, {"to", toss.time[w.first + w.count - 1]}});
    }
    for (size_t s : {size_t{0}, size_t{2}, size_t{3}, size_t{4}}) {
      entry["traces"].push_back(
          make_trace(toss, before.by_toss[t], after.by_toss[t], s, s < 3 ? problem.sigma_p : problem.sigma_R));
    }
    series["recordings"].push_back(entry);
  }
  series["rivals"] = Json::array();
  for (const TossTrial& trial : outcome.trials) {
    series["rivals"].push_back(
        {{"effect", get_effect(trial.added).name},
         {"where", make_where(problem, trial.added)},
         {"probability", trial.accepted ? 0.9 : 0.0},
         {"validate_score", trial.fit.validate > 0.0 ? trial.fit.validate : trial.fit.train},
         {"complexity", trial.fit.hypothesis.size()},
         {"chosen", trial.accepted},
         {"why", trial.accepted ? "takes away most, in every part of the recordings" : trial.why}});
  }
  series["notes"] = problem.experiment->warnings;
  for (const std::string& note : problem.notes) series["notes"].push_back(note);
  return series;
}

}  // namespace hrp::diagnosis::toss
