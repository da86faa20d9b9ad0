// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/rounds.h"
#include "diagnosis/search/fit.h"
#include "diagnosis/standing/hints.h"
#include "diagnosis/standing/searcher.h"

namespace hrp::diagnosis::standing {

// Ranks a candidate by the linear prediction of its residual.
StandTrial StandSearcher::screen(const StandFit& so_far, const Effect& candidate, const Screen& all) const {
  const SharedColumns& shared = all.columns;
  const Evaluation& base = all.base;
  StandTrial trial;
  Hypothesis h = so_far.hypothesis;
  h.push_back(candidate);
  const StandRow& row = get_row(candidate);
  if (row.refined > 0) {  // not linear enough
    h = refine(coarse_, judge_.select(so_far), h, row.refined);
    trial.fit = judge_.judge(h, evaluate(coarse_, h));
    if (!are_sensible(p_, h)) trial.fit.score = 1e300;
    return trial;
  }
  if (starts_away(candidate)) {
    trial.fit = judge_.judge(h, thin_out(evaluate(p_, h), channels()));
    trial.fit.score += all.offset;
    return trial;
  }
  const std::vector<Derivative> added = differentiate(coarse_, h, so_far.hypothesis.size(), base, all_);
  const Eigen::VectorXd delta = find_step(so_far, h, added, all);
  if (delta.allFinite()) add_step(delta, 0, &h);
  Evaluation predicted(base.size());
  const size_t n = shared.columns.size();
  for (size_t r = 0; r < base.size(); ++r) {
    predicted[r].residuals = base[r].residuals;
    for (size_t c = 0; c < n + added.size() && delta.allFinite(); ++c) {
      const std::vector<double>& column = c < n ? shared.columns[c][r] : added[c - n][r];
      const double d = delta(static_cast<long>(c));
      for (size_t k = 0; k < column.size(); ++k) predicted[r].residuals[k] += column[k] * d;
    }
  }
  if (!are_sensible(p_, h)) {
    trial.fit.hypothesis = h;
    trial.fit.score = 1e300;
    return trial;
  }
  trial.fit = judge_.judge(h, predicted, row.noisy ? find_noise_of(h, all) : std::vector<double>{});
  return trial;
}

// Step to the parameters of a hypothesis whose last effect has the columns `added`. If the effect multiplies a noisy
// signal, the step uses even and odd samples as instruments, because least squares would be biased towards zero.
Eigen::VectorXd StandSearcher::find_step(const StandFit& so_far, const Hypothesis& h,
                                         const std::vector<Derivative>& added, const Screen& all) const {
  const FitSelection selection = judge_.select(so_far);
  const ColumnSide plain{all.columns, added};
  if (!get_row(h.back()).noisy) return solve_with(coarse_, selection, h, plain, plain);
  const size_t first = h.size() - 1;
  const auto even = differentiate(coarse_even_, h, first, all.even, selection.recordings);
  const auto odd = differentiate(coarse_odd_, h, first, all.odd, selection.recordings);
  return solve_with(coarse_, selection, h, {all.even_columns, even}, {all.odd_columns, odd});
}

// Squared noise by channel that the last effect of a hypothesis adds.
std::vector<double> StandSearcher::find_noise_of(const Hypothesis& h, const Screen& all) const {
  const Effect& last = h.back();
  const auto with = [&](const StandProblem& half, const Evaluation& without) {
    Evaluation out(without.size());
    for (size_t r = 0; r < out.size(); ++r) {
      out[r].residuals = get_row(last).at_drive ? calc_drive_channels(half, h, r, without[r], last.place.index)
                                                : calc_channels(half, h, r);
    }
    return out;
  };
  std::vector<double> out = judge_.find_noise(with(coarse_even_, all.even), with(coarse_odd_, all.odd));
  for (size_t c = 0; c < out.size(); ++c) out[c] = std::max(0.0, out[c] - all.noise[c]);
  return out;
}

// Candidates of the next round. From kLargestSet effects on, effects of joints must be of a kind that was found at
// another joint.
std::vector<Effect> StandSearcher::list_next(const StandFit& so_far, const Evaluation& base) const {
  StandHints hints = hints_;
  hints.ripples = find_ripples(coarse_, base);
  for (size_t j = 0; j < hints.play.size(); ++j) hints.play[j] = find_play(coarse_, so_far.hypothesis, j);
  std::vector<Effect> list = list_candidates(p_, so_far.hypothesis, hints);
  if (so_far.hypothesis.size() < kLargestSet) return list;
  const auto is_new = [&](const Effect& candidate) {
    const Hypothesis& h = so_far.hypothesis;
    return !is_joint(candidate) ||
           std::none_of(h.begin(), h.end(), [&](const Effect& e) { return e.id == candidate.id; });
  };
  list.erase(std::remove_if(list.begin(), list.end(), is_new), list.end());
  return list;
}

StandSearcher::Screen StandSearcher::prepare_screen(const StandFit& so_far) const {
  const Hypothesis& h = so_far.hypothesis;
  const FitSelection selection = judge_.select(so_far);
  Screen out{evaluate(coarse_, h), evaluate(coarse_even_, h), evaluate(coarse_odd_, h), {}, 0, 0, {}, {}, {}};
  out.score = judge_.judge(h, out.base).score;
  out.offset = out.score - judge_.judge(h, thin_out(evaluate(p_, h), channels())).score;
  out.noise = judge_.find_noise(out.even, out.odd);
  const auto share = [&](const StandProblem& problem, const Evaluation& base, const std::vector<size_t>& recordings) {
    return share_columns(selection, differentiate(problem, h, 0, base, recordings), base);
  };
  out.columns = share(coarse_, out.base, all_);
  out.even_columns = share(coarse_even_, out.even, selection.recordings);
  out.odd_columns = share(coarse_odd_, out.odd, selection.recordings);
  return out;
}

// What the last effect's shift of a sensor's readings gains the other way, too. Readings between two samples are less
// noisy than either, so any shift of half a sample seems to gain; that is no delay.
double StandSearcher::find_gain_either_way(const StandFit& so_far, Hypothesis h) const {
  const EffectInfo& last = get_effect(h.back().id);
  if (last.place != PlaceKind::kSensor || last.family != EffectFamily::kTiming) return 0;
  for (double& p : h.back().p) p = -p;
  return std::max(0.0, so_far.score - judge(h).score);
}

// Fits a hypothesis to the training recordings and judges it. Its score is 1e300 if it is not physical, or if ground
// compliance could explain it.
StandFit StandSearcher::fit_trial(const StandFit& so_far, const Hypothesis& start, int iterations) const {
  Hypothesis h = refine(p_, judge_.select(so_far), start, iterations);
  Eigen::MatrixXd covariance;
  if (get_row(h.back()).noisy) polish(problems_, judge_.select(so_far), iterations, &h, &covariance);
  StandFit fit = judge(h);
  fit.score += find_gain_either_way(so_far, h);
  const Effect& last = h.back();
  const bool doubtful = get_row(last).bends_leg && last.p[0] <= find_bound(p_, last, 0);
  if (!are_sensible(p_, h) || (doubtful && !exceeds_ground(fit))) fit.score = 1e300;
  return fit;
}

// Adds each candidate to the effects found so far and fits the best few completely. Returns them best first, with
// probabilities.
std::vector<StandTrial> StandSearcher::try_candidates(const StandFit& so_far) const {
  const Screen shared = prepare_screen(so_far);
  const std::vector<Effect> candidates = list_next(so_far, shared.base);
  std::vector<StandTrial> trials(candidates.size());
  parallel_for(jobs_, static_cast<int>(candidates.size()), [&](int i) {
    trials[static_cast<size_t>(i)] = screen(so_far, candidates[static_cast<size_t>(i)], shared);
  });
  const auto better = [](const StandTrial& a, const StandTrial& b) { return a.fit.score < b.fit.score; };
  std::stable_sort(trials.begin(), trials.end(), better);
  std::vector<StandTrial> best;  // only the best start of each effect and place
  for (const StandTrial& t : trials) {
    if (best.size() >= kShortList || t.fit.score >= shared.score) break;
    const bool known = std::any_of(best.begin(), best.end(), [&](const StandTrial& b) {
      return is_same(b.fit.hypothesis.back(), t.fit.hypothesis.back());
    });
    if (!known) best.push_back(t);
  }
  for (const int iterations : {2, 3}) {  // candidates far behind after the first two iterations get no more
    const double first = best.empty() ? 0 : best[0].fit.score;
    const double within = first + 0.5 * std::abs(so_far.score - first) + kGain;
    parallel_for(jobs_, static_cast<int>(best.size()), [&](int i) {
      StandTrial& trial = best[static_cast<size_t>(i)];
      if (iterations > 2 && trial.fit.score > within) return;
      trial.fit = fit_trial(so_far, trial.fit.hypothesis, iterations);
    });
    std::stable_sort(best.begin(), best.end(), better);
  }
  double total = 0;
  for (StandTrial& t : best) {
    total += t.probability = std::exp(std::max(-200.0, (best[0].fit.score - t.fit.score) / kCorrelated));
  }
  for (StandTrial& t : best) t.probability /= total;
  return best;
}

}  // namespace hrp::diagnosis::standing
