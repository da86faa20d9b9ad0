// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright/search.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/search/fit.h"
#include "diagnosis/upright/dependence.h"
#include "diagnosis/upright/hints.h"
#include "diagnosis/upright/slip.h"

namespace hrp::diagnosis::upright {
namespace {

// Some 500 candidates are looked at; one in a thousand clean robots may be wronged. For a parameter that is two in a
// million: 4.75 normal deviations. For the score, whose eighth is a logarithm of probability, ln(500 / 1e-3).
constexpr double kNormal = 4.75;
constexpr double kGain = kCorrelated * 13.1;
constexpr double kRicher = 40;       // the same where a law is replaced by a richer one at the same place
constexpr double kTwin = 0.05;       // least probability of what is reported as not to be told apart
constexpr size_t kRefined = 8;       // candidates that are fitted to the end in each round
constexpr size_t kMostEffects = 3;
// A robot's drives are made alike: what one joint lacks the others may lack, too. So many effects with those.
constexpr size_t kMostAlike = 12;

bool is_same(const StandEffect& a, const StandEffect& b) { return a.id == b.id && a.place == b.place; }

class Search {
 public:
  Search(const StandProblems& problems, int jobs, const Progress& progress)
      : problems_(problems),
        p_(problems.all),
        coarse_(make_coarse(p_)),
        coarse_even_(make_coarse(problems.even)),
        coarse_odd_(make_coarse(problems.odd)),
        judge_(p_),
        jobs_(jobs),
        progress_(progress) {
    out_.channels = judge_.list();
    for (size_t r = 0; r < p_.recordings.size(); ++r) all_.push_back(r);
  }

  StandOutcome run() {
    update_noise({});
    out_.nominal = out_.chosen = judge({});
    if (!find_slip_ratio(p_, &hints_.slip_ratio, &slip_spread_)) hints_.slip_ratio = 0;
    hints_.ripples.resize(p_.effort.size()), hints_.play.resize(p_.effort.size());
    give_ = find_tilting(p_), significant_ = find_significance();
    extend();
    if (out_.mismatch && !out_.explained) start_with_soles();
    if (out_.explained) refuse_couplings();
    if (!out_.explained) doubt();
    find_twins();
    out_.sigma = judge_.sigma();
    return std::move(out_);
  }

 private:
  size_t channels() const { return out_.channels.size(); }
  static double worst(const StandFit& fit) { return *std::max_element(fit.channel_rms.begin(), fit.channel_rms.end()); }

  bool is_full() const { return out_.chosen.hypothesis.size() >= kMostEffects; }
  void extend() {
    while (out_.chosen.hypothesis.size() < kMostEffects && add_effect()) {
    }
    if (out_.chosen.hypothesis.size() > 1) exchange_effects();
    while (is_full() && out_.chosen.hypothesis.size() < kMostAlike && add_effect()) {
    }
    enrich_effects();
    const bool found = !out_.chosen.hypothesis.empty(), quiet = is_explained();
    const std::vector<double>& train = out_.nominal.train_rms;
    const double most = *std::max_element(train.begin(), train.end());
    out_.mismatch = found || worst(out_.nominal) > kMismatch || most > StandJudge::kLeftOver;
    out_.explained = found && quiet;
  }

  // Soft soles beside a second effect in the feet may look impossible alone (a stiffness below zero) and are then never
  // the first to be added: once more from them, if that explains what else would stay unexplained.
  void start_with_soles() {
    const auto soft = [](const StandEffect& e) { return is_foot(e.id); };
    const StandHypothesis& found = out_.chosen.hypothesis;
    if (std::any_of(found.begin(), found.end(), soft)) return;
    for (const StandEffect& e : list_candidates(p_, {}, hints_)) {
      if (e.id != StandId::kFootCompliance) continue;
      const StandOutcome before = out_;
      const StandJudge judge_before = judge_;
      const StandHypothesis h = refine(p_, judge_.select(out_.nominal), {e}, 2);
      out_.chosen = judge(h);
      out_.rounds.assign(1, {});
      extend();
      const bool more = out_.chosen.hypothesis.size() > 1;
      if (!more || !out_.explained || !are_sensible(p_, out_.chosen.hypothesis)) out_ = before, judge_ = judge_before;
    }
  }

  bool is_explained() const {
    for (size_t c = 0; c < channels(); ++c) {
      if (!StandJudge::is_quiet(out_.chosen.channel_rms[c], out_.nominal.channel_rms[c])) return false;
    }
    return true;
  }

  bool add_effect();
  void enrich_effects();
  bool is_richer(const StandFit& fit, size_t effect) const;
  std::vector<StandEffect> list_next(const StandFit& so_far, const Evaluation& base) const;
  std::vector<StandTrial> try_candidates(const StandFit& so_far) const;
  struct Screen {  // what screening of all candidates shares: the rows of what was found so far
    Evaluation base, even, odd;
    std::vector<double> noise;
    double score = 0, offset = 0;  // of it; less that of all samples thinned out, whose means are others
    SharedColumns columns;
  };
  StandTrial screen(const StandFit& so_far, const StandEffect& candidate, const Screen& shared) const;
  std::vector<double> find_noise_of(const StandHypothesis& h, const Screen& shared) const;
  StandFit judge(const StandHypothesis& h) const;
  void update_noise(const StandHypothesis& h);
  StandFit finish(const StandFit& so_far, const StandHypothesis& hypothesis) const;
  StandFit judge_again(const StandFit& fit) const;
  double find_significance() const;
  bool is_significant(const StandFit& fit) const;
  void exchange_effects();
  void find_twins();
  void doubt();
  bool is_consistent(size_t effect) const;
  bool explains_its_part(size_t effect) const;
  bool is_coupled(size_t effect) const;
  void refuse_couplings();

  const StandProblems& problems_;
  const StandProblem& p_;
  StandProblem coarse_, coarse_even_, coarse_odd_;  // a third of the samples: enough to rank candidates
  StandJudge judge_;
  int jobs_;
  Progress progress_;
  StandOutcome out_;
  std::vector<size_t> all_;
  StandHints hints_;
  double slip_spread_ = 0, significant_ = 0;
  Eigen::Vector2d give_{0, 0};  // [rad] deviation of a foot's roll and pitch by what ground and sole may give
};

// The linear prediction of what a candidate would leave: enough to rank.
StandTrial Search::screen(const StandFit& so_far, const StandEffect& candidate, const Screen& all) const {
  const SharedColumns& shared = all.columns;
  const Evaluation& base = all.base;
  StandTrial trial;
  StandHypothesis h = so_far.hypothesis;
  h.push_back(candidate);
  const bool late = candidate.id == StandId::kImuDelay || candidate.id == StandId::kWrenchDelay;
  if (candidate.id == StandId::kBacklash || late) {  // too far from linear
    h = refine(coarse_, judge_.select(so_far), h, late ? 2 : 1);
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
  const Eigen::VectorXd delta = solve_with(coarse_, judge_.select(so_far), shared, h, added);
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
    trial.fit.hypothesis = h, trial.fit.score = 1e300;
    return trial;
  }
  trial.fit = judge_.judge(h, predicted, adds_noise(candidate.id) ? find_noise_of(h, all) : std::vector<double>{});
  return trial;
}

// By channel the noise [squared] that the last effect of a hypothesis adds.
std::vector<double> Search::find_noise_of(const StandHypothesis& h, const Screen& all) const {
  const StandEffect& last = h.back();
  const auto with = [&](const StandProblem& half, const Evaluation& without) {
    Evaluation out(without.size());
    for (size_t r = 0; r < out.size(); ++r) {
      out[r].residuals = is_drive(last.id) ? calc_drive_channels(half, h, r, without[r], last.place)
                                           : calc_channels(half, h, r);
    }
    return out;
  };
  std::vector<double> out = judge_.find_noise(with(coarse_even_, all.even), with(coarse_odd_, all.odd));
  for (size_t c = 0; c < out.size(); ++c) out[c] = std::max(0.0, out[c] - all.noise[c]);
  return out;
}

// What may be added: anything at first, then only what was found at other joints already.
std::vector<StandEffect> Search::list_next(const StandFit& so_far, const Evaluation& base) const {
  StandHints hints = hints_;
  hints.ripples = find_ripples(coarse_, base);
  for (size_t j = 0; j < hints.play.size(); ++j) hints.play[j] = find_play(coarse_, so_far.hypothesis, j);
  std::vector<StandEffect> list = list_candidates(p_, so_far.hypothesis, hints);
  if (so_far.hypothesis.size() < kMostEffects) return list;
  const auto is_new = [&](const StandEffect& candidate) {
    const StandHypothesis& h = so_far.hypothesis;
    return !is_joint(candidate.id) ||
           std::none_of(h.begin(), h.end(), [&](const StandEffect& e) { return e.id == candidate.id; });
  };
  list.erase(std::remove_if(list.begin(), list.end(), is_new), list.end());
  return list;
}

// Candidates added to what was found so far, the best few of them fitted to the end; best first.
std::vector<StandTrial> Search::try_candidates(const StandFit& so_far) const {
  Screen shared{evaluate(coarse_, so_far.hypothesis), evaluate(coarse_even_, so_far.hypothesis),
                evaluate(coarse_odd_, so_far.hypothesis), {}, 0, 0, {}};
  const Evaluation& base = shared.base;
  shared.score = judge_.judge(so_far.hypothesis, base).score;
  shared.offset =
      shared.score - judge_.judge(so_far.hypothesis, thin_out(evaluate(p_, so_far.hypothesis), channels())).score;
  shared.noise = judge_.find_noise(shared.even, shared.odd);
  shared.columns = share_columns(judge_.select(so_far), differentiate(coarse_, so_far.hypothesis, 0, base, all_), base);
  const std::vector<StandEffect> candidates = list_next(so_far, base);
  std::vector<StandTrial> trials(candidates.size());
  parallel_for(jobs_, static_cast<int>(candidates.size()), [&](int i) {
    trials[static_cast<size_t>(i)] = screen(so_far, candidates[static_cast<size_t>(i)], shared);
  });
  const auto better = [](const StandTrial& a, const StandTrial& b) { return a.fit.score < b.fit.score; };
  std::stable_sort(trials.begin(), trials.end(), better);
  std::vector<StandTrial> best;  // of one effect at one place only the best start
  for (const StandTrial& t : trials) {
    if (best.size() >= kRefined || t.fit.score >= shared.score) break;
    const bool known = std::any_of(best.begin(), best.end(), [&](const StandTrial& b) {
      return is_same(b.fit.hypothesis.back(), t.fit.hypothesis.back());
    });
    if (!known) best.push_back(t);
  }
  for (const int iterations : {2, 3}) {  // those that are far behind after the first two are left there
    const double first = best.empty() ? 0 : best[0].fit.score;
    const double within = first + 0.5 * std::abs(so_far.score - first) + kGain;
    parallel_for(jobs_, static_cast<int>(best.size()), [&](int i) {
      StandTrial& trial = best[static_cast<size_t>(i)];
      if (iterations > 2 && trial.fit.score > within) return;
      const StandHypothesis h = refine(p_, judge_.select(so_far), trial.fit.hypothesis, iterations);
      trial.fit = judge(h);
      if (!are_sensible(p_, h)) trial.fit.score = 1e300;
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

StandFit Search::judge(const StandHypothesis& h) const {
  return judge_.judge(h, evaluate(p_, h), judge_.find_extra_noise(evaluate(problems_.even, h), evaluate(problems_.odd, h)));
}

void Search::update_noise(const StandHypothesis& h) {
  judge_.update_sigma(evaluate(p_, h), h);
  judge_.set_reference(evaluate(problems_.even, h), evaluate(problems_.odd, h));
}

// The final fit of a hypothesis, with deviations.
StandFit Search::finish(const StandFit& so_far, const StandHypothesis& hypothesis) const {
  StandHypothesis h = hypothesis;
  Eigen::MatrixXd covariance;
  if (!polish(problems_, judge_.select(so_far), 3, &h, &covariance)) {
    const Evaluation base = evaluate(p_, h);
    covariance = solve(p_, judge_.select(so_far), h, differentiate(p_, h, 0, base, judge_.train()), base).covariance;
  }
  for (StandEffect& e : h) {
    if (e.id == StandId::kBacklash) e.p[3] = find_seen_play(p_, h, e);
  }
  StandFit fit = judge(h);
  long at = 0;
  for (const StandEffect& e : h) {
    Eigen::VectorXd std(static_cast<long>(e.p.size()));
    for (long i = 0; i < std.size(); ++i, ++at) {
      std(i) = e.id == StandId::kGroundFriction ? slip_spread_ / 3 : std::sqrt(std::max(0.0, covariance(at, at)));
      if (e.id == StandId::kJointOffset) std(i) = std::hypot(std(i), give_.norm());
      if (e.id == StandId::kGroundSlope) std(i) = std::hypot(std(i), give_(i));
    }
    fit.std.push_back(std);
  }
  return fit;
}

// Deviations by which a parameter must differ from no effect: those of kNormal where the deviation itself is known from
// so many independent stretches only (Student's t by Wallace's approximation, good to 1 % from four stretches on).
double Search::find_significance() const {
  double stretches = 0;
  for (size_t r : judge_.train()) stretches += (p_.recordings[r].time.back() - p_.recordings[r].time.front()) / kStretch;
  const double n = std::max(4.0, stretches - 1), z = kNormal * (8 * n + 3) / (8 * n + 1);
  return std::sqrt(n * (std::exp(z * z / n) - 1));
}

bool Search::is_significant(const StandFit& fit) const {
  const StandEffect& e = fit.hypothesis.back();
  const StandInfo& info = get_stand_info(e.id);
  if (e.id == StandId::kBacklash) return true;  // how far a free link moves has no deviation; the held-out gain tells
  for (size_t i = 0; i < e.p.size(); ++i) {
    const double std = fit.std.back()(static_cast<long>(i)), from = info.neutral[i % info.neutral.size()];
    if (std <= 0 || find_prior(p_, e, i) > 0 || !is_main(e.id, i)) continue;
    if (std::abs(e.p[i] - from) > significant_ * std) return true;
  }
  return false;
}

bool Search::add_effect() {
  const std::vector<StandTrial> trials = try_candidates(out_.chosen);
  if (trials.empty() || trials[0].fit.score >= 1e299) return false;
  const StandTrial& best = trials[0];
  const double gain = out_.chosen.score - best.fit.score;
  if (progress_) {
    std::string text = "gain " + std::to_string(std::lround(gain)) + " by";
    for (size_t i = 0; i < std::min<size_t>(4, trials.size()); ++i) {
      const double behind = std::min(1e6, trials[i].fit.score - best.fit.score);
      text += std::string(i ? ", " : " ") + get_stand_info(trials[i].fit.hypothesis.back().id).effect +
              (i ? " (" + std::to_string(std::lround(behind)) + " behind)" : "");
    }
    progress_(text);
  }
  if (out_.chosen.hypothesis.empty()) out_.rounds.push_back(trials);  // also shown when nothing is accepted
  if (gain < std::max(kGain, 0.02 * out_.nominal.mismatch)) return false;
  // Feet that were seen to slide need not slide again in the recordings that were not fitted; all else must help there.
  const bool slips = best.fit.hypothesis.back().id == StandId::kGroundFriction;
  if (!slips && best.fit.held_score >= out_.chosen.held_score) return false;
  // Of those that explain as much the first that differs from nothing.
  StandFit finished;
  for (const StandTrial& t : trials) {
    if (t.probability < kTwin) break;
    finished = finish(t.fit, t.fit.hypothesis);
    if (is_significant(finished)) break;
    finished.hypothesis.clear();
  }
  if (finished.hypothesis.empty()) return false;
  if (!out_.chosen.hypothesis.empty()) out_.rounds.push_back(trials);
  update_noise(finished.hypothesis);
  out_.nominal = judge({});
  out_.chosen = finish(judge_again(finished), finished.hypothesis);
  return true;
}

// What makes the law richer differs from nothing.
bool Search::is_richer(const StandFit& fit, size_t effect) const {
  const StandEffect& e = fit.hypothesis[effect];
  const Eigen::VectorXd& std = fit.std[effect];
  if (e.id == StandId::kStribeck) return e.p[1] > significant_ * std(1);
  for (size_t at = kFootParameters; at < e.p.size(); at += kFootParameters + 1) {
    if (e.p[at] > significant_ * std(static_cast<long>(at))) return true;
  }
  return false;
}

void Search::enrich_effects() {
  for (size_t i = 0; i < out_.chosen.hypothesis.size(); ++i) {
    StandFit best;
    best.score = out_.chosen.score - kRicher;
    for (const StandEffect& richer : list_richer(p_, out_.chosen.hypothesis[i])) {
      StandHypothesis h = out_.chosen.hypothesis;
      h[i] = richer;
      h = refine(p_, judge_.select(out_.chosen), h, 5);
      const StandFit fit = judge(h);
      if (are_sensible(p_, h) && fit.score < best.score) best = fit;
    }
    if (best.hypothesis.empty()) continue;
    const StandFit finished = finish(best, best.hypothesis);
    // Parameters of a richer law are often alike (a level that falls with speed): then what it wins counts.
    const bool wins = out_.chosen.score - best.score > kGain && best.held_score < out_.chosen.held_score;
    if (!wins && !is_richer(finished, i)) continue;
    if (progress_) progress_(std::string("refined to ") + get_stand_info(finished.hypothesis[i].id).effect);
    if (i < out_.rounds.size() && !out_.rounds[i].empty()) {
      StandTrial& first = out_.rounds[i][0];
      if (is_same(first.fit.hypothesis[i], out_.chosen.hypothesis[i])) first.fit.hypothesis[i] = finished.hypothesis[i];
    }
    out_.chosen = finished;
  }
}

StandFit Search::judge_again(const StandFit& fit) const {
  StandFit out = judge(fit.hypothesis);
  out.std = fit.std;
  return out;
}

// Each effect against all others in its place, given the rest: what came first was chosen without knowing the second.
void Search::exchange_effects() {
  for (size_t i = 0; i + 1 < out_.chosen.hypothesis.size(); ++i) {
    StandHypothesis rest = out_.chosen.hypothesis;
    const StandEffect before = rest[i];
    rest.erase(rest.begin() + static_cast<long>(i));
    const StandHypothesis refitted = refine(p_, judge_.select(out_.chosen), rest, 5);
    const StandFit fit = judge(refitted);
    if (fit.score - out_.chosen.score < kGain) {  // no longer needed
      out_.rounds.erase(out_.rounds.begin() + static_cast<long>(i));
      out_.chosen = finish(fit, refitted);
      return exchange_effects();
    }
    std::vector<StandTrial> trials = try_candidates(fit);
    if (trials.empty() || trials[0].fit.score >= 1e299) continue;
    if (!is_same(trials[0].fit.hypothesis.back(), before) && trials[0].fit.score < out_.chosen.score - kCorrelated) {
      StandHypothesis h = trials[0].fit.hypothesis;
      if (progress_) progress_(std::string("exchanged for ") + get_stand_info(h.back().id).effect);
      std::rotate(h.begin() + static_cast<long>(i), h.end() - 1, h.end());
      out_.chosen = finish(trials[0].fit, h);
    }
    for (StandTrial& t : trials) {
      std::rotate(t.fit.hypothesis.begin() + static_cast<long>(i), t.fit.hypothesis.end() - 1, t.fit.hypothesis.end());
    }
    out_.rounds[i] = trials;
  }
}

// Whether each recording alone asks for the same parameters: what is true is the same everywhere.
bool Search::is_consistent(size_t effect) const {
  const StandHypothesis& h = out_.chosen.hypothesis;
  size_t first = 0;
  for (size_t i = 0; i < effect; ++i) first += h[i].p.size();
  const Evaluation base = evaluate(p_, h);
  const std::vector<Derivative> columns = differentiate(p_, h, 0, base, all_);
  const StandInfo& info = get_stand_info(h[effect].id);
  FitSelection selection = judge_.select(out_.chosen);
  for (size_t r = 0; r < p_.recordings.size(); ++r) {
    selection.recordings = {r};
    const StandStep step = solve(p_, selection, h, columns, base);
    if (!step.ok) continue;
    for (size_t i = 0; i < h[effect].p.size(); ++i) {
      if (find_prior(p_, h[effect], i) > 0 || !is_main(h[effect].id, i)) continue;
      const auto at = static_cast<long>(first + i);
      const double size = std::abs(h[effect].p[i] - info.neutral[i % info.neutral.size()]);
      const double off = std::abs(step.delta(at)), std = std::sqrt(std::max(0.0, step.covariance(at, at)));
      if (off > 4 * std + 0.2 * size && off > 4 * out_.chosen.std[effect](static_cast<long>(i))) return false;
    }
  }
  return true;
}

// Whether the equation that needs an effect most is then left with noise: what stands in for something else hardly ever
// explains all of it.
bool Search::explains_its_part(size_t effect) const {
  StandHypothesis rest = out_.chosen.hypothesis;
  rest.erase(rest.begin() + static_cast<long>(effect));
  const StandFit without = judge(rest);
  size_t most = 0;
  const auto gain = [&](size_t c) { return without.channel_rms[c] - out_.chosen.channel_rms[c]; };
  for (size_t c = 0; c < channels(); ++c) {
    if (gain(c) > gain(most)) most = c;
  }
  return StandJudge::is_quiet(out_.chosen.channel_rms[most], without.channel_rms[most]);
}

// Whether another joint lacks what follows the position of this effect's joint: then something couples the two.
bool Search::is_coupled(size_t effect) const {
  const StandEffect& e = out_.chosen.hypothesis[effect];
  if (!is_joint(e.id)) return false;
  const Evaluation left = evaluate(p_, out_.chosen.hypothesis);
  for (size_t c = 0; c < channels(); ++c) {
    if (out_.channels[c].kind != "effort" || out_.chosen.channel_rms[c] < kMismatch) continue;
    if (follows_joint(p_, out_.channels[c], c, left, e.place)) return true;
  }
  return false;
}

// Two drives whose missing efforts are equal and opposite pull at each other: no effects of the one and of the other.
void Search::refuse_couplings() {
  const Evaluation nominal = evaluate(p_, {});
  const StandHypothesis& h = out_.chosen.hypothesis;
  const auto find_channel = [&](const StandEffect& e) {
    const std::string& name = p_.tree.joint(e.place).name;
    size_t c = 0;
    while (c < channels() && !(out_.channels[c].kind == "effort" && out_.channels[c].joint == name)) ++c;
    return c;
  };
  for (const StandEffect& a : h) {
    for (const StandEffect& b : h) {
      if (!is_joint(a.id) || !is_joint(b.id) || a.place >= b.place) continue;
      if (!out_.opposite && are_opposite(nominal, channels(), find_channel(a), find_channel(b))) out_.opposite = true;
    }
  }
  if (out_.opposite) out_.explained = false;
}

// When not all is explained, an effect may be a stand-in for what is missing: named only if it is the same everywhere.
void Search::doubt() {
  for (size_t i = out_.chosen.hypothesis.size(); i-- > 0;) {
    if (!(out_.opposite && is_joint(out_.chosen.hypothesis[i].id)) && is_consistent(i) && explains_its_part(i) &&
        !is_coupled(i)) {
      continue;
    }
    out_.doubtful.push_back(out_.chosen.hypothesis[i]);
    out_.chosen.hypothesis.erase(out_.chosen.hypothesis.begin() + static_cast<long>(i));
    out_.rounds.erase(out_.rounds.begin() + static_cast<long>(i));
  }
  if (out_.doubtful.empty()) return;
  const StandFit fit = judge(out_.chosen.hypothesis);
  out_.chosen = fit.hypothesis.empty() ? fit : finish(fit, refine(p_, judge_.select(fit), fit.hypothesis, 2));
}

void Search::find_twins() {
  for (size_t i = 0; i < out_.chosen.hypothesis.size(); ++i) {
    out_.twins.emplace_back();
    if (i >= out_.rounds.size()) continue;
    for (const StandTrial& t : out_.rounds[i]) {
      const StandEffect& e = t.fit.hypothesis[i];
      if (t.fit.score < 1e299 && t.probability > kTwin && !is_same(e, out_.chosen.hypothesis[i])) {
        out_.twins.back().push_back(e);
      }
    }
  }
}

}  // namespace

StandOutcome search_standing(const StandProblems& problems, int jobs, const Progress& progress) {
  return Search(problems, jobs, progress).run();
}

}  // namespace hrp::diagnosis::upright
