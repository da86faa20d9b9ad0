// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "common/base/format.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/search/additions.h"
#include "diagnosis/search/explore.h"
#include "diagnosis/search/outcome.h"
#include "diagnosis/search/significance.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kBeam = 4;            // sets that are grown further
constexpr size_t kLastBeam = 2;        // the same before the largest size, when wrong sets are far behind
constexpr size_t kCandidates = 10;     // effects that may be added to each set
constexpr size_t kSimulated = 3;       // sets of each size that are simulated
constexpr size_t kAsked = 3;           // effects by score test that are tried
constexpr size_t kScanned = 2;         // start values of a gap that are fitted, because of local minima
constexpr double kAlike = 1.5;         // ratio of costs that counts as similar
constexpr double kClearlyWorse = 4.0;  // ratio of costs: twice the error
constexpr double kQuiet = 1.5;         // rms in units of noise of a joint that needs no effect
constexpr double kQuietShare = 0.005;  // share of the residual above the noise
constexpr double kClosely = 0.6;       // share of the work for score tests
constexpr double kGrowing = 0.85;      // share of the work after which no larger sets start

// Counts work from zero; copies of the problem share the counter.
Problem count_work(Problem problem) {
  problem.options.work = std::make_shared<Work>(0);
  return problem;
}

class Search {
 public:
  Search(const Problem& problem, const Progress& progress)
      : e_(*problem.experiment),
        prepared_(count_work(problem)),
        progress_(progress),
        trials_(prepared_, progress),
        nominal_(trials_.nominal()) {}

  Outcome run() {
    Outcome outcome;
    outcome.nominal = outcome.chosen = nominal_;
    outcome.rivals = {nominal_};
    if (is_noise(nominal_)) return outcome;
    outcome.mismatch = true;
    look_wide();
    outcome.spent = is_spent();
    progress_(format("sets of effects took %.0f %% of the work allowed", 100.0 * calc_share()));
    try_special_cases();
    try_parts();
    choose_outcome({e_, prepared_, passed_over_, progress_}, &trials_, &outcome);
    return outcome;
  }

 private:
  double calc_share() const { return static_cast<double>(prepared_.options.work->load()) / prepared_.most_work; }
  bool is_spent(double share = 1.0) const { return calc_share() > share; }

  // Replaces effects of a good set by special cases, since a second cause may have been fitted by a richer law. Also
  // tries transmissions in place of a rotor, since the residual of a slightly elastic one may look like noise.
  void try_special_cases() {
    const Hypothesis best = trials_.best().hypothesis;
    // A weak effect leaves noise, which is more than a minor part of what was there.
    const bool minor = calc_cost(trials_.best()) <= kMinor * calc_cost(nominal_);
    if (!minor && !is_explained(trials_.best(), nominal_)) return;
    for (size_t i = 0; i < best.size(); ++i) {
      Hypothesis other = best;
      const SpecialCase simpler = find_special_case(best[i]);
      if (!simpler.p.empty()) other[i] = {simpler.id, best[i].place, simpler.p};
      if (!simpler.p.empty() && !trials_.has(other)) trials_.add(other);
      if (is_rigid_rotor(best[i])) try_transmissions(best, i);
    }
  }

  // Tries the set that explains without each of its effects, where that was not simulated. With the values of the whole
  // set, a part may explain alone what it could not from the start values of the screening.
  void try_parts() {
    const Trial best = trials_.best();
    for (size_t i = 0; i < best.hypothesis.size() && best.hypothesis.size() > 1 && is_explained(best, nominal_); ++i) {
      Hypothesis part = best.hypothesis;
      part.erase(part.begin() + static_cast<long>(i));
      if (!trials_.has(part)) trials_.add(part);
    }
  }

  SpecialCase find_special_case(const Effect& effect) const {
    const EffectInfo& info = get_effect(effect.id);
    if (!info.find_special_case) return {};
    const bool at_joint = effect.place.kind == PlaceKind::kJoint;
    const double speed = at_joint ? trials_.find_range(effect.place.index, &SmoothJoint::qd) : 0.0;
    const double mass = at_joint ? 0.0 : e_.robot.tree.links[static_cast<size_t>(effect.place.index)].inertia.mass;
    return info.find_special_case(effect.p.data(), speed, mass);
  }

  // Tries transmissions in place of a rotor if they were better along the paths.
  void try_transmissions(const Hypothesis& best, size_t rotor) {
    const auto find = [&](const EffectSet& set) {
      return std::find_if(passed_over_.begin(), passed_over_.end(),
                          [&](const Trial& t) { return make_set(t.hypothesis) == set; });
    };
    const auto rigid = find(make_set(best));
    for (const EffectInfo& row : list_effects()) {
      if (!row.flexible) continue;
      Hypothesis other = best;
      other[rotor].id = row.id;
      const auto known = find(make_set(other));
      const bool better = known != passed_over_.end() && rigid != passed_over_.end() && known->rms < rigid->rms;
      if (better && !trials_.has(other)) trials_.add(known->hypothesis);
    }
  }

  // Grows sets of one to three effects along recorded paths, and simulates the best ones of each size.
  void look_wide() {
    prepare_paths(&prepared_);
    Explorer explorer(prepared_);
    std::vector<Lead> beam{explorer.nominal()};
    progress_("along the recorded paths: " + format("nominal %.4g", scale(explorer.nominal().cost)));
    for (size_t size = 1; size <= kLargestSet && !is_spent(kGrowing); ++size) {
      const std::vector<Lead> parents = beam;
      const double before = calc_cost(trials_.best());
      beam = explorer.grow(parents, kCandidates, list_quiet(trials_.best()));
      drop_refused(&beam);
      if (beam.empty()) break;
      progress_(format("%.0f effects", static_cast<double>(size)));
      for (const Lead& lead : beam)
        progress_("    " + get_label(e_, lead.hypothesis) + ": " + format("%.4g", scale(lead.cost)));
      simulate_best(beam);
      // Errors of the recorded paths may exceed a small effect.
      if (size == 1 && calc_cost(trials_.best()) > kLargely * calc_cost(nominal_)) try_asked(nominal_);
      const bool grown = deepen();
      for (const Lead& lead : beam) passed_over_.push_back(make_trial(lead));
      if (is_finished(trials_.best())) break;
      if (grown && trials_.best().hypothesis.size() < kLargestSet)
        beam.insert(beam.begin(), explorer.make_lead(trials_.best().hypothesis));
      const bool idle = trials_.best().hypothesis.size() <= size && calc_cost(trials_.best()) > (1.0 - kMinor) * before;
      if (!helps(parents, beam) || (size > 1 && idle)) break;
      drop_refused(&beam);
      const size_t most = size + 1 < kLargestSet ? kBeam : kLastBeam;
      if (beam.size() > most) beam.resize(most);
    }
    if (!is_spent(kGrowing) && loosen()) deepen();
  }

  // Polishes the best set and adds effects by score tests. Returns true if it has grown.
  bool deepen() {
    bool grown = false;
    trials_.polish_best();
    while (look_closer()) {
      grown = true;
      trials_.polish_best();
    }
    exchange();
    return grown;
  }

  // By joint: true if the simulation leaves only noise in its readings. Along paths, recorded accelerations of other
  // joints may still cause errors there.
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

  // True if one more effect leaves less than kLargely of the residual of the best smaller sets.
  static bool helps(const std::vector<Lead>& parents, const std::vector<Lead>& leads) {
    std::map<size_t, double> least;  // by size
    for (const Lead& parent : parents) {
      double& cost = least.emplace(parent.hypothesis.size(), parent.cost).first->second;
      cost = std::min(cost, parent.cost);
    }
    return std::any_of(leads.begin(), leads.end(), [&](const Lead& lead) {
      const auto before = least.find(lead.hypothesis.size() - 1);
      return before != least.end() && lead.cost < kLargely * before->second;
    });
  }

  void drop_refused(std::vector<Lead>* leads) const {
    leads->erase(
        std::remove_if(leads->begin(), leads->end(), [&](const Lead& l) { return trials_.is_refused(l.hypothesis); }),
        leads->end());
  }

  // True if no larger sets are needed: only noise is left, or details that no effect reduces.
  bool is_finished(const Trial& t) const {
    return is_complete(t, nominal_) || (is_explained(t, nominal_) && content_.count(make_set(t.hypothesis)) > 0);
  }

  // Best sets of a size that the simulation cannot distinguish, the simplest first.
  std::vector<Trial> list_bases() const {
    const Trial& best = trials_.best();
    std::vector<Trial> bases;
    for (const Trial* t : trials_.sort()) {
      if (t->hypothesis.size() == best.hypothesis.size() && calc_cost(*t) < (1.0 + kKnown) * calc_cost(best))
        bases.push_back(*t);
    }
    std::stable_sort(bases.begin(), bases.end(), [](const Trial& a, const Trial& b) {
      return count_parameters(a.hypothesis) < count_parameters(b.hypothesis);
    });
    return bases;
  }

  // Tries the effects that the score test suggests for the best set. Returns true if a set with one more effect is
  // best.
  bool look_closer() {
    const size_t size = trials_.best().hypothesis.size();
    if (size == 0 || size >= kLargestSet || is_finished(trials_.best()) || is_spent(kClosely)) return false;
    const std::vector<Trial> bases = list_bases();
    const std::vector<Effect> asked = try_asked(bases[0]);
    if (asked.empty() && loosen()) return true;
    const bool helped = calc_cost(trials_.best()) < kLargely * calc_cost(bases[0]);
    // Other bases are tried only near the noise, where the true one can be distinguished.
    for (size_t i = 1; helped && i < bases.size() && is_near(trials_.best()); ++i) {
      if (is_explained(trials_.best(), nominal_)) break;
      try_with(bases[i], asked[0]);
    }
    const bool grown = trials_.best().hypothesis.size() > size;
    if (!grown && has_details(bases[0])) content_.insert(make_set(bases[0].hypothesis));
    return grown;
  }

  // If a rotor helps but leaves much, its transmission may be elastic or loose. A gap that is far from the true one
  // does not help along paths, and the score test does not suggest it. Therefore gaps are scanned in the whole
  // simulation. This is done beside the other effects of the set and without them, as they may be stand-ins. Returns
  // true if it helped.
  bool loosen() {
    const Trial best = trials_.best();
    if (is_near(best) || is_explained(best, nominal_)) return false;
    if (!loosened_.insert(make_set(best.hypothesis)).second) return false;
    for (size_t i = 0; i < best.hypothesis.size(); ++i) {
      const Effect& rotor = best.hypothesis[i];
      if (!is_rigid_rotor(rotor)) continue;
      if (best.hypothesis.size() < kLargestSet) loosen(best, i);
      if (best.hypothesis.size() > 1 && !is_near(trials_.best())) loosen(trials_.fit_aside({rotor}), 0);
    }
    return calc_cost(trials_.best()) < kLargely * calc_cost(best);
  }

  void loosen(const Trial& base, size_t at) {
    const Effect& rotor = base.hypothesis[at];
    for (const Effect& transmission : list_transmissions(rotor.place.index, get_rotor(rotor))) {
      const size_t count = list_infos(transmission.id)[0].walked ? kScanned : 1;
      for (const Effect& option : trials_.choose(base, at, list_options(transmission, false), count)) {
        if (is_spent() || is_near(trials_.best())) return;
        progress_("    loosened: " + get_label(e_, transmission));
        Hypothesis start = base.hypothesis;
        start[at] = option;
        trials_.add(start);
      }
    }
  }

  // Exchanges effects: the first one may stand in for two causes. Once these are found, another effect may fit better
  // in its place.
  void exchange() {
    while (exchange_one()) trials_.polish_best();
  }

  // Returns true if the best set improved with one effect exchanged.
  bool exchange_one() {
    const Trial best = trials_.best();
    if (best.hypothesis.size() < 2 || !is_near(best) || is_finished(best) || is_spent(kClosely)) return false;
    if (!exchanged_.insert(make_set(best.hypothesis)).second) return false;
    for (size_t i = 0; i + 1 < best.hypothesis.size(); ++i) {
      progress_("    without " + get_label(e_, best.hypothesis[i]));
      Hypothesis rest = best.hypothesis;
      rest.erase(rest.begin() + static_cast<long>(i));
      try_asked(trials_.fit_aside(rest));
      if (calc_cost(trials_.best()) < kLargely * calc_cost(best)) return true;
    }
    return false;
  }

  // True if the residual is so small that all effects but one may be right.
  bool is_near(const Trial& t) const { return calc_cost(t) < kTrace * calc_cost(nominal_); }

  bool try_with(const Trial& base, const Effect& added) {
    if (!can_add(base.hypothesis, added) || trials_.is_refused({added})) return false;
    Hypothesis more = base.hypothesis;
    more.push_back(added);
    if (make_set(more) == make_set(trials_.best().hypothesis)) return false;
    progress_("    asked for: " + get_label(e_, added));
    trials_.add(more);
    return true;
  }

  // True if the small residual may be details of a law of friction, memory or play.
  bool has_details(const Trial& t) const { return is_explained(t, nominal_) && !is_smooth(t.hypothesis); }

  // True if the added effect is at the joint of such a law, where it may only fit these details.
  bool fits_details(const Trial& base, const Effect& added) const {
    const int joint = find_joint(added);
    return joint >= 0 && has_details(base) &&
           std::any_of(base.hypothesis.begin(), base.hypothesis.end(),
                       [&](const Effect& e) { return find_joint(e) == joint && !is_smooth({e}); });
  }

  // Tries effects beside a set, by decreasing gain. Returns those that were tried.
  std::vector<Effect> try_asked(const Trial& base) {
    std::vector<Effect> asked;
    double least = kDetail * (calc_cost(base) - base.train.count - base.validate.count);
    for (const Addition& addition : rank_additions(trials_.take_up(base), base.full())) {
      if (addition.gain < least || asked.size() == kAsked || is_spent()) break;
      if (fits_details(base, addition.start) || !try_with(base, addition.start)) continue;
      asked.push_back(addition.start);
      const bool done = is_complete(trials_.best(), nominal_);
      least = std::max(least, (done ? kNearlyAll : kMuch) * addition.gain);
    }
    if (asked.empty()) content_.insert(make_set(base.hypothesis));
    return asked;
  }

  // Simulates the first sets. Once one leaves only noise, sets with more parameters are skipped, and those of as many
  // that are not similar along the paths. Errors of the recorded paths may order similar ones wrongly: only the
  // simulation tells them apart.
  void simulate_best(std::vector<Lead> beam) {
    // Among similar sets along the paths, the simple ones first: a richer one may only contain a simple one.
    const double alike = kAlike * beam.front().cost;
    const auto rich = std::find_if(beam.begin(), beam.end(), [&](const Lead& lead) { return lead.cost > alike; });
    const double best_cost = beam.front().cost;
    std::stable_sort(beam.begin(), rich, [](const Lead& a, const Lead& b) {
      return count_parameters(a.hypothesis) < count_parameters(b.hypothesis);
    });
    // The best set is always tried, because all may be similar far above the noise.
    const auto best_of_all =
        std::find_if(beam.begin(), beam.end(), [&](const Lead& lead) { return lead.cost == best_cost; });
    if (best_of_all - beam.begin() >= static_cast<long>(kSimulated))
      std::rotate(beam.begin() + kSimulated - 1, best_of_all, best_of_all + 1);
    for (size_t i = 0; i < beam.size(); ++i) {
      const Trial& best = trials_.best();
      const bool done = !best.hypothesis.empty() && is_noise(best);
      if (i > 1 && is_spent()) break;
      if (!done && i >= kSimulated) break;  // a simpler set may explain as much
      if (beam[i].cost > (done ? kClearlyWorse : 30.0) * best_cost) break;
      const size_t more = count_parameters(beam[i].hypothesis), least = count_parameters(best.hypothesis);
      if (done && (more > least || (more == least && beam[i].cost > alike))) continue;
      trials_.add(beam[i].hypothesis);
    }
  }

  // Trial for the list of rivals: held-out residual along recorded paths.
  Trial make_trial(const Lead& lead) const {
    Trial trial;
    trial.hypothesis = lead.hypothesis;
    double held = 0.0, worst = 0.0;
    for (double chi2 : lead.held) {
      held += chi2;
      worst = std::max(worst, chi2);
    }
    const double count = std::max(1.0, nominal_.validate.count);
    trial.rms = std::sqrt(held / count);
    trial.worst = std::sqrt(worst / count * static_cast<double>(lead.held.size()));
    return trial;
  }

  // Converts a cost to an rms in units of noise.
  double scale(double cost) const {
    return std::sqrt(cost / std::max(1.0, nominal_.train.count + nominal_.validate.count));
  }

  const Experiment& e_;
  Problem prepared_;  // with nominal paths and a counter of work
  Progress progress_;
  Trials trials_;
  const Trial& nominal_;
  std::set<EffectSet> content_;     // sets that no addition improves
  std::set<EffectSet> loosened_;    // sets whose rotors were tried behind transmissions
  std::set<EffectSet> exchanged_;   // sets whose effects were exchanged already
  std::vector<Trial> passed_over_;  // judged along recorded paths only
};

}  // namespace

Outcome search(const Problem& problem, const Progress& progress) { return Search(problem, progress).run(); }

}  // namespace hrp::diagnosis
