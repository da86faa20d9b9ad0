// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright_search.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/fit.h"

namespace hrp::diagnosis::upright {
namespace {

// A fit of dozens of parameters leaves the details of laws in the worst of some eighty equations; more than what makes a
// mismatch where nothing was fitted.
constexpr double kLeftOver = 2.5;
constexpr double kMismatch = 2.0;    // a channel beyond this many noise deviations (rms) disagrees with the model
constexpr double kSignificant = 6;   // deviations by which a parameter must differ from no effect
constexpr double kGain = 150;        // least gain of the score; a clean recording's candidates gain below 40
constexpr double kCorrelated = 8;    // samples that tell as much as one: errors of neighbours are alike
constexpr double kTwin = 0.05;       // least probability of what is reported as not to be told apart
constexpr size_t kRefined = 8;       // candidates that are fitted to the end in each round
constexpr size_t kMostEffects = 3, kThin = 3;  // one sample of kThin is enough to rank candidates by
// A robot's drives are made alike: what one joint lacks the others may lack, too. So many effects with those.
constexpr size_t kMostAlike = 12;

bool is_same(const StandEffect& a, const StandEffect& b) { return a.id == b.id && a.place == b.place; }

// Smallest noise of a channel that is believed: what rounding in a file and contact of a stiff sole leave, and the
// error of an attitude that was not recorded.
double find_floor(const StandProblem& p, const Channel& c) {
  const double tilt = p.attitude_error;
  double weight = 0;
  for (const LinkSpec& link : p.tree.links) weight += 9.81 * link.inertia.mass;
  if (c.kind == "tilt") return std::max(2e-5, tilt);
  if (c.kind == "gap") return std::max(5e-6, 0.3 * tilt);  // feet some 0.3 m apart
  if (c.kind == "stand" || c.kind == "base") return 1e-5;
  if (c.kind == "balance") return std::max(0.02, weight * tilt);
  if (c.kind == "effort") return std::max(2e-3, 0.3 * weight * tilt);
  if (c.kind == "gyro") return 1e-4;
  if (c.kind == "velocity") return 1e-4;
  return c.kind == "gravity" ? std::max(3e-3, 9.81 * tilt) : 2e-3;
}

class Search {
 public:
  Search(const StandProblems& problems, int jobs, const Progress& progress)
      : problems_(problems), p_(problems.all), coarse_(problems.all), jobs_(jobs), progress_(progress) {
    out_.channels = list_channels(p_);
    for (size_t r = 0; r < p_.recordings.size(); ++r) (p_.recordings[r].train ? train_ : held_).push_back(r);
    if (held_.empty()) held_ = train_;
    if (train_.empty()) train_ = held_;
    for (size_t r = 0; r < p_.recordings.size(); ++r) all_.push_back(r);
    for (StandRecording& r : coarse_.recordings) {
      std::vector<int> few;
      for (size_t s = kThin / 2; s < r.samples.size(); s += kThin) few.push_back(r.samples[s]);
      r.samples = few;
    }
  }

  StandOutcome run() {
    Evaluation base = evaluate(p_, {});
    out_.sigma.assign(channels(), 1e300), update_sigma(base);
    out_.nominal = out_.chosen = judge({}, base);
    if (!find_slip_ratio(p_, &slip_ratio_, &slip_spread_)) slip_ratio_ = 0;
    extend();
    if (out_.mismatch && !out_.explained) start_with_soles();
    if (!out_.explained) doubt();
    find_twins();
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
    out_.mismatch = worst(out_.nominal) > kMismatch || !out_.chosen.hypothesis.empty();
    out_.explained = out_.mismatch && is_explained();
  }

  // Soft soles beside a second effect in the feet may look impossible alone (a stiffness below zero) and are then never
  // the first to be added: once more from them, if that explains what else would stay unexplained.
  void start_with_soles() {
    const auto soft = [](const StandEffect& e) { return is_foot(e.id); };
    const StandHypothesis& found = out_.chosen.hypothesis;
    if (std::any_of(found.begin(), found.end(), soft)) return;
    for (const StandEffect& e : list_candidates(p_, {}, 0)) {
      if (e.id != StandId::kFootCompliance) continue;
      const StandOutcome before = out_;
      const StandHypothesis h = refine(p_, select(out_.nominal), {e}, 2);
      out_.chosen = judge(h, evaluate(p_, h));
      out_.rounds.assign(1, {});
      extend();
      const bool more = out_.chosen.hypothesis.size() > 1;
      if (!more || !out_.explained || !are_sensible(p_, out_.chosen.hypothesis)) out_ = before;
    }
  }

  // What is left is noise, or a thousandth (of its power) of what there was.
  bool is_explained() const {
    for (size_t c = 0; c < channels(); ++c) {
      const double left = out_.chosen.channel_rms[c], before = out_.nominal.channel_rms[c];
      if (left > kLeftOver && left * left > 1e-3 * before * before) return false;
    }
    return true;
  }

  // Noise of each channel from the high frequencies of its residual; once more is explained it can only get smaller.
  void update_sigma(const Evaluation& evaluation) {
    for (size_t c = 0; c < channels(); ++c) {
      const bool sparse = out_.channels[c].kind == "gyro";
      std::vector<double> found;
      for (const StandBase& base : evaluation) {
        std::vector<double> one;
        for (size_t k = c; k < base.residuals.size(); k += channels()) {
          const double v = base.residuals[k];
          if (v != 0 || !sparse) one.push_back(v == 0 ? std::nan("") : v);  // 0: says nothing
        }
        const double noise = one.size() > 8 ? estimate_noise(one) : 0;
        if (noise > 0 || out_.sigma[c] == 1e300) found.push_back(noise);
      }
      if (found.empty()) continue;
      std::sort(found.begin(), found.end());
      const double floor = find_floor(p_, out_.channels[c]);
      out_.sigma[c] = std::min(out_.sigma[c], std::max(floor, found[found.size() / 2]));
    }
  }

  StandFit judge(const StandHypothesis& h, const Evaluation& evaluation) const {
    StandFit fit;
    fit.hypothesis = h;
    for (size_t c = 0; c < channels(); ++c) {
      double sum = 0, count = 0, said = 0;
      for (size_t r : held_) {
        const std::vector<double>& residuals = evaluation[r].residuals;
        for (size_t k = c; k < residuals.size(); k += channels(), ++count) {
          sum += residuals[k] * residuals[k];
          said += residuals[k] != 0;  // where friction holds or a foot rolls over its edge nothing is said
        }
      }
      const double square = sum / std::max(1.0, said) / (out_.sigma[c] * out_.sigma[c]);
      fit.channel_rms.push_back(std::sqrt(square));
      if (out_.channels[c].kind == "gyro") count = said;
      fit.score += count * std::log(std::max(square, 1.0));
    }
    for (const StandEffect& e : h) fit.score += kCorrelated * static_cast<double>(e.p.size());
    return fit;
  }

  // Channels that stay far from their noise count less: whatever else is missing there must not bend the parameters.
  FitSelection select(const StandFit& so_far) const {
    FitSelection out{train_, {}};
    for (size_t c = 0; c < channels(); ++c) {
      out.weight.push_back(1 / (out_.sigma[c] * std::clamp(so_far.channel_rms[c], 1.0, 3.0)));
    }
    return out;
  }

  bool add_effect();
  std::vector<StandEffect> list_next(const StandFit& so_far) const;
  std::vector<StandTrial> try_candidates(const StandFit& so_far) const;
  StandTrial screen(const StandFit& so_far, const StandEffect& candidate, const SharedColumns& shared,
                    const Evaluation& base) const;
  StandFit finish(const StandFit& so_far, const StandHypothesis& hypothesis) const;
  StandFit judge_again(const StandFit& fit) const;
  bool is_significant(const StandFit& fit) const;
  void exchange_effects();
  void find_twins();
  void doubt();
  bool is_consistent(size_t effect) const;

  const StandProblems& problems_;
  const StandProblem& p_;
  StandProblem coarse_;  // a third of the samples: enough to rank candidates
  int jobs_;
  Progress progress_;
  StandOutcome out_;
  std::vector<size_t> train_, held_, all_;
  double slip_ratio_ = 0, slip_spread_ = 0;
};

// The linear prediction of what a candidate would leave: enough to rank.
StandTrial Search::screen(const StandFit& so_far, const StandEffect& candidate, const SharedColumns& shared,
                          const Evaluation& base) const {
  StandTrial trial;
  StandHypothesis h = so_far.hypothesis;
  h.push_back(candidate);
  if (candidate.id == StandId::kGroundFriction || candidate.id == StandId::kSaturation) {  // has no neutral start
    trial.fit = judge(h, evaluate(coarse_, h));
    return trial;
  }
  const std::vector<Derivative> added = differentiate(coarse_, h, so_far.hypothesis.size(), base, all_);
  const Eigen::VectorXd delta = solve_with(coarse_, select(so_far), shared, h, added);
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
  trial.fit = judge(h, predicted);
  if (!are_sensible(p_, h)) trial.fit.score = 1e300;
  return trial;
}

// What may be added: anything at first, then only what was found at other joints already.
std::vector<StandEffect> Search::list_next(const StandFit& so_far) const {
  std::vector<StandEffect> list = list_candidates(p_, so_far.hypothesis, slip_ratio_);
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
  const Evaluation base = evaluate(coarse_, so_far.hypothesis);
  const std::vector<StandEffect> candidates = list_next(so_far);
  const SharedColumns shared =
      share_columns(select(so_far), differentiate(coarse_, so_far.hypothesis, 0, base, all_), base);
  std::vector<StandTrial> trials(candidates.size());
  parallel_for(jobs_, static_cast<int>(candidates.size()), [&](int i) {
    trials[static_cast<size_t>(i)] = screen(so_far, candidates[static_cast<size_t>(i)], shared, base);
  });
  const auto better = [](const StandTrial& a, const StandTrial& b) { return a.fit.score < b.fit.score; };
  std::stable_sort(trials.begin(), trials.end(), better);
  std::vector<StandTrial> best;  // of one effect at one place only the best start
  for (const StandTrial& t : trials) {
    if (best.size() >= kRefined || t.fit.score >= 1e299) break;
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
      const StandHypothesis h = refine(p_, select(so_far), trial.fit.hypothesis, iterations);
      trial.fit = judge(h, evaluate(p_, h));
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

// The final fit of a hypothesis, with deviations.
StandFit Search::finish(const StandFit& so_far, const StandHypothesis& hypothesis) const {
  StandHypothesis h = hypothesis;
  Eigen::MatrixXd covariance;
  if (!polish(problems_, select(so_far), 3, &h, &covariance)) {
    const Evaluation base = evaluate(p_, h);
    covariance = solve(p_, select(so_far), h, differentiate(p_, h, 0, base, train_), base).covariance;
  }
  StandFit fit = judge(h, evaluate(p_, h));
  long at = 0;
  for (const StandEffect& e : h) {
    Eigen::VectorXd std(static_cast<long>(e.p.size()));
    for (long i = 0; i < std.size(); ++i, ++at) {
      std(i) = e.id == StandId::kGroundFriction ? slip_spread_ / 3 : std::sqrt(std::max(0.0, covariance(at, at)));
    }
    fit.std.push_back(std);
  }
  return fit;
}

bool Search::is_significant(const StandFit& fit) const {
  const StandEffect& e = fit.hypothesis.back();
  const StandInfo& info = get_stand_info(e.id);
  for (size_t i = 0; i < e.p.size(); ++i) {
    const double std = fit.std.back()(static_cast<long>(i)), from = info.neutral[i % info.neutral.size()];
    if (std > 0 && find_prior(p_, e, i) == 0 && std::abs(e.p[i] - from) > kSignificant * std) return true;
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
  if (gain < std::max(kGain, 0.02 * out_.nominal.score)) return false;
  const StandFit finished = finish(best.fit, best.fit.hypothesis);
  if (!is_significant(finished)) return false;
  if (!out_.chosen.hypothesis.empty()) out_.rounds.push_back(trials);
  update_sigma(evaluate(p_, finished.hypothesis));
  out_.nominal = judge({}, evaluate(p_, {}));
  out_.chosen = finish(judge_again(finished), finished.hypothesis);
  return true;
}

StandFit Search::judge_again(const StandFit& fit) const {
  StandFit out = judge(fit.hypothesis, evaluate(p_, fit.hypothesis));
  out.std = fit.std;
  return out;
}

// Each effect against all others in its place, given the rest: what came first was chosen without knowing the second.
void Search::exchange_effects() {
  for (size_t i = 0; i + 1 < out_.chosen.hypothesis.size(); ++i) {
    StandHypothesis rest = out_.chosen.hypothesis;
    const StandEffect before = rest[i];
    rest.erase(rest.begin() + static_cast<long>(i));
    const StandHypothesis refitted = refine(p_, select(out_.chosen), rest, 2);
    const StandFit fit = judge(refitted, evaluate(p_, refitted));
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

// Parameters that define an effect; what else is fitted with it may be ill-determined in one recording.
bool is_main(StandId id, size_t parameter) {
  if (is_foot(id)) {
    const size_t at = parameter % get_stand_info(id).step.size();
    return at == 0 || at == 2;  // stiffness of roll and pitch
  }
  return parameter == 0 || id == StandId::kCogging || (!is_joint(id) && id != StandId::kPayload);
}

// Whether each recording alone asks for the same parameters: what is true is the same everywhere.
bool Search::is_consistent(size_t effect) const {
  const StandHypothesis& h = out_.chosen.hypothesis;
  size_t first = 0;
  for (size_t i = 0; i < effect; ++i) first += h[i].p.size();
  const Evaluation base = evaluate(p_, h);
  const std::vector<Derivative> columns = differentiate(p_, h, 0, base, all_);
  const StandInfo& info = get_stand_info(h[effect].id);
  FitSelection selection = select(out_.chosen);
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

// When not all is explained, an effect may be a stand-in for what is missing: named only if it is the same everywhere.
void Search::doubt() {
  for (size_t i = out_.chosen.hypothesis.size(); i-- > 0;) {
    if (is_consistent(i)) continue;
    out_.doubtful.push_back(out_.chosen.hypothesis[i]);
    out_.chosen.hypothesis.erase(out_.chosen.hypothesis.begin() + static_cast<long>(i));
    out_.rounds.erase(out_.rounds.begin() + static_cast<long>(i));
  }
  if (out_.doubtful.empty()) return;
  const StandFit fit = judge(out_.chosen.hypothesis, evaluate(p_, out_.chosen.hypothesis));
  out_.chosen = fit.hypothesis.empty() ? fit : finish(fit, refine(p_, select(fit), fit.hypothesis, 2));
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
