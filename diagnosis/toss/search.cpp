// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/toss/search.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis::toss {
namespace {

constexpr size_t kSearchWindows = 110;  // takes about a minute on two cores
constexpr int kMostEffects = 5;
constexpr int kTrialRounds = 2, kRounds = 4;  // iterations of a fit: two for a first ranking, four for values
constexpr size_t kClosest = 3;       // candidates with the largest gains, which are ranked again after four iterations
constexpr double kLeastGain = 10.0;  // least cost reduction, besides 2 per parameter: odds of about e^10 by noise

bool has_validation(const TossProblem& problem) {
  return std::any_of(problem.windows.begin(), problem.windows.end(),
                     [&](const Window& w) { return !problem.tosses[w.toss].train; });
}

double judge(const TossProblem& problem, const TossFit& fit) {
  return has_validation(problem) ? fit.validate : fit.train;
}

void decide(const TossProblem& problem, TossOutcome* outcome) {
  const double before = judge(problem, outcome->nominal), after = judge(problem, outcome->chosen);
  const bool found = !outcome->chosen.hypothesis.empty();
  outcome->mismatch = found || before > kNoiseLeft;
  outcome->explained = found && after < kNoiseLeft;
  outcome->partly = found && !outcome->explained;
}

// Mean reduction of cost per training toss over its standard error.
double calc_sureness(const TossProblem& problem, const TossFit& before, const TossFit& after) {
  double n = 0.0, sum = 0.0, square = 0.0;
  for (size_t t = 0; t < problem.tosses.size(); ++t) {
    if (!problem.tosses[t].train || before.cost[t] <= 0.0) continue;
    const double d = before.cost[t] - after.cost[t];
    n += 1.0;
    sum += d;
    square += d * d;
  }
  if (n < 3.0) return sum > 0.0 ? kSignificantInTosses : 0.0;  // too few tosses; the other tests decide
  const double variance = std::max(1e-12, (square - sum * sum / n) / (n - 1.0));
  return sum / std::sqrt(n * variance);
}

class Search {
 public:
  Search(const TossProblem& problem, int jobs, const TossProgress& progress)
      : problem_(problem), jobs_(jobs), progress_(progress) {}

  TossOutcome run() {
    out_.nominal = fit_starts(problem_, {}, nullptr, jobs_);
    out_.chosen = out_.nominal;
    say("nominal: " + std::to_string(judge(problem_, out_.nominal)) + " times the noise");
    for (int round = 0; round < kMostEffects && add_best(); ++round) {
    }
    if (out_.chosen.hypothesis.size() > 1) refine();
    doubt();
    decide(problem_, &out_);
    return std::move(out_);
  }

 private:
  void say(const std::string& text) const {
    if (progress_) progress_(text);
  }

  TossFitOptions options(int rounds) const {
    TossFitOptions o;
    o.jobs = jobs_;
    o.rounds = rounds;
    return o;
  }

  TossTrial try_effect(EffectId id) const {
    TossTrial best;
    best.added = id;
    const EffectId inside = get_toss_row(id).inside;
    for (const Effect& effect : list_starts(problem_, out_.chosen.hypothesis, id)) {
      Hypothesis hypothesis = out_.chosen.hypothesis;
      hypothesis.erase(
          std::remove_if(hypothesis.begin(), hypothesis.end(), [&](const Effect& e) { return e.id == inside; }),
          hypothesis.end());
      hypothesis.push_back(effect);
      const TossFit fit =
          fit_tosses(problem_, fit_starts(problem_, hypothesis, &out_.chosen, jobs_), options(kTrialRounds));
      const double gain = out_.chosen.train_cost - fit.train_cost;
      if (best.fit.hypothesis.empty() || gain > best.gain) {
        best.fit = fit;
        best.gain = gain;
      }
    }
    best.sureness = calc_sureness(problem_, out_.chosen, best.fit);
    return best;
  }

  // Fits the parameters of the added effect to each half of the training tosses and compares them.
  bool is_consistent(const TossTrial& trial) const {
    TossFit half[2];
    for (size_t h = 0; h < 2; ++h) {
      std::vector<char> use;
      for (size_t t = 0; t < problem_.tosses.size(); ++t)
        use.push_back(problem_.tosses[t].train && chosen_half(t) == h);
      if (std::count(use.begin(), use.end(), 1) == 0) return true;
      TossFitOptions o = options(3);
      o.use = &use;
      half[h] = fit_tosses(problem_, trial.fit, o);
    }
    const size_t last = trial.fit.hypothesis.size() - 1;
    const Effect neutral = make_neutral(problem_, trial.added);
    for (size_t i = 0; i < neutral.p.size(); ++i) {
      const double a = half[0].hypothesis[last].p[i], b = half[1].hypothesis[last].p[i];
      const double size = std::abs(trial.fit.hypothesis[last].p[i] - neutral.p[i]);
      const double error = 3.0 * std::hypot(half[0].std[last][i], half[1].std[last][i]);
      if (std::abs(a - b) > std::max(kPart * size, error)) return false;
    }
    return true;
  }

  // Half (0 or 1) of a toss: alternates over the training tosses with windows.
  size_t chosen_half(size_t toss) const {
    size_t number = 0;
    for (size_t t = 0; t < toss; ++t) number += problem_.tosses[t].train && out_.nominal.cost[t] > 0.0 ? 1 : 0;
    return number % 2;
  }

  // True if the spread between tosses is below half of each significant value. Materials and clocks do not change
  // between tosses.
  bool is_steady(const TossTrial& trial) const {
    const Effect neutral = make_neutral(problem_, trial.added);
    for (size_t i = 0; i < neutral.p.size(); ++i) {
      const double size = std::abs(trial.fit.hypothesis.back().p[i] - neutral.p[i]);
      const bool tells = size > kSignificantInTosses * trial.fit.std.back()[i];
      // What varies so much between tosses is no property of the body.
      if (tells && trial.fit.spread.back()[i] > kHalf * size) return false;
    }
    return true;
  }

  bool is_significant(const TossTrial& trial) const {
    const size_t last = trial.fit.hypothesis.size() - 1;
    const Effect neutral = make_neutral(problem_, trial.added);
    for (size_t i = 0; i < neutral.p.size(); ++i) {
      const double std = trial.fit.std[last][i];
      if (std > 0.0 && std::abs(trial.fit.hypothesis[last].p[i] - neutral.p[i]) > kSignificantInTosses * std)
        return true;
    }
    return false;
  }

  // An effect in flight must not increase the cost of windows without contact, except by chance. True if there are
  // none.
  bool shows_in_flight(const TossTrial& trial) const {
    if (!get_toss_row(trial.added).flies) return true;
    double gain = 0.0, count = 0.0;
    for (size_t i = 0; i < problem_.windows.size(); ++i) {
      const Window& w = problem_.windows[i];
      std::vector<Regime> regimes;
      calc_window_residuals(problem_, out_.chosen.hypothesis, w, out_.chosen.starts[i], &regimes);
      if (std::any_of(regimes.begin(), regimes.end(), [](Regime g) { return g != Regime::kFlight; })) continue;
      const double n = 6.0 * static_cast<double>(w.count);
      gain += calc_cost(out_.chosen.misfit[i], n) - calc_cost(trial.fit.misfit[i], n);
      count += 1.0;
    }
    return count == 0.0 || gain > -kLeastGain;
  }

  // The value from poses without a law of contact, if it differs significantly from the model's.
  std::optional<Measured> find_measured(EffectId id) const {
    const TossRow& row = get_toss_row(id);
    const std::optional<Measured> measured = row.get_measured ? row.get_measured(problem_) : std::nullopt;
    const bool differs =
        measured && std::abs(measured->value - make_neutral(problem_, id).p[0]) > kSignificantInTosses * measured->std;
    return differs ? measured : std::nullopt;
  }

  // True if the fit agrees with a significant measured value.
  bool is_measured(const TossTrial& trial) const {
    const auto measured = find_measured(trial.added);
    if (!measured) return false;
    const double value = trial.fit.hypothesis.back().p[0],
                 size = std::abs(value - make_neutral(problem_, trial.added).p[0]);
    const double error = std::hypot(measured->std, std::hypot(trial.fit.std.back()[0], trial.fit.spread.back()[0]));
    return std::abs(value - measured->value) < std::max(kPart * size, kSignificantInTosses * error);
  }

  void examine(TossTrial* trial) const {
    const double before = out_.chosen.train_cost, left = judge(problem_, trial->fit);
    const size_t count = make_neutral(problem_, trial->added).p.size();
    // While something else is missing, a weaker effect may stand in for it.
    const double least = kLeastGain + 2.0 * static_cast<double>(count) + (left < kNoiseLeft ? 0.0 : kBlur * before);
    if (trial->gain < least) {
      trial->why = "it takes away too little of what is missing";
    } else if (has_validation(problem_) && trial->fit.validate_cost >= out_.chosen.validate_cost) {
      trial->why = "the recordings it was not fitted to get no better";
    } else if (trial->sureness < kSignificantInTosses) {
      trial->why = "only few tosses get better";
    } else if (!is_significant(*trial)) {
      trial->why = "its parameters cannot be told from nothing";
    } else if (!shows_in_flight(*trial)) {
      trial->why = "flight gets worse with it";
    } else if (!is_steady(*trial)) {
      trial->why = "its value differs from toss to toss";
    } else if (!is_consistent(*trial)) {
      trial->why = "halves of the tosses ask for different values";
    } else if (get_toss_row(trial->added).refused && !is_measured(*trial)) {
      trial->doubted = true;
      trial->why = get_toss_row(trial->added).refused;
    } else {
      trial->accepted = true;
    }
  }

  // Tries the effects that need an independent measurement, beside all others. Those that pass every other test are
  // reported as ambiguous.
  void doubt() {
    for (const TossRow& row : list_toss_rows()) {
      if (!row.refused || out_.chosen.hypothesis.empty() || has_effect(out_.chosen.hypothesis, row.id)) continue;
      TossTrial trial = try_effect(row.id);
      complete(&trial, kRounds);
      examine(&trial);
      if (trial.doubted)
        say(std::string("perhaps ") + get_effect(row.id).name + ": " + std::to_string(judge(problem_, trial.fit)));
      if (trial.doubted) out_.doubted.push_back(std::move(trial));
    }
  }

  // Share of the nominal model's held-out cost that an effect removes, in the order of adding.
  double calc_share(const TossFit& with) const {
    const auto get_cost = [&](const TossFit& fit) {
      return has_validation(problem_) ? fit.validate_cost : fit.train_cost;
    };
    return std::max(0.0, (get_cost(out_.chosen) - get_cost(with)) / get_cost(out_.nominal));
  }

  // Continues the fit of a candidate for `rounds` iterations.
  void complete(TossTrial* trial, int rounds) const {
    trial->fit = fit_tosses(problem_, trial->fit, options(rounds));
    trial->gain = out_.chosen.train_cost - trial->fit.train_cost;
    trial->sureness = calc_sureness(problem_, out_.chosen, trial->fit);
  }

  std::vector<EffectId> list_candidates() const {
    std::vector<EffectId> candidates, wanted;
    int others = 0;
    const Hypothesis& found = out_.chosen.hypothesis;
    const auto is_whole = [](const TossRow& row) { return row.inside == kNoEffect; };
    for (const TossRow& row : list_toss_rows()) {
      if (is_whole(row) && !has_effect(found, row.id)) candidates.push_back(row.id);
    }
    const std::vector<double> gains = calc_gains(problem_, out_.chosen, candidates, jobs_);
    std::vector<size_t> order(candidates.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return gains[a] > gains[b]; });
    for (size_t i : order) {
      const bool blind = get_toss_row(candidates[i]).jumps || find_measured(candidates[i]);
      if (blind || (others < 2 && gains[i] > kLeastGain)) wanted.push_back(candidates[i]);
      others += blind ? 0 : 1;
    }
    for (const TossRow& row : list_toss_rows()) {
      if (!is_whole(row) && has_effect(found, row.inside)) wanted.push_back(row.id);
    }
    return wanted;
  }

  static void sort_by_gain(std::vector<TossTrial>* trials) {
    std::stable_sort(trials->begin(), trials->end(),
                     [](const TossTrial& a, const TossTrial& b) { return a.gain > b.gain; });
  }

  bool add_best() {
    if (out_.chosen.typical_train < 0.5) return false;  // the stated noise is too large, so nothing can be found
    std::vector<TossTrial> round;
    for (EffectId id : list_candidates()) {
      round.push_back(try_effect(id));
      say(std::string("with ") + get_effect(id).name + ": " + std::to_string(judge(problem_, round.back().fit)));
    }
    sort_by_gain(&round);
    for (size_t i = 0; i < std::min(kClosest, round.size()); ++i) complete(&round[i], kRounds - kTrialRounds);
    sort_by_gain(&round);
    bool found = false;
    for (TossTrial& trial : round) {
      if (!found) {
        complete(&trial, kRounds);
        examine(&trial);
      } else {
        trial.why = "another effect takes away more";
      }
      found = found || trial.accepted;
    }
    for (TossTrial& trial : round) {
      if (trial.accepted) {
        out_.shares[trial.added] = calc_share(trial.fit);
        out_.chosen = trial.fit;
      }
      out_.trials.push_back(std::move(trial));
    }
    return found && judge(problem_, out_.chosen) > 1.0;
  }

  void refine() { out_.chosen = fit_tosses(problem_, out_.chosen, options(kRounds)); }

  const TossProblem& problem_;
  int jobs_;
  const TossProgress& progress_;
  TossOutcome out_;
};

}  // namespace

TossProblem make_small_problem(const TossProblem& problem, size_t most, bool other) {
  TossProblem small = problem;
  const auto count = problem.windows.size(), stride = (count + most - 1) / most;
  const size_t offset = other ? stride / 2 : 0;
  std::vector<char> use(problem.tosses.size(), 0);
  size_t number[2] = {0, 0};
  for (size_t t = 0; t < use.size(); ++t) {
    use[t] = number[problem.tosses[t].train ? 1 : 0]++ % stride == offset && (!other || offset > 0);
  }
  small.windows.clear();
  for (const Window& w : problem.windows) {
    if (use[w.toss]) small.windows.push_back(w);
  }
  return small;
}

namespace {

// Fits the result to tosses that the search did not use. Half of the difference widens the intervals. Effects whose
// significant values are not confirmed are removed.
void confirm(const TossProblem& problem, const TossProblem& others, int jobs, const TossProgress& progress,
             TossOutcome* outcome) {
  if (others.windows.empty() || outcome->chosen.hypothesis.empty()) return;
  TossFitOptions options;
  options.jobs = jobs;
  options.rounds = kRounds;
  const TossFit& found = outcome->chosen;
  const TossFit again = fit_tosses(others, fit_starts(others, found.hypothesis, nullptr, jobs), options);
  TossFit kept = found;
  kept.hypothesis.clear();
  kept.std.clear();
  kept.spread.clear();
  for (size_t e = 0; e < found.hypothesis.size(); ++e) {
    const Effect neutral = make_neutral(problem, found.hypothesis[e].id);
    std::vector<double> std = found.std[e];
    bool same = true;
    for (size_t i = 0; i < std.size(); ++i) {
      const double apart = std::abs(found.hypothesis[e].p[i] - again.hypothesis[e].p[i]);
      const double size = std::abs(found.hypothesis[e].p[i] - neutral.p[i]);
      const double error = std::hypot(found.std[e][i], again.std[e][i]);
      same = same &&
             !(size > kSignificantInTosses * std[i] && apart > std::max(kPart * size, kSignificantInTosses * error));
      std[i] = std::hypot(std[i], 0.5 * apart);
    }
    const std::string& name = get_effect(found.hypothesis[e].id).name;
    if (progress) progress(std::string("other tosses ") + (same ? "confirm " : "do not confirm ") + name);
    if (!same) continue;
    kept.hypothesis.push_back(found.hypothesis[e]);
    kept.std.push_back(std);
    kept.spread.push_back(found.spread[e]);
  }
  if (kept.hypothesis.size() < found.hypothesis.size()) {
    const std::vector<std::vector<double>> std = kept.std;
    kept = fit_tosses(problem, fit_starts(problem, kept.hypothesis, &found, jobs), options);
    for (size_t e = 0; e < std.size(); ++e) {
      for (size_t i = 0; i < std[e].size(); ++i) kept.std[e][i] = std::max(kept.std[e][i], std[e][i]);
    }
  }
  outcome->chosen = kept;
  decide(problem, outcome);
}

}  // namespace

TossOutcome search_tosses(const TossProblem& problem, int jobs, const TossProgress& progress) {
  return Search(problem, jobs, progress).run();
}

bool diagnose_toss(const Experiment& experiment, int jobs, const TossProgress& progress, nlohmann::ordered_json* report,
                   nlohmann::ordered_json* series, std::string* why) {
  TossProblem whole;
  if (!make_toss_problem(experiment, &whole, why)) return false;
  const TossProblem problem = make_small_problem(whole, kSearchWindows);
  if (progress) {
    progress("tossed body: " + std::to_string(problem.windows.size()) + " of " + std::to_string(whole.windows.size()) +
             " windows");
  }
  TossOutcome outcome = search_tosses(problem, jobs, progress);
  confirm(problem, make_small_problem(whole, kSearchWindows, true), jobs, progress, &outcome);
  *report = make_toss_report(problem, outcome);
  *series = make_toss_series(problem, outcome);
  return true;
}

}  // namespace hrp::diagnosis::toss
