// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held_feet/search.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis::held_feet {
namespace {

constexpr double kFloor = 1.2;  // score below which what is left counts as noise
// Of what is left: a smaller share may stand in for something that is missing as well.
constexpr double kLeastShare = 0.03;
constexpr double kSame = 0.3;  // relative difference of parts of the recordings that still counts as one value
constexpr int kMostEffects = 12;

// Held-out blocks: recordings of role validate; where there are none, every third stretch of two seconds (of half a
// second in recordings shorter than six).
std::vector<char> choose_blocks(const RowProblem& problem, std::string* held) {
  std::vector<char> use;
  const bool roles =
      std::any_of(problem.recordings.begin(), problem.recordings.end(), [](const RowRecording& r) { return !r.train; });
  const std::vector<RowBlock> blocks = list_blocks(problem);
  size_t number = 0, recording = 0;
  for (const RowBlock& b : blocks) {
    if (b.recording != recording) number = 0, recording = b.recording;
    const RowRecording& r = problem.recordings[b.recording];
    const size_t stretch = number++ / (r.time.back() - r.time.front() < 6.0 ? 1 : 4);
    use.push_back(roles ? problem.recordings[b.recording].train : stretch % 3 != 2);
  }
  *held = roles ? "recordings that were not fitted" : "every third stretch of the recordings, which was not fitted";
  return use;
}

class Search {
 public:
  Search(const RowProblem& problem, const RowProgress& progress) : problem_(problem), progress_(progress) {
    use_ = choose_blocks(problem, &out_.held);
  }

  RowOutcome run() {
    out_.nominal = fit_rows(problem_, {}, use_);
    out_.chosen = out_.nominal;
    out_.baseline = fit_rows(problem_, make_baseline(), use_);
    for (int round = 0; round < kMostEffects && add_best(); ++round) {
      if (!progress_) continue;
      const RowEffect& e = out_.chosen.hypothesis.back();
      progress_("with " + get_effect(e.id).name + ": " + std::to_string(out_.chosen.held) +
                " times the noise");
    }
    out_.mismatch = std::max(out_.nominal.held, out_.nominal.train) > kFloor || !out_.chosen.hypothesis.empty();
    out_.explained = !out_.chosen.hypothesis.empty() && std::max(out_.chosen.held, out_.chosen.train) < kFloor;
    out_.partly = !out_.chosen.hypothesis.empty() && !out_.explained;
    return std::move(out_);
  }

 private:
  // Viscous and Coulomb friction and a rotor in every driven joint: what everybody would fit.
  RowHypothesis make_baseline() const {
    RowHypothesis out;
    for (const RowEffect& e : list_row_effects(problem_)) {
      if (e.id == EffectId::kViscous || e.id == EffectId::kCoulomb || e.id == EffectId::kRotorInertia) out.push_back(e);
    }
    return out;
  }

  std::vector<RowEffect> list_candidates() const {
    std::vector<RowEffect> out;
    for (const RowEffect& e : list_row_effects(problem_)) {
      if (!contains(out_.chosen.hypothesis, e.id, e.place)) out.push_back(e);
    }
    return out;
  }

  double sum(const RowFit& fit, bool fitted) const {
    double chi2 = 0.0;
    for (size_t k = 0; k < use_.size(); ++k) chi2 += (use_[k] != 0) == fitted ? fit.chi2[k] : 0.0;
    return chi2;
  }

  // The added parameters, from each of two interleaved halves of the fitted blocks and from each recording alone.
  bool is_consistent(const RowTrial& trial) const {
    const std::vector<RowBlock> blocks = list_blocks(problem_);
    std::vector<std::vector<char>> parts(2 + problem_.recordings.size(), std::vector<char>(use_.size(), 0));
    for (size_t k = 0; k < use_.size(); ++k) {
      if (!use_[k]) continue;
      parts[(k / 4) % 2][k] = 1, parts[2 + blocks[k].recording][k] = 1;
    }
    const size_t last = trial.fit.hypothesis.size() - 1;
    const RowEffect neutral = make_absent(trial.added.id, trial.added.place);
    for (const std::vector<char>& part : parts) {
      if (std::count(part.begin(), part.end(), 1) < 2) continue;
      // Only the new effect is free: a part need not tell all of them.
      const RowFit fit = fit_rows(problem_, trial.fit.hypothesis, part);
      for (size_t i = 0; i < neutral.p.size(); ++i) {
        const double whole = trial.fit.hypothesis[last].p[i], here = fit.hypothesis[last].p[i];
        const double allowed = std::max(kSame * std::abs(whole - neutral.p[i]),
                                        3.0 * std::hypot(fit.std[last][i], trial.fit.std[last][i]));
        if (!(std::abs(here - whole) <= allowed)) return false;
      }
    }
    return true;
  }

  // No recording may get worse for what is missing in another one.
  bool helps_everywhere(const RowTrial& trial) const {
    const std::vector<RowBlock> blocks = list_blocks(problem_);
    std::vector<double> before(problem_.recordings.size(), 0.0), after = before;
    for (size_t k = 0; k < blocks.size(); ++k) {
      before[blocks[k].recording] += out_.chosen.chi2[k], after[blocks[k].recording] += trial.fit.chi2[k];
    }
    for (size_t r = 0; r < before.size(); ++r) {
      if (after[r] > 1.02 * before[r]) return false;  // 2 %: chance in a recording that says nothing about it
    }
    return true;
  }

  bool is_significant(const RowTrial& trial) const {
    const size_t last = trial.fit.hypothesis.size() - 1;
    const RowEffect neutral = make_absent(trial.added.id, trial.added.place);
    for (size_t i = 0; i < neutral.p.size(); ++i) {
      const double size = std::abs(trial.fit.hypothesis[last].p[i] - neutral.p[i]);
      if (size > kSignificantInJoint * trial.fit.std[last][i]) return true;
    }
    return false;
  }

  void examine(RowTrial* trial) const {
    const double left = sum(out_.chosen, true);
    const double least = 20.0 + (trial->fit.held < kFloor ? 0.0 : kLeastShare * left);
    if (trial->gain < least)
      trial->why = "it takes away too little of what is missing";
    else if (sum(trial->fit, false) > 0.995 * sum(out_.chosen, false))
      trial->why = "what it was not fitted to gets no better";
    else if (!helps_everywhere(*trial))
      trial->why = "one of the recordings gets worse";
    else if (!is_significant(*trial))
      trial->why = "its parameters cannot be told from nothing";
    else if (!is_consistent(*trial))
      trial->why = "parts of the recordings ask for different values";
    else
      trial->accepted = true;
  }

  bool add_best() {
    std::vector<RowTrial> round;
    for (const RowEffect& candidate : list_candidates()) {
      RowHypothesis hypothesis = out_.chosen.hypothesis;
      hypothesis.push_back(candidate);
      RowTrial trial{candidate, fit_rows(problem_, hypothesis, use_), 0.0, false, ""};
      trial.gain = sum(out_.chosen, true) - sum(trial.fit, true);
      round.push_back(std::move(trial));
    }
    // By gain for each parameter, so that three numbers do not win over one by number alone.
    std::stable_sort(round.begin(), round.end(), [](const RowTrial& a, const RowTrial& b) {
      return a.gain - 20.0 * static_cast<double>(a.added.p.size()) >
             b.gain - 20.0 * static_cast<double>(b.added.p.size());
    });
    for (size_t i = 0; i < std::min<size_t>(round.size(), 6); ++i) {
      examine(&round[i]);
      const bool accepted = round[i].accepted;
      if (accepted) out_.chosen = round[i].fit;
      out_.trials.push_back(std::move(round[i]));
      if (accepted) return out_.chosen.held > 0.9;
    }
    return false;
  }

  const RowProblem& problem_;
  const RowProgress& progress_;
  std::vector<char> use_;
  RowOutcome out_;
};

}  // namespace

RowOutcome search_rows(const RowProblem& problem, const RowProgress& progress) {
  return Search(problem, progress).run();
}

bool diagnose_held_feet(const Experiment& experiment, const RowProgress& progress, nlohmann::ordered_json* report,
                       nlohmann::ordered_json* series, std::string* why) {
  RowProblem problem;
  if (!make_row_problem(experiment, &problem, why)) return false;
  const RowOutcome outcome = search_rows(problem, progress);
  *report = make_row_report(problem, outcome);
  *series = make_row_series(problem, outcome);
  return true;
}

}  // namespace hrp::diagnosis::held_feet
