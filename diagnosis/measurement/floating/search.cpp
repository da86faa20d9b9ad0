// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "diagnosis/estimate/robust.h"
#include "diagnosis/measurement/floating/candidate_laws.h"
#include "diagnosis/measurement/floating/regimes.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kMost = 24;          // effects
constexpr double kGain = 30;          // n log that one effect of one coefficient must win on all rows: chance among
                                      // hundreds wins 12 on those that are fitted
constexpr double kTrainGain = 3;      // on rows that were fitted
constexpr double kPerCoefficient = 4; // more for each further one
constexpr double kHeldGain = 4;       // on rows that were not fitted
constexpr double kStay = 0.6;         // of these that an effect must keep when weights have settled
constexpr double kShare = 0.1;        // of an equation's mismatch (mean square) that must go
constexpr int kSettle = 4;              // rounds of weights
constexpr double kDeviations = 2.5;   // of the robust error over all rows: the held-out gain has to say the rest
constexpr double kSure = 2.0;         // standard errors, with what recordings differ by
constexpr double kHalf = 0.5;         // of an equation's mismatch: what leaves more and takes less may stand in for another cause
constexpr double kStandsOut = 3;      // times noise and exactness: of a force that is left
constexpr double kRival = 0.1;        // share of the gain by which a rival may stay behind
constexpr double kStrong = 3;         // times the gain of what was chosen
constexpr long kPlaces = 6;           // of one effect that are listed beside what was chosen
constexpr double kAlike = 0.8;        // share of what one law predicts that another predicts, too: their details do not tell them apart
constexpr double kRivalLeast = 8;     // n log, the same for small gains
constexpr double kConfirmed = 0.25;   // deviation of a size of one: then it is neither none nor twice as large by chance

class Searcher {
 public:
  Searcher(LeggedFitter* fitter, const std::vector<Candidate>& candidates, const ColumnLayout& layout, double reach, const Say& say)
      : fitter_(*fitter), candidates_(candidates), layout_(layout), reach_(reach), say_(say) {}

  LeggedOutcome run() {
    search();
    // What accelerates most in impacts, as a knee's rotor does, may show nowhere else.
    if (chosen_.effects.empty()) {
      fitter_.count_impacts(true);
      settle({});
      search();
    }
    if (chosen_.effects.empty()) {
      fitter_.count_impacts(false);
      settle({});
    }
    out_.chosen = chosen_;
    return std::move(out_);
  }

 private:
  struct Trial {
    LeggedFit fit;
    double gain = 0, held = 0;
  };

  void search() {
    out_.nominal = fitter_.fit({});
    chosen_ = out_.nominal;
    search_listed();
    do {
      search_unlisted();
      out_.effects.clear();
      describe();
    } while (drop_unsure() || drop_partial() || drop_known() || drop_forced());
  }

  void search_listed() {
    do {
      while (chosen_.effects.size() < kMost && add()) {
      }
      prune();
      exchange();
      merge();
      prune();
    } while (drop_unsteady());
  }

  // Free laws in the place of each effect, then beside all of them. They can fit a little of everything, so they come last,
  // and in the place of an effect one must win by the margin that makes effects rivals. They are rough, so that no effect is
  // sought in what they leave.
  void search_unlisted() {
    unlisted_ = true;
    bool any = exchange();
    any = (chosen_.effects.size() < kMost && add_best(try_all(chosen_), kShare)) || any;
    unlisted_ = false;
    if (any) prune();
  }

  static EffectFamily get_family(const Candidate& c) { return get_effect(c.effect).family; }
  static std::string tell(const Candidate& c) { return (c.is_listed() ? get_effect(c.effect).name : c.law->unlisted) + " at " + c.where.dump(); }

  static bool is_same(const Candidate& a, const Candidate& b) { return a.effect == b.effect && a.law->unlisted == b.law->unlisted && a.where == b.where; }

  // Two laws of one kind in a place (a wrong mass and a load) share what one would explain.
  static bool is_same_kind(const Candidate& a, const Candidate& b) {
    return a.is_listed() && b.is_listed() && a.where == b.where && a.place == b.place && get_family(a) == get_family(b);
  }

  // Fits effects. Loads and masses that lie elsewhere have their inertia found along with their place.
  LeggedFit fit(std::vector<Candidate> effects) const {
    LeggedFit out = fitter_.fit(effects);
    for (int round = 0; round < 4; ++round) {
      bool any = false;
      for (size_t i = 0; i < effects.size(); ++i) any = place_mass(out.get(i), &effects[i]) || any;
      if (!any) break;
      out = fitter_.fit(effects);
    }
    return out;
  }

  // False: the effect has no place, or none that can be.
  bool place_mass(const Eigen::VectorXd& x, Candidate* effect) const {
    return effect->law->refine && effect->law->refine(layout_, x, reach_, effect);
  }

  bool are_sensible(const LeggedFit& f) const {
    for (size_t i = 0; i < f.effects.size(); ++i) {
      if (!is_sensible(f.effects[i], f.get(i), reach_)) return false;
    }
    return true;
  }

  static double calc_cost(const Candidate& c) { return kGain + kPerCoefficient * static_cast<double>(c.terms.size() - 1); }

  // The equation that a step helps most, by held-out rows.
  size_t find_main_channel(const LeggedFit& without, const LeggedFit& with) const {
    size_t best = 0;
    double most = -1e300;
    for (size_t c = 0; c < fitter_.channels().size(); ++c) {
      const double gain = fitter_.calc_gain(Part::kHeld, c, without, with) + fitter_.calc_gain(Part::kTrain, c, without, with);
      if (gain > most) most = gain, best = c;
    }
    return best;
  }

  double calc_share(const LeggedFit& without, const LeggedFit& with, size_t c) const {
    const double before = out_.nominal.signed_square[1][c] - std::min(0.0, with.signed_square[1][c]);
    return before > 0 ? (without.signed_square[1][c] - with.signed_square[1][c]) / before : 0;
  }

  // What it takes away is large enough beside the equation's spread.
  bool is_worth(const LeggedFit& without, const LeggedFit& with, size_t c) const {
    const double worth = with.effects.back().worth;
    if (worth <= 0) return true;
    const double gone = without.mean_square[1][c] - with.mean_square[1][c];
    return std::sqrt(std::max(0.0, gone)) > worth * fitter_.channels()[c].scale;
  }

  // Whether all recordings together, those that were not fitted too, could have shown it by chance.
  bool is_significant(const LeggedFit& f, size_t effect) const {
    const Eigen::MatrixXd all = fitter_.calc_covariance(f, true);
    const auto first = static_cast<long>(f.find_first(effect)), n = static_cast<long>(f.effects[effect].terms.size());
    const Eigen::VectorXd x = f.get(effect);
    const Candidate& c = f.effects[effect];
    if ((c.vector ? x.norm() : std::abs(x(0))) < c.least) return false;
    if (!c.vector) return std::abs(x(0)) > kDeviations * std::sqrt(std::max(0.0, all(first, first)));
    const Eigen::MatrixXd own = all.block(first, first, n, n);
    return std::sqrt(std::max(0.0, x.dot(own.ldlt().solve(x)))) > kDeviations + 1;
  }

  // A free law without the terms whose columns are noise alone: a robot that never goes aside shows no change of a force
  // with that place.
  Candidate keep_told(Candidate c) const {
    const std::vector<Terms> all = c.terms;
    std::vector<Terms> told;
    for (const Terms& t : all) {
      c.terms = {t};
      if (fitter_.fit({c}).x.allFinite()) told.push_back(t);
    }
    c.terms = told.empty() ? all : told;
    return c;
  }

  // Each candidate beside what a fit has, as far as its values can be.
  std::vector<Trial> try_each(const LeggedFit& base) const {
    std::vector<Trial> out;
    for (const Candidate& c : candidates_) {
      const bool there = std::any_of(base.effects.begin(), base.effects.end(), [&](const Candidate& e) {
        return is_same(e, c) || is_same_kind(e, c);
      });
      if (there || is_banned(c) || c.is_listed() == unlisted_) continue;
      std::vector<Candidate> effects = base.effects;
      effects.push_back(unlisted_ ? keep_told(c) : c);
      Trial t;
      t.fit = fit(effects);
      if (!is_sensible(t.fit.effects.back(), t.fit.get(effects.size() - 1), reach_)) continue;
      t.gain = fitter_.calc_gain(Part::kTrain, base, t.fit) - calc_cost(c);
      t.held = fitter_.calc_gain(Part::kHeld, base, t.fit);
      out.push_back(std::move(t));
    }
    return out;
  }

  static bool is_confirmed(const Trial& t) {
    return t.gain + calc_cost(t.fit.effects.back()) > kTrainGain && t.held > kHeldGain && t.gain + t.held > 0;
  }

  std::vector<Trial> try_all(const LeggedFit& base) const {
    return keep_best(base, [](const Trial& t) { return is_confirmed(t); });
  }

  std::vector<Trial> keep_best(const LeggedFit& base, const std::function<bool(const Trial&)>& is_kept) const {
    std::vector<Trial> out;
    for (Trial& t : try_each(base)) {
      if (is_kept(t)) out.push_back(std::move(t));
    }
    std::stable_sort(out.begin(), out.end(), [](const Trial& a, const Trial& b) { return a.gain + a.held > b.gain + b.held; });
    return out;
  }

  // Weights follow what is left, and what is left follows the weights.
  void settle(const std::vector<Candidate>& effects) {
    chosen_ = fit(effects);
    for (int round = 0; round < kSettle; ++round) {
      fitter_.update_weights(chosen_);
      chosen_ = fit(chosen_.effects);
      if (!chosen_.x.allFinite()) return settle(ban_untold());
    }
    out_.nominal = fitter_.fit({});
  }

  // Bans effects with a column that is noise alone by the weights of now, and returns the others. Rough rows, where columns
  // are noisiest, gain weight as soon as their mismatch is explained.
  std::vector<Candidate> ban_untold() {
    std::vector<Candidate> told;
    for (const Candidate& c : chosen_.effects) {
      const bool tells = fitter_.fit({c}).x.allFinite();
      if (!tells && say_) say_("noise alone tells: " + tell(c));
      (tells ? told : banned_).push_back(c);
    }
    if (told.size() == chosen_.effects.size()) banned_.push_back(told.back()), told.pop_back();
    return told;
  }

  bool add() { return add_best(try_all(chosen_), kShare) || add_best(try_lasting(), kHalf); }

  bool add_best(const std::vector<Trial>& trials, double least) {
    for (const Trial& t : trials) {
      const size_t at = t.fit.effects.size() - 1, channel = find_main_channel(chosen_, t.fit);
      if (calc_share(chosen_, t.fit, channel) < least || !is_significant(t.fit, at)) continue;
      if (!is_worth(chosen_, t.fit, channel)) continue;
      if (say_) say_("gain " + std::to_string(std::lround(t.gain + t.held)) + " by " + tell(t.fit.effects[at]));
      settle(t.fit.effects);
      return true;
    }
    return false;
  }

  // What lacks all the time looks like few independent errors: those that take most of an equation's mismatch, by the
  // errors that they leave.
  std::vector<Trial> try_lasting() const {
    std::vector<Trial> out;
    for (Trial& t : try_each(chosen_)) {
      const size_t channel = find_main_channel(chosen_, t.fit);
      // Where one of them was not of one size, others would be tried in turn to no end. Soles lie a little askew all the time.
      const std::string& kind = fitter_.channels()[channel].info.kind;
      const bool tried = std::find(out_.unsteady.begin(), out_.unsteady.end(), channel) != out_.unsteady.end();
      if (tried || kind.rfind("tilt", 0) == 0 || kind == "height" || t.held <= 0 || calc_share(chosen_, t.fit, channel) < kHalf) continue;
      t.held = 0, t.gain = fitter_.calc_gain_after(chosen_, t.fit) - calc_cost(t.fit.effects.back());
      if (t.gain > 0) out.push_back(std::move(t));
    }
    std::stable_sort(out.begin(), out.end(), [](const Trial& a, const Trial& b) { return a.gain > b.gain; });
    return out;
  }

  LeggedFit fit_without(size_t effect) const {
    std::vector<Candidate> rest = chosen_.effects;
    rest.erase(rest.begin() + static_cast<long>(effect));
    return fit(rest);
  }

  // Takes out what the others explain by now, and what the others have made impossible.
  void prune() {
    for (size_t i = chosen_.effects.size(); i-- > 0;) {
      const LeggedFit rest = fit_without(i);
      const double gain = fitter_.calc_gain(Part::kTrain, rest, chosen_) - kStay * calc_cost(chosen_.effects[i]);
      const double held = fitter_.calc_gain(Part::kHeld, rest, chosen_);
      const bool sensible = is_sensible(chosen_.effects[i], chosen_.get(i), reach_);
      const size_t channel = find_main_channel(rest, chosen_);
      const bool matters = !chosen_.effects[i].is_listed() || calc_share(rest, chosen_, channel) > kShare;
      if (gain + held > 0 && held > kStay * kHeldGain && sensible && matters && is_significant(chosen_, i)) continue;
      if (say_) say_("without " + tell(chosen_.effects[i]));
      settle(rest.effects);
      i = chosen_.effects.size();
    }
  }

  // Each effect against all others in its place: what came first was chosen without knowing the rest.
  bool exchange() {
    bool any = false;
    for (size_t i = 0; i < chosen_.effects.size(); ++i) {
      const LeggedFit rest = fit_without(i);
      const std::vector<Trial> trials = try_all(rest);
      if (trials.empty()) continue;
      const double before = fitter_.calc_gain(Part::kTrain, rest, chosen_) + fitter_.calc_gain(Part::kHeld, rest, chosen_) - calc_cost(chosen_.effects[i]);
      const double now = trials[0].gain + trials[0].held;
      const size_t at = trials[0].fit.effects.size() - 1;
      const double margin = unlisted_ ? std::max(kRivalLeast, kRival * before) : kRivalLeast;
      if (now < before + margin || !is_significant(trials[0].fit, at)) continue;
      if (say_) say_("exchanged for " + tell(trials[0].fit.effects.back()));
      settle(trials[0].fit.effects);
      any = true;
    }
    return any;
  }

  // Two effects of one family, as masses at two links, that a single one does as well: that came first while neither was
  // known to be there.
  void merge() {
    for (size_t i = 0; i < chosen_.effects.size(); ++i) {
      for (size_t k = i + 1; k < chosen_.effects.size(); ++k) {
        const bool listed = chosen_.effects[i].is_listed() && chosen_.effects[k].is_listed();
        if (listed && get_family(chosen_.effects[i]) == get_family(chosen_.effects[k]) && merge(i, k)) return merge();
      }
    }
  }

  bool merge(size_t first, size_t second) {
    std::vector<Candidate> effects = chosen_.effects;
    effects.erase(effects.begin() + static_cast<long>(second)), effects.erase(effects.begin() + static_cast<long>(first));
    const LeggedFit rest = fit(effects);
    const std::vector<Trial> trials = try_all(rest);
    if (trials.empty()) return false;
    const double costs = calc_cost(chosen_.effects[first]) + calc_cost(chosen_.effects[second]);
    const double both = fitter_.calc_gain(Part::kTrain, rest, chosen_) + fitter_.calc_gain(Part::kHeld, rest, chosen_) - costs;
    if (trials[0].gain + trials[0].held < both || !is_significant(trials[0].fit, effects.size())) return false;
    if (say_) say_("one for two: " + tell(trials[0].fit.effects.back()));
    settle(trials[0].fit.effects);
    return true;
  }

  // Robust errors, and what recordings and halves differ by: whether the effect may be none.
  Eigen::VectorXd find_scatter(const LeggedFit& f, size_t i) const {
    const auto first = static_cast<long>(f.find_first(i)), n = static_cast<long>(f.effects[i].terms.size());
    Eigen::VectorXd out = fitter_.calc_covariance(f).diagonal().segment(first, n).cwiseMax(0);
    const std::vector<LeggedFitter::PartFit> parts = fitter_.fit_parts(f, i);
    Eigen::VectorXd between = Eigen::VectorXd::Zero(n);
    for (const LeggedFitter::PartFit& p : parts) between += (p.x - f.get(i)).cwiseAbs2();
    const auto count = static_cast<double>(parts.size());
    if (count > 1) out = out.cwiseMax(between / (count * (count - 1)));
    return out.cwiseSqrt();
  }

  // Robust errors, widened by what recordings and halves differ by (random effects) and by what equations are exact to.
  Eigen::VectorXd find_deviation(const LeggedFit& f, size_t i, double* spread) const {
    const Eigen::MatrixXd all = fitter_.calc_covariance(f);
    const auto first = static_cast<long>(f.find_first(i));
    const Eigen::VectorXd x = f.get(i), systematic = fitter_.calc_systematic(f);
    Eigen::VectorXd out(x.size());
    const std::vector<LeggedFitter::PartFit> parts = fitter_.fit_parts(f, i);
    for (long k = 0; k < x.size(); ++k) {
      double variance = std::max(0.0, all(first + k, first + k)), sum = 0, weighted = 0;
      for (const LeggedFitter::PartFit& p : parts) {
        sum += std::pow(p.x(k) - x(k), 2), weighted += std::pow(p.weight(k) * (p.x(k) - x(k)), 2);
      }
      const auto n = static_cast<double>(parts.size());
      const double between = n > 1 ? sum / (n - 1) : 0;
      if (k == 0 && spread) *spread = std::sqrt(between) / std::max(1e-300, std::abs(x(0)));
      if (n > 1) variance = std::max(variance, std::pow(find_widening(parts.size()), 2) * weighted * n / (n - 1));
      out(k) = std::hypot(std::sqrt(variance), systematic(first + k));
    }
    return out;
  }

  void describe() {
    for (size_t i = 0; i < chosen_.effects.size(); ++i) {
      const LeggedFit rest = fit_without(i);
      FoundEffect f;
      f.effect = chosen_.effects[i], f.x = chosen_.get(i);
      f.std = find_deviation(chosen_, i, &f.spread);
      f.scatter = find_scatter(chosen_, i);
      f.channel = find_main_channel(rest, chosen_);
      f.gain = fitter_.calc_gain(Part::kHeld, rest, chosen_) + fitter_.calc_gain(Part::kTrain, rest, chosen_);
      const LeggedFit alone = fit({f.effect});
      f.share = std::clamp(0.5 * (calc_share(rest, chosen_, f.channel) + calc_share(out_.nominal, alone, f.channel)), 0.0, 1.0);
      find_rivals(rest, &f);
      f.sums_up = is_one_zero_of_many(f.effect) && !is_confirmed_elsewhere(i, f.channel);
      out_.effects.push_back(std::move(f));
    }
  }

  // Of one of several force sensors.
  bool is_one_zero_of_many(const Candidate& c) const {
    const bool of_force = c.effect == EffectId::kSensorBias && c.place >= 0 && layout_.sensors > 1 && !c.terms.empty() && !c.terms[0].empty();
    const int first = layout_.sensor(std::max(0, c.place), kForceBiasColumn);
    return of_force && c.terms[0][0].first >= first && c.terms[0][0].first < first + 3;
  }

  // Whether all equations but the one that tells an effect most ask for it in the same size: from half to twice. The feet's
  // forces add up, so their sum tells how large a zero is and not whose; their moments about the base tell whose.
  bool is_confirmed_elsewhere(size_t i, size_t channel) {
    const Eigen::VectorXd x = chosen_.get(i);
    const auto [all, covariance] = fitter_.fit_without(chosen_.effects, channel);
    if (!all.allFinite() || !covariance.allFinite() || !(x.squaredNorm() > 0)) return false;
    const auto first = static_cast<long>(chosen_.find_first(i)), n = x.size();
    const double size = x.dot(all.segment(first, n)) / x.squaredNorm();
    const double std = std::sqrt(std::max(0.0, x.dot(covariance.block(first, first, n, n) * x))) / x.squaredNorm();
    return size > 0.5 && size < 2 && std < kConfirmed;
  }

  // A law has one size in all regimes. Takes out the effect that has not and helps least, for good; others may take its
  // place then.
  bool drop_unsteady() {
    size_t worst = chosen_.effects.size();
    double least = 1e300;
    for (size_t i = 0; i < chosen_.effects.size(); ++i) {
      if (!chosen_.effects[i].is_listed()) continue;
      const std::vector<Regime> regimes = list_regimes(fitter_, chosen_, i, layout_);
      if (is_steady(regimes) && (is_expected(chosen_.effects[i].effect) || is_alike(regimes))) continue;
      const LeggedFit rest = fit_without(i);
      const double gain = fitter_.calc_gain(Part::kTrain, rest, chosen_) + fitter_.calc_gain(Part::kHeld, rest, chosen_);
      if (gain < least) least = gain, worst = i;
    }
    if (worst == chosen_.effects.size()) return false;
    const Candidate gone = chosen_.effects[worst];
    if (say_) say_("not of one size: " + tell(gone));
    banned_.push_back(gone);
    const LeggedFit rest = fit_without(worst);
    out_.unsteady.push_back(find_main_channel(rest, chosen_));
    settle(rest.effects);
    return true;
  }

  bool is_banned(const Candidate& c) const {
    return std::any_of(banned_.begin(), banned_.end(), [&](const Candidate& b) { return is_same(b, c); });
  }

  bool drop_partial() {
    size_t worst = out_.effects.size();
    double least = kHalf;
    for (size_t i = 0; i < out_.effects.size(); ++i) {
      const FoundEffect& f = out_.effects[i];
      const double left = chosen_.mean_square[1][f.channel];
      const bool partial = left > kHalf * out_.nominal.mean_square[1][f.channel] && left > std::pow(fitter_.find_exactness(f.channel), 2);
      if (partial && f.effect.is_listed() && !is_expected(f.effect.effect) && f.share < least) least = f.share, worst = i;
    }
    if (worst == out_.effects.size()) return false;
    if (say_) say_("most is left: " + tell(chosen_.effects[worst]));
    banned_.push_back(chosen_.effects[worst]);
    out_.unsteady.push_back(out_.effects[worst].channel);
    settle(fit_without(worst).effects);
    return true;
  }

  // What an error of a clock or a mounting explains as well is no mismatch, if they are not known that well.
  bool drop_known() {
    const auto is_little = [](const Candidate& c, const Eigen::VectorXd& x) { return (c.vector ? x.norm() : std::abs(x(0))) < c.known; };
    for (size_t i = 0; i < out_.effects.size(); ++i) {
      const std::vector<Rival>& rivals = out_.effects[i].rivals;
      if (std::none_of(rivals.begin(), rivals.end(), [&](const Rival& r) { return is_little(r.effect, r.x); })) continue;
      if (say_) say_("clocks and mountings are known no better: " + tell(chosen_.effects[i]));
      banned_.push_back(chosen_.effects[i]);
      settle(fit_without(i).effects);
      return true;
    }
    return false;
  }

  // [N] Root mean square of the forces on the body that stand out and that nothing explains, by the balance or the weight.
  double find_unknown_force(std::vector<size_t>* where) const {
    double square = 0;
    for (size_t c = 0; c < fitter_.channels().size(); ++c) {
      const std::string& kind = fitter_.channels()[c].info.kind;
      const double left = chosen_.mean_square[1][c];
      const bool of_force = kind == "weight" || kind.rfind("balance, force", 0) == 0;
      if (!of_force || left < kHalf * out_.nominal.mean_square[1][c] || left < kStandsOut * kStandsOut * fitter_.floor(c)) continue;
      square += left, where->push_back(c);
    }
    return std::sqrt(square);
  }

  // Torques of a leg follow from the forces that are known. One that nobody knows makes torques in the joints, too: what is
  // no larger and has no shape of its own, as a gain has none, may be that.
  bool drop_forced() {
    std::vector<size_t> where;
    const double force = find_unknown_force(&where);
    for (size_t i = 0; i < out_.effects.size() && force > 0; ++i) {
      const FoundEffect& f = out_.effects[i];
      if (f.effect.lever <= 0 || fitter_.channels()[f.channel].info.kind != "joint") continue;
      if (std::sqrt(out_.nominal.mean_square[1][f.channel]) > force * f.effect.lever) continue;
      if (say_) say_("an unknown force could make it: " + tell(f.effect));
      banned_.push_back(chosen_.effects[i]);
      out_.unsteady.insert(out_.unsteady.end(), where.begin(), where.end());
      settle(fit_without(i).effects);
      return true;
    }
    return false;
  }

  // What recordings differ by so much that it may be none is not claimed. The least sure goes first.
  bool drop_unsure() {
    size_t worst = out_.effects.size();
    double least = kSure;
    for (size_t i = 0; i < out_.effects.size(); ++i) {
      const FoundEffect& f = out_.effects[i];
      double square = 0;
      for (long k = 0; k < (f.effect.vector ? f.x.size() : 1); ++k) square += std::pow(f.x(k) / std::max(1e-300, f.scatter(k)), 2);
      // A sole that gives about one axis only is one; one that gives about neither for sure is none.
      for (size_t k = 1; k < f.effect.core.size(); ++k) {
        const long at = f.effect.core[k];
        square = std::max(square, std::pow(f.x(at) / std::max(1e-300, f.std(at)), 2));
      }
      if (make_estimates(f.effect, f.x, f.std).empty()) square = 0;  // no value of it is told
      if (std::sqrt(square) < least) least = std::sqrt(square), worst = i;
    }
    if (worst == out_.effects.size()) return false;
    if (say_) say_("not sure: " + tell(chosen_.effects[worst]));
    if (!chosen_.effects[worst].is_listed()) banned_.push_back(chosen_.effects[worst]);
    settle(fit_without(worst).effects);
    return true;
  }

  // What wins far more on the rows that are fitted, and loses nothing on the others, may be the cause as well.
  bool is_strong(const LeggedFit& rest, const Trial& t, double gain) const {
    const size_t at = t.fit.effects.size() - 1;
    return t.held > 0 && t.gain > kStrong * gain && calc_share(rest, t.fit, find_main_channel(rest, t.fit)) > kShare && is_significant(t.fit, at);
  }

  void find_rivals(const LeggedFit& rest, FoundEffect* f) const {
    const double limit = f->gain - std::max(kRivalLeast, kRival * f->gain);
    for (const Trial& t : keep_best(rest, [&](const Trial& t) { return is_confirmed(t) || is_strong(rest, t, f->gain); })) {
      const size_t at = t.fit.effects.size() - 1;
      const double gain = t.gain + t.held + calc_cost(t.fit.effects[at]);
      if (gain < limit || (t.fit.effects[at].effect == f->effect.effect && t.fit.effects[at].where == f->effect.where)) continue;
      // Links that move alike share a load in many places: they must not crowd out what is no load.
      const auto alike = std::count_if(f->rivals.begin(), f->rivals.end(), [&](const Rival& r) { return r.effect.effect == t.fit.effects[at].effect; });
      if (alike >= kPlaces) continue;
      f->rivals.push_back({t.fit.effects[at], t.fit.get(at), find_deviation(t.fit, at, nullptr), f->gain - gain});
    }
    if (leaves_encoder(f->effect)) add_other_departures(rest, f);
  }

  // How far a link is from where its encoder says: a constant, by the sign of the torque, in proportion to it.
  bool leaves_encoder(const Candidate& c) const {
    const int at = c.terms[0].empty() ? -1 : c.terms[0][0].first - layout_.joint(0, 0), kind = at % kJointColumns;
    return at >= 0 && at < kJointColumns * layout_.joints && kind >= kOffsetColumn && kind <= kGiveColumn;
  }

  // A leg that stands bears a torque of one sign and of about one size. There the three laws predict about the same, and
  // what they differ by is less than what none of them holds: damping, links that bend.
  void add_other_departures(const LeggedFit& rest, FoundEffect* f) const {
    for (const Candidate& c : candidates_) {
      const bool listed = std::any_of(f->rivals.begin(), f->rivals.end(), [&](const Rival& r) { return r.effect.effect == c.effect && r.effect.where == c.where; });
      if (!leaves_encoder(c) || c.where != f->effect.where || c.effect == f->effect.effect || listed) continue;
      if (fitter_.calc_overlap(f->effect, c) < kAlike) continue;
      std::vector<Candidate> effects = rest.effects;
      effects.push_back(c);
      const LeggedFit with = fit(effects);
      const size_t at = effects.size() - 1;
      if (!is_sensible(with.effects[at], with.get(at), reach_)) continue;
      const double gain = fitter_.calc_gain(Part::kTrain, rest, with) + fitter_.calc_gain(Part::kHeld, rest, with);
      f->rivals.push_back({with.effects[at], with.get(at), find_deviation(with, at, nullptr), f->gain - gain});
    }
  }

  LeggedFitter& fitter_;
  const std::vector<Candidate>& candidates_;
  const ColumnLayout& layout_;
  double reach_;
  const Say& say_;
  LeggedFit chosen_;
  bool unlisted_ = false;          // what is tried now is in no table
  std::vector<Candidate> banned_;  // were chosen and were not of one size
  LeggedOutcome out_;
};

}  // namespace

LeggedOutcome search_legged(LeggedFitter* fitter, const std::vector<Candidate>& candidates, const ColumnLayout& layout,
                            double reach, const Say& say) {
  return Searcher(fitter, candidates, layout, reach, say).run();
}

}  // namespace hrp::diagnosis::floating
