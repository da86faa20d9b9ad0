// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/search.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/standing/free_play.h"
#include "diagnosis/standing/layout.h"
#include "diagnosis/standing/searcher.h"
#include "diagnosis/standing/slip.h"

namespace hrp::diagnosis::standing {

StandOutcome StandSearcher::run() {
  update_noise({});
  out_.nominal = out_.chosen = judge({});
  if (!find_slip_ratio(p_, &hints_.slip_ratio, &slip_spread_)) hints_.slip_ratio = 0;
  hints_.ripples.resize(p_.effort.size());
  hints_.play.resize(p_.effort.size());
  give_ = find_tilting(p_);
  significant_ = find_deviations(kSignificantInRobot);
  extend();
  start_with_runner_up();
  if (out_.mismatch && !out_.explained) start_with_soles();
  if (!list_undone(out_.chosen.hypothesis).empty()) out_.explained = false;
  if (out_.explained) refuse_couplings();
  if (out_.explained) refuse_bundles();
  if (out_.explained) refuse_uneven_friction();
  if (!out_.explained) doubt();
  if (!out_.mismatch) look_below_noise();
  find_indistinguishable();
  weigh_alternatives();
  out_.sigma = judge_.sigma();
  out_.widening = find_deviations(kNinetyFive) / kNinetyFive;
  return std::move(out_);
}

// No equation stands out and no effect was found. If even and odd samples still share a residual, there is a mismatch
// that no listed effect explains.
void StandSearcher::look_below_noise() {
  out_.shared = judge_.find_shared(evaluate(problems_.even, {}), evaluate(problems_.odd, {}));
  out_.mismatch = std::any_of(out_.shared.begin(), out_.shared.end(), [](double s) { return s > 0; });
}

bool StandSearcher::is_full() const { return out_.chosen.hypothesis.size() >= kLargestSet; }

void StandSearcher::extend() {
  while (out_.chosen.hypothesis.size() < kLargestSet && add_effect()) {
  }
  if (out_.chosen.hypothesis.size() > 1) exchange_effects(false);
  while (is_full() && out_.chosen.hypothesis.size() < kMostAlike && add_effect()) {
  }
  enrich_effects();
  const bool found = !out_.chosen.hypothesis.empty(), quiet = is_explained();
  const std::vector<double>& train = out_.nominal.train_rms;
  const double most = *std::max_element(train.begin(), train.end());
  out_.mismatch = found || worst(out_.nominal) > kAboveNoise || most > kSeveralTimes;
  out_.explained = found && quiet;
}

// Starts again from soft soles if something remains unexplained. Soft soles next to a second effect of the feet may
// look unphysical alone (negative stiffness), so they are never added first. Keeps the result only if it explains
// everything.
void StandSearcher::start_with_soles() {
  const auto soft = [](const Effect& e) { return is_foot(e); };
  const Hypothesis& found = out_.chosen.hypothesis;
  if (std::any_of(found.begin(), found.end(), soft)) return;
  for (const Effect& e : list_candidates(p_, {}, hints_)) {
    if (e.id != make_soft_soles(p_).id) continue;
    const StandOutcome before = out_;
    const StandJudge judge_before = judge_;
    out_.chosen = fit_trial(out_.nominal, {e}, 2);
    out_.rounds.assign(1, {});
    extend();
    const bool more = out_.chosen.hypothesis.size() > 1;
    if (!more || !out_.explained || !are_sensible(p_, out_.chosen.hypothesis)) {
      out_ = before;
      judge_ = judge_before;
    }
  }
}

// The first effect was chosen alone. If others had to follow, the one that came second may need fewer of them: a wrong
// first one is mended by effects that are not there. Both results are judged by the same noise, each effect at the
// price that it has in the search.
void StandSearcher::start_with_runner_up() {
  if (out_.chosen.hypothesis.size() < 2 || first_round_.size() < 2) return;
  const StandFit second = first_round_[1].fit;
  const Hypothesis& found = out_.chosen.hypothesis;
  const bool has =
      std::any_of(found.begin(), found.end(), [&](const Effect& e) { return is_same(e, second.hypothesis.back()); });
  if (has || second.score - first_round_[0].fit.score > kRicher) return;
  const StandFit start = finish(second, second.hypothesis);
  if (!is_significant(start)) return;
  const StandOutcome before = out_;
  const StandJudge judge_before = judge_;
  if (progress_) progress_("again, from " + std::string(get_effect(second.hypothesis.back().id).name));
  out_.rounds.assign(1, first_round_);
  std::swap(out_.rounds[0][0], out_.rounds[0][1]);
  update_noise(start.hypothesis);
  out_.nominal = judge({});
  out_.chosen = finish(judge_again(start), start.hypothesis);
  extend();
  const auto price = [](const StandFit& fit) { return fit.score + kGain * static_cast<double>(fit.hypothesis.size()); };
  const bool better =
      (out_.explained || !before.explained) && price(out_.chosen) < price(judge(before.chosen.hypothesis));
  const bool sound = !list_undone(before.chosen.hypothesis).empty() && list_undone(out_.chosen.hypothesis).empty();
  if (!better && !sound) {
    out_ = before;
    judge_ = judge_before;
  }
}

bool StandSearcher::is_explained() const {
  for (size_t c = 0; c < channels(); ++c) {
    if (!StandJudge::is_quiet(out_.chosen.channel_rms[c], out_.nominal.channel_rms[c])) return false;
  }
  return true;
}

double StandSearcher::find_deviations(double normal) const {
  double stretches = 0;
  for (size_t r : judge_.train()) stretches += (p_.recordings[r].time.back() - p_.recordings[r].time.front()) / kBlock;
  return find_student(normal, stretches - 1);
}

bool StandSearcher::has_moving_feet() const {
  for (size_t c = 0; c < find_places(p_) + count_places(p_); ++c) {
    if (std::max(out_.chosen.channel_rms[c], out_.chosen.train_rms[c]) > kAboveNoise) return true;
  }
  return false;
}

bool StandSearcher::is_significant(const StandFit& fit) const {
  const Effect& e = fit.hypothesis.back();
  const StandRow& row = get_row(e);
  // The motion of a free link has no standard deviation; the held-out gain decides. A link that no torque ever held
  // follows the feet at every sample, so the feet must move beyond their noise.
  if (row.loose) return e.p[3] == 0 || has_moving_feet();
  if (is_vector(e)) {
    const Eigen::VectorXd vector = Eigen::Map<const Eigen::VectorXd>(e.p.data(), static_cast<long>(e.p.size()));
    return calc_deviations(vector, fit.covariance.back()) >
           find_deviations(find_length(kSignificantInRobot, e.p.size()));
  }
  const bool grounded = !exceeds_ground(fit);
  for (size_t i = 0; i < e.p.size(); ++i) {
    const double std = fit.std.back()(static_cast<long>(i)), from = row.neutral[i % row.neutral.size()];
    if (std <= 0 || !is_main(e, i)) continue;
    if (std::abs(e.p[i] - from) - (grounded ? find_bound(p_, e, i) : 0) > significant_ * std) return true;
  }
  return false;
}

namespace {

// True if `simple` is the rotor alone of the elastic transmission `rich` and fits nearly as well. If the elasticity is
// uncertain, the rotor alone may be the cause. While other effects are missing, a slightly better fit of the
// transmission proves nothing.
bool is_contained(const StandFit& simple, const StandFit& rich, const StandFit& so_far) {
  const Effect &a = simple.hypothesis.back(), &b = rich.hypothesis.back();
  const double far = std::max(kRicher, kMinor * (so_far.score - rich.score));
  return get_row(a).of_transmission && get_effect(b.id).flexible && !get_row(b).loose && a.place == b.place &&
         simple.score - rich.score < far;
}

}  // namespace

// First significant candidate among those that explain about as much, and among the rotors of uncertain transmissions;
// an empty fit if there is none.
StandFit StandSearcher::find_significant(const std::vector<StandTrial>& trials) const {
  std::vector<const StandFit*> unsure;
  for (const StandTrial& t : trials) {
    const bool contained = std::any_of(unsure.begin(), unsure.end(),
                                       [&](const StandFit* rich) { return is_contained(t.fit, *rich, out_.chosen); });
    if (t.probability < kMinor && !contained) continue;
    StandFit finished = finish(t.fit, t.fit.hypothesis);
    if (is_significant(finished)) return finished;
    unsure.push_back(&t.fit);
  }
  return {};
}

// Every effect but slip must not make held-out recordings worse. Slip need not occur in them.
bool StandSearcher::predicts_worse(const StandFit& fit) const {
  return !get_row(fit.hypothesis.back()).slides && fit.held_score > out_.chosen.held_score;
}

bool StandSearcher::add_effect() {
  const std::vector<StandTrial> trials = try_candidates(out_.chosen);
  if (trials.empty() || trials[0].fit.score >= 1e299) return false;
  const StandTrial& best = trials[0];
  const double gain = out_.chosen.score - best.fit.score;
  if (progress_) {
    std::string text = "gain " + std::to_string(std::lround(gain)) + " by";
    for (size_t i = 0; i < std::min<size_t>(4, trials.size()); ++i) {
      const double behind = std::min(1e6, trials[i].fit.score - best.fit.score);
      text += std::string(i ? ", " : " ") + get_effect(trials[i].fit.hypothesis.back().id).name +
              (i ? " (" + std::to_string(std::lround(behind)) + " behind)" : "");
    }
    progress_(text);
  }
  if (out_.chosen.hypothesis.empty()) {
    first_round_ = trials;
    out_.rounds.push_back(trials);  // reported even if nothing is accepted
  }
  if (gain < std::max(kGain, kKnown * out_.chosen.mismatch)) return false;
  if (predicts_worse(best.fit)) return false;
  const StandFit finished = find_significant(trials);
  if (finished.hypothesis.empty() || predicts_worse(finished)) return false;
  if (!out_.chosen.hypothesis.empty()) out_.rounds.push_back(trials);
  update_noise(finished.hypothesis);
  out_.nominal = judge({});
  out_.chosen = finish(judge_again(finished), finished.hypothesis);
  return true;
}

// True if the parameter that makes the law richer is significant.
bool StandSearcher::is_richer(const StandFit& fit, size_t effect) const {
  const Effect& e = fit.hypothesis[effect];
  const Eigen::VectorXd& std = fit.std[effect];
  if (!is_foot(e)) return e.p[1] > significant_ * std(1);
  for (size_t at = kFootParameters; at < e.p.size(); at += kFootParameters + 1) {
    if (e.p[at] > significant_ * std(static_cast<long>(at))) return true;
  }
  return false;
}

void StandSearcher::enrich_effects() {
  for (size_t i = 0; i < out_.chosen.hypothesis.size(); ++i) {
    StandFit best;
    best.score = out_.chosen.score - kRicher;
    for (const Effect& richer : list_richer(p_, out_.chosen.hypothesis[i])) {
      Hypothesis h = out_.chosen.hypothesis;
      h[i] = richer;
      h = refine(p_, judge_.select(out_.chosen), h, 5);
      const StandFit fit = judge(h);
      if (are_sensible(p_, h) && fit.score < best.score) best = fit;
    }
    if (best.hypothesis.empty()) continue;
    const StandFit finished = finish(best, best.hypothesis);
    // Parameters of a richer law may be strongly correlated (a level that decreases with speed). Then the gain in score
    // counts.
    const bool wins = out_.chosen.score - best.score > kGain && best.held_score < out_.chosen.held_score;
    if (!wins && !is_richer(finished, i)) continue;
    if (progress_) progress_("refined to " + get_effect(finished.hypothesis[i].id).name);
    if (i < out_.rounds.size() && !out_.rounds[i].empty()) {
      StandTrial& first = out_.rounds[i][0];
      if (is_same(first.fit.hypothesis[i], out_.chosen.hypothesis[i])) first.fit.hypothesis[i] = finished.hypothesis[i];
    }
    out_.chosen = finished;
  }
}

// Tries all other effects in the place of each effect, beside the rest, because earlier effects were chosen without the
// later ones. The last effect was chosen with all others, so it is skipped unless `all`.
void StandSearcher::exchange_effects(bool all) {
  for (size_t i = 0; i + (all ? 0 : 1) < out_.chosen.hypothesis.size(); ++i) {
    Hypothesis rest = out_.chosen.hypothesis;
    const Effect before = rest[i];
    rest.erase(rest.begin() + static_cast<long>(i));
    const Hypothesis refitted = rest.empty() ? rest : refine(p_, judge_.select(out_.chosen), rest, 5);
    const StandFit fit = judge(refitted);
    if (fit.score - out_.chosen.score < kGain) {  // no longer needed
      out_.rounds.erase(out_.rounds.begin() + static_cast<long>(i));
      out_.chosen = rest.empty() ? fit : finish(fit, refitted);
      return exchange_effects(true);
    }
    std::vector<StandTrial> trials = try_candidates(fit);
    if (trials.empty() || trials[0].fit.score >= 1e299) continue;
    const bool better =
        !is_same(trials[0].fit.hypothesis.back(), before) && trials[0].fit.score < out_.chosen.score - kCorrelated;
    if (better && is_significant(finish(trials[0].fit, trials[0].fit.hypothesis))) {
      Hypothesis h = trials[0].fit.hypothesis;
      if (progress_) progress_("exchanged for " + get_effect(h.back().id).name);
      std::rotate(h.begin() + static_cast<long>(i), h.end() - 1, h.end());
      out_.chosen = finish(trials[0].fit, h);
    }
    for (StandTrial& t : trials) {
      std::rotate(t.fit.hypothesis.begin() + static_cast<long>(i), t.fit.hypothesis.end() - 1, t.fit.hypothesis.end());
    }
    out_.rounds[i] = trials;
  }
}

StandOutcome search_standing(const StandProblems& problems, int jobs, const Progress& progress) {
  return StandSearcher(problems, jobs, progress).run();
}

}  // namespace hrp::diagnosis::standing
