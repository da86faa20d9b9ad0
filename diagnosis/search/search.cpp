// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <set>

#include "diagnosis/drive/search.h"
#include "diagnosis/search/additions.h"
#include "diagnosis/search/explore.h"
#include "diagnosis/search/significance.h"
#include "diagnosis/simulation/presliding.h"
#include "diagnosis/simulation/start_state.h"
#include "diagnosis/simulation/step_error.h"

namespace hrp::diagnosis {
namespace {

std::string format(const char* pattern, double a, double b = 0.0, double c = 0.0) {
  char text[120];
  std::snprintf(text, sizeof text, pattern, a, b, c);
  return text;
}

using Key = std::vector<std::pair<int, int>>;

Key make_key(const Hypothesis& hypothesis) {
  Key key;
  for (const Effect& effect : hypothesis) key.push_back({static_cast<int>(effect.id), effect.place});
  std::sort(key.begin(), key.end());
  return key;
}

// [kg m^2] what is left of a transmission that does not give; 0 for other effects.
double get_rotor(const Effect& effect) {
  if (effect.id == EffectId::kElasticity) return effect.p[2];
  return effect.id == EffectId::kBacklash ? effect.p[3] : 0.0;
}

constexpr size_t kLargestSet = 3;
constexpr size_t kBeam = 4;          // sets that are grown further
constexpr size_t kLastBeam = 2;      // the same, to the largest: sets that are wrong have grown far apart by then
constexpr size_t kCandidates = 10;   // effects that may be added to each
constexpr size_t kSimulated = 3;     // sets of each size that are fitted through the simulation
constexpr size_t kAsked = 3;         // effects that what is left asks for, that are tried
constexpr double kAskedShare = 0.1;  // of what is left above the noise, that is worth asking for
constexpr double kAskedAlike = 0.3;  // of the best one's gain: such may be the right one
constexpr double kAskedTwin = 0.9;   // the same once it has left noise only
constexpr double kAlike = 1.5;       // in cost
constexpr double kDrivesWorse = 1.2;
constexpr double kTwin = 1.02;          // in cost: no difference that paths can tell
constexpr double kClearlyWorse = 4.0;   // in cost: twice the error
constexpr double kLeastSpread = 1e-3;   // of a value
constexpr double kRough = 20.0;         // noise deviations that steps are never to blame for
constexpr int kFiner = 4, kFinest = 8;  // steps for one
constexpr int kRounds = 2;              // of start states and parameters
constexpr double kNear = 2.0;           // noise deviations, of a set that is worth polishing before it is grown
constexpr double kQuiet = 1.5;          // noise deviations: what a joint feels of others that are not explained yet
constexpr double kQuietShare = 0.005;   // of what is left above the noise
constexpr double kWeak = 0.05;          // of friction: such a part may be no part
constexpr double kFar = 10.0;           // the same, of one that no polishing will bring to it
constexpr double kLeastGain = 0.95;     // in cost, of the sets of two that are simulated
constexpr double kLeastDrop = 0.7;      // of what is left, or adding effects is given up

class Search {
 public:
  Search(const Problem& problem, const Progress& progress)
      : problem_(problem),
        e_(*problem.experiment),
        progress_(progress),
        held_out_(problem.validate.empty() ? problem.train : problem.validate) {
    for (size_t r = 0; r < e_.recordings.size(); ++r) all_.push_back(static_cast<int>(r));
  }

  Outcome run() {
    Outcome outcome;
    outcome.nominal = judge({}, refine({}));
    say("nominal", outcome.nominal);
    nominal_ = outcome.nominal;
    if (is_noise(outcome.nominal)) {
      outcome.chosen = outcome.nominal;
      outcome.rivals = {outcome.nominal};
      return outcome;
    }
    outcome.mismatch = true;
    trials_[{}] = outcome.nominal;
    best_chi2_ = outcome.nominal.train.chi2;
    look_wide();
    try_special_cases();
    decide(&outcome);
    if (!outcome.explained && find_drives(&outcome)) return outcome;
    finish(&outcome.chosen);
    drop_insignificant(&outcome);
    outcome.explained = is_explained(outcome.chosen, nominal_);
    widen(&outcome.chosen);
    normalise(&outcome.chosen.hypothesis);
    return outcome;
  }

 private:
  void say(const std::string& what, const Trial& t) const {
    progress_(what + ": train " + format("%.4g, held out %.4g, worst signal %.4g", t.train.rms(), t.rms, t.worst));
  }

  FitResult refine(const Hypothesis& hypothesis) {
    Hypothesis start = hypothesis;
    start.push_back({EffectId::kTiming, 0, {0.0, 0.0}});
    FitOptions options;
    options.max_iterations = 15;
    options.abandon_above = 25.0 * best_chi2_;
    problem_.starts = estimate_starts(problem_, start, all_);
    problem_.step_errors.clear();
    const FitResult rough = fit(problem_, start, problem_.train, options);
    if (!rough.ok || (!hypothesis.empty() && rough.train.rms() > kRough)) return rough;
    // What stands beside friction now may have been part of how it seemed to bend.
    const Hypothesis bent = choose_presliding(problem_, rough.hypothesis);
    problem_.step_errors = estimate_step_errors(problem_, bent, all_, kFiner);
    const FitResult fine = fit(problem_, bent, problem_.train, options);
    return fine.ok ? fine : rough;
  }

  // A curve of friction with next to no dry part is viscous friction, one that hardly falls is Coulomb's: a set may
  // have got there because another cause stood in for the rest when its first effect was chosen.
  void try_special_cases() {
    const Hypothesis best = best_refined().hypothesis;
    for (size_t i = 0; i < best.size(); ++i) {
      if (best[i].id != EffectId::kStribeck) continue;
      const double coulomb = best[i].p[0], at_rest = best[i].p[1];
      const double viscous = best[i].p[3] * find_range(best[i].place, &SmoothJoint::qd);
      Hypothesis simple = best;
      if (at_rest < kWeak * viscous)
        simple[i] = {EffectId::kViscous, best[i].place, {best[i].p[3]}};
      else if (at_rest - coulomb < kWeak * at_rest && viscous < kWeak * at_rest)
        simple[i] = {EffectId::kCoulomb, best[i].place, {at_rest, 0.0, best[i].p[4]}};
      else
        continue;
      if (!trials_.count(make_key(simple))) try_fit(simple);
    }
  }

  // Between the largest and the least value of a joint's motion in the recordings that are fitted.
  double find_range(int joint, std::vector<double> SmoothJoint::*series) const {
    double low = 1e300, high = -1e300;
    for (int r : problem_.train) {
      const std::vector<double>& x = problem_.smooth[static_cast<size_t>(r)].joints[static_cast<size_t>(joint)].*series;
      low = std::min(low, *std::min_element(x.begin(), x.end()));
      high = std::max(high, *std::max_element(x.begin(), x.end()));
    }
    return high - low;
  }

  // Less than two ripples over the whole motion are any smooth function of position, not cogging.
  bool ripples(const Effect& effect) const {
    if (effect.id != EffectId::kCogging) return true;
    return effect.p[1] * find_range(effect.place, &SmoothJoint::q) > 4.0 * M_PI;
  }

  bool is_refused(const Hypothesis& hypothesis) const {
    return std::any_of(hypothesis.begin(), hypothesis.end(), [&](const Effect& e) {
      return refused_.count({static_cast<int>(e.id), e.place}) > 0;
    });
  }

  // A fit that turned one of its effects into something else; no set with that one is tried again.
  bool refuse(const FitResult& result) {
    for (const Effect& effect : result.hypothesis) {
      if (result.ok && !ripples(effect)) refused_.insert({static_cast<int>(effect.id), effect.place});
    }
    return is_refused(result.hypothesis);
  }

  Trial judge(const Hypothesis& hypothesis, const FitResult& result) const {
    Trial trial;
    trial.hypothesis = hypothesis;
    if (!result.ok) return trial;
    trial.hypothesis = result.hypothesis;
    if (!trial.hypothesis.empty() && trial.hypothesis.back().id == EffectId::kTiming) {
      trial.timing = {trial.hypothesis.back()};
      trial.hypothesis.pop_back();
      trial.refined = true;
    }
    trial.train = result.train;
    trial.starts = problem_.starts, trial.step_errors = problem_.step_errors;
    trial.validate = calc_score(problem_, trial.full(), held_out_);
    if (!trial.validate.ok) return trial;
    trial.rms = trial.validate.rms();
    trial.worst = trial.validate.worst();
    return trial;
  }

  // Drives of real robots; nothing is named when a few effects of the list left much less, though not noise only.
  bool find_drives(Outcome* outcome) {
    Outcome drives = *outcome;
    const double least = best_refined().rms;
    if (!search_drives(prepared_, progress_, &drives)) return false;
    // With nothing certain in it, it is shown for its prediction alone.
    if (drives.chosen.rms <= (drives.partly ? kDrivesWorse : 1.0) * least) {
      *outcome = drives;
      return true;
    }
    // Shown, not named: nothing in it was checked for being the same everywhere.
    const std::string doubt = "part of the set that predicts best, which leaves more than noise";
    outcome->chosen = best_refined();
    outcome->modelled = true;
    outcome->worth.assign(outcome->chosen.hypothesis.size(), 0.0);
    outcome->doubts.assign(outcome->chosen.hypothesis.size(), doubt);
    return true;
  }

  // Sets of one, two, three effects along the recorded paths; the best of each size go through the simulation.
  void look_wide() {
    prepared_ = problem_;
    prepared_.starts.clear(), prepared_.step_errors.clear();  // those of the nominal model
    prepare_paths(&prepared_);
    Explorer explorer(prepared_);
    std::vector<Lead> beam{explorer.nominal()};
    progress_("along the recorded paths: " + format("nominal %.4g", scale(explorer.nominal().cost)));
    for (size_t size = 1; size <= kLargestSet; ++size) {
      const std::vector<Lead> parents = beam;
      const double before = calc_cost(best_refined());
      beam = explorer.grow(parents, kCandidates, list_quiet(best_refined()));
      drop_refused(&beam);
      if (beam.empty()) break;
      progress_(format("%.0f effects", static_cast<double>(size)));
      for (const Lead& lead : beam)
        progress_("    " + get_label(e_, lead.hypothesis) + ": " + format("%.4g", scale(lead.cost)));
      simulate_best(beam);
      // What paths miss by themselves may be more than a small effect.
      if (size == 1 && calc_cost(best_refined()) > kLeastDrop * calc_cost(nominal_)) try_asked(nominal_);
      polish_best();
      bool grown = false;
      while (look_closer()) grown = true, polish_best();
      for (const Lead& lead : beam) passed_over_.push_back(make_trial(lead));
      if (is_finished(best_refined())) break;
      if (grown && best_refined().hypothesis.size() < kLargestSet)
        beam.insert(beam.begin(), explorer.make_lead(best_refined().hypothesis));
      if (!helps(parents, beam) || (size > 1 && calc_cost(best_refined()) > kLeastGain * before)) break;
      drop_refused(&beam);
      const size_t most = size + 1 < kLargestSet ? kBeam : kLastBeam;
      if (beam.size() > most) beam.resize(most);
    }
  }

  // By joint: whether the simulation leaves nothing but noise of its readings. Along the paths such a joint may still
  // be missed: its motion is driven by recorded accelerations of others.
  std::vector<char> list_quiet(const Trial& t) const {
    std::vector<double> excess(static_cast<size_t>(e_.num_joints()), 0.0);
    std::vector<char> quiet(excess.size(), 1);
    for (const Score* score : {&t.train, &t.validate}) {
      for (size_t c = 0; c < score->signal_chi2.size(); ++c) {
        excess[c / kQuantities] += std::max(0.0, score->signal_chi2[c] - score->signal_count[c]);
        quiet[c / kQuantities] = quiet[c / kQuantities] && score->ok && score->rms(c) < kQuiet;
      }
    }
    const double most = kQuietShare * std::accumulate(excess.begin(), excess.end(), 0.0);
    for (size_t j = 0; j < quiet.size(); ++j) quiet[j] = quiet[j] && excess[j] <= most;
    return quiet;
  }

  // Whether one effect more takes its share of what the best sets that have one less leave.
  static bool helps(const std::vector<Lead>& parents, const std::vector<Lead>& leads) {
    std::map<size_t, double> least;  // by size
    for (const Lead& parent : parents) {
      double& cost = least.emplace(parent.hypothesis.size(), parent.cost).first->second;
      cost = std::min(cost, parent.cost);
    }
    return std::any_of(leads.begin(), leads.end(), [&](const Lead& lead) {
      const auto before = least.find(lead.hypothesis.size() - 1);
      return before != least.end() && lead.cost < kLeastDrop * before->second;
    });
  }

  void drop_refused(std::vector<Lead>* leads) const {
    leads->erase(std::remove_if(leads->begin(), leads->end(), [&](const Lead& l) { return is_refused(l.hypothesis); }),
                 leads->end());
  }

  // Larger sets are not looked for: noise is left, or details of which no effect would take a share.
  bool is_finished(const Trial& t) const {
    return is_complete(t, nominal_) || (is_explained(t, nominal_) && content_.count(make_key(t.hypothesis)) > 0);
  }

  // The best sets of a size that the simulation cannot tell apart, the simplest first.
  std::vector<Trial> list_bases() const {
    const Trial& best = best_refined();
    std::vector<Trial> bases;
    for (const Trial* t : sort_refined()) {
      if (t->hypothesis.size() == best.hypothesis.size() && calc_cost(*t) < kTwin * calc_cost(best))
        bases.push_back(*t);
    }
    std::stable_sort(bases.begin(), bases.end(), [](const Trial& a, const Trial& b) {
      return count_parameters(a.hypothesis) < count_parameters(b.hypothesis);
    });
    return bases;
  }

  // Tries what the best set leaves in the simulation asks for. Whether a set with one effect more came out best.
  bool look_closer() {
    const size_t size = best_refined().hypothesis.size();
    if (size == 0 || size >= kLargestSet || is_finished(best_refined())) return false;
    const std::vector<Trial> bases = list_bases();
    const std::vector<Effect> asked = try_asked(bases[0]);
    const bool helped = calc_cost(best_refined()) < kLeastDrop * calc_cost(bases[0]);
    for (size_t i = 1; helped && i < bases.size(); ++i) {
      if (is_explained(best_refined(), nominal_)) break;
      try_with(bases[i], asked[0]);
    }
    return best_refined().hypothesis.size() > size;
  }

  bool try_with(const Trial& base, const Effect& added) {
    if (!can_add(base.hypothesis, added) || is_refused({added})) return false;
    Hypothesis more = base.hypothesis;
    more.push_back(added);
    progress_("    asked for: " + get_label(e_, added));
    try_fit(more);
    return true;
  }

  // The effects that were tried beside a set, those that promise most first.
  std::vector<Effect> try_asked(const Trial& base) {
    std::vector<Effect> asked;
    problem_.starts = base.starts, problem_.step_errors = base.step_errors;
    double least = kAskedShare * (calc_cost(base) - base.train.count - base.validate.count);
    for (const Addition& addition : rank_additions(problem_, base.full())) {
      if (addition.gain < least || asked.size() == kAsked) break;
      if (!try_with(base, addition.start)) continue;
      asked.push_back(addition.start);
      const bool done = is_complete(best_refined(), nominal_);
      least = std::max(least, (done ? kAskedTwin : kAskedAlike) * addition.gain);
    }
    if (asked.empty()) content_.insert(make_key(base.hypothesis));
    return asked;
  }

  // Fits the first of the sets through the simulation. Once one leaves noise only, no set that has more parameters or
  // did clearly worse along the paths can take its place.
  void simulate_best(std::vector<Lead> beam) {
    // Of those that do about as well along the paths, the simple ones first: a richer one may only contain them.
    const double alike = kAlike * beam.front().cost;
    const auto rich = std::find_if(beam.begin(), beam.end(), [&](const Lead& lead) { return lead.cost > alike; });
    const double best_cost = beam.front().cost;
    std::stable_sort(beam.begin(), rich, [](const Lead& a, const Lead& b) {
      return count_parameters(a.hypothesis) < count_parameters(b.hypothesis);
    });
    for (size_t i = 0; i < beam.size(); ++i) {
      const Trial& best = best_refined();
      const bool done = !best.hypothesis.empty() && is_noise(best);
      if (!done && i >= kSimulated) break;  // a simpler one may explain as much as one that leaves noise only
      if (beam[i].cost > (done ? kClearlyWorse : 30.0) * best_cost) break;
      const size_t more = count_parameters(beam[i].hypothesis), least = count_parameters(best.hypothesis);
      if (done && (more > least || (more == least && beam[i].cost > kTwin * best_cost))) continue;
      try_fit(beam[i].hypothesis);
    }
  }

  // For the list of rivals: what a set leaves of the held-out recordings along the recorded paths.
  Trial make_trial(const Lead& lead) const {
    Trial trial;
    trial.hypothesis = lead.hypothesis;
    double held = 0.0, worst = 0.0;
    for (double chi2 : lead.held) held += chi2, worst = std::max(worst, chi2);
    const double count = std::max(1.0, nominal_.validate.count);
    trial.rms = std::sqrt(held / count);
    trial.worst = std::sqrt(worst / count * static_cast<double>(lead.held.size()));
    return trial;
  }

  // In units of noise, as rms.
  double scale(double cost) const {
    return std::sqrt(cost / std::max(1.0, nominal_.train.count + nominal_.validate.count));
  }

  void try_fit(const Hypothesis& start) {
    if (is_refused(start)) return;
    const FitResult result = refine(start);
    if (refuse(result)) return progress_("  * " + get_label(e_, start) + ": too few ripples for cogging");
    Trial trial = judge(start, result);
    if (trial.refined) best_chi2_ = std::min(best_chi2_, trial.train.chi2);
    say("  * " + get_label(e_, start), trial);
    trials_[make_key(start)] = trial;
  }

  // Those fitted through the simulation, best first.
  std::vector<const Trial*> sort_refined() const {
    std::vector<const Trial*> list;
    for (const auto& item : trials_) {
      if (item.second.refined) list.push_back(&item.second);
    }
    std::stable_sort(list.begin(), list.end(), [](const Trial* a, const Trial* b) {
      return a->train.ok && b->train.ok ? calc_cost(*a) < calc_cost(*b) : a->train.ok;
    });
    return list;
  }

  const Trial& best_refined() const {
    const std::vector<const Trial*> list = sort_refined();
    return list.empty() ? nominal_ : *list.front();
  }

  // A set that is right may be kept from the noise by its start states and pre-sliding displacements alone; to try
  // larger sets would cost ten times as much.
  void polish_best() {
    const Trial& best = best_refined();
    const bool near = best.rms < kNear || is_detail(best, nominal_);
    if (best.hypothesis.empty() || is_explained(best, nominal_) || !near) return;
    polish(&trials_.at(make_key(best.hypothesis)));
  }

  // One that is far from the noise would not come near: it is not named, and only its intervals are wanted.
  void finish(Trial* trial) {
    if (trial->hypothesis.empty() || !trial->refined || !trial->std.empty()) return;
    if (trial->rms < kFar || is_detail(*trial, nominal_)) polish(trial);
    if (trial->std.empty()) add_intervals(trial);
  }

  // Of a trial as it is.
  void add_intervals(Trial* trial) {
    problem_.starts = trial->starts, problem_.step_errors = trial->step_errors;
    FitOptions options;
    options.max_iterations = 0;
    options.intervals = true;
    const FitResult result = fit(problem_, trial->full(), problem_.train, options);
    trial->std = result.std, trial->distance = result.distance;
  }

  // Start states and parameters in turn until neither gains, with the pre-sliding displacements that suit best; then
  // the intervals.
  void polish(Trial* trial) {
    FitOptions options;
    options.max_iterations = 8;
    options.tolerance = 1e-7;
    FitResult result;
    result.hypothesis = trial->full();
    for (int round = 0; round < kRounds; ++round) {
      problem_.starts = estimate_starts(problem_, result.hypothesis, all_);
      problem_.step_errors.clear();
      const Hypothesis start = choose_presliding(problem_, result.hypothesis);
      problem_.step_errors = estimate_step_errors(problem_, start, all_, kFinest);
      options.intervals = round + 1 == kRounds;
      result = fit(problem_, start, problem_.train, options);
      if (!result.ok) return;
    }
    Trial better = judge(trial->hypothesis, result);
    if (better.rms > 1.02 * trial->rms) return;
    say("  finished: " + get_label(e_, trial->hypothesis), better);
    better.std = result.std, better.distance = result.distance;
    better.probability = trial->probability;
    *trial = better;
  }

  // What is left above the noise is no chance: in every stretch it could lie along a parameter and shift it. And no
  // interval is narrower than what two integrators and two writers of a law's details agree to.
  void widen(Trial* trial) const {
    const double above = std::max(0.0, 1.0 - trial->train.count / std::max(1.0, trial->train.chi2));
    const double shift =
        above * trial->train.count / static_cast<double>(kIndependent * std::max<size_t>(1, problem_.train.size()));
    for (size_t i = 0; i < std::min(trial->std.size(), trial->hypothesis.size()); ++i) {
      for (size_t k = 0; k < trial->hypothesis[i].p.size(); ++k) {
        double& spread = trial->std[i][k];
        spread = std::hypot(spread * std::sqrt(1.0 + shift), kLeastSpread * trial->hypothesis[i].p[k]);
      }
    }
  }

  // The best of the others, when the chosen one cannot be told from nothing.
  void take_next(Outcome* outcome) {
    const Key worthless = make_key(outcome->chosen.hypothesis);
    outcome->chosen = nominal_, outcome->explained = false;
    for (const Trial* t : sort_refined()) {
      if (t->hypothesis.empty() || make_key(t->hypothesis) == worthless || !is_explained(*t, nominal_)) continue;
      outcome->chosen = *t, outcome->explained = true;
      outcome->chosen.probability = 0.5;  // it did worse than what was thrown out
      finish(&outcome->chosen);
      return;
    }
  }

  // A second effect that cannot be told from nothing only stands in for the first one's details.
  void drop_insignificant(Outcome* outcome) {
    Trial& chosen = outcome->chosen;
    if (chosen.hypothesis.empty() || chosen.std.size() < chosen.hypothesis.size()) return;
    Hypothesis kept;
    bool changed = false;
    for (size_t i = 0; i < chosen.hypothesis.size(); ++i) {
      const Effect& effect = chosen.hypothesis[i];
      const bool significant = is_significant(effect, chosen.std[i], chosen.distance[i]);
      changed = changed || !significant;
      if (significant)
        kept.push_back(effect);
      else if (get_rotor(effect) > 0.0)
        kept.push_back({EffectId::kRotorInertia, effect.place, {get_rotor(effect)}});
    }
    if (!changed) return;
    if (kept.empty()) return take_next(outcome);
    Trial trial = judge(kept, refine(kept));
    say("  without what is no more than nothing: " + get_label(e_, kept), trial);
    // Without it the rest may be above the noise by the details of laws: then nothing is named.
    trial.probability = chosen.probability;
    finish(&trial);
    outcome->rivals.insert(outcome->rivals.begin(), trial);
    chosen = trial;
    outcome->explained = is_explained(chosen, nominal_);
  }

  // The simplest of those that cannot be told from the best by the recordings they were not fitted to.
  void decide(Outcome* outcome) {
    std::vector<Trial> list;
    for (const Trial* t : sort_refined()) list.push_back(*t);
    if (list.empty()) list.push_back(nominal_);
    sort_by_preference(nominal_, &list);
    outcome->chosen = list.front();
    outcome->rivals = list;
    for (const Trial& t : passed_over_) {
      if (!trials_.count(make_key(t.hypothesis)) && outcome->rivals.size() < 14) outcome->rivals.push_back(t);
    }
    outcome->explained = is_explained(outcome->chosen, nominal_);
    for (size_t i = 1; i < list.size(); ++i) {
      if (list[i].probability > 0.1) outcome->twins.push_back(list[i].hypothesis);
    }
  }

  Problem problem_;   // with the start states of the trial at work
  Problem prepared_;  // with nominal paths
  const Experiment& e_;
  Progress progress_;
  std::vector<int> all_, held_out_;
  Trial nominal_;
  std::map<Key, Trial> trials_;
  std::set<Key> content_;                  // sets whose rest asks for nothing
  std::set<std::pair<int, int>> refused_;  // effects and places
  std::vector<Trial> passed_over_;         // judged along the recorded paths only
  double best_chi2_ = 1e300;
};

}  // namespace

Outcome search(const Problem& problem, const Progress& progress) { return Search(problem, progress).run(); }

}  // namespace hrp::diagnosis
