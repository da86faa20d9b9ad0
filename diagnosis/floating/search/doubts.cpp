// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/doubts.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/limits.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/regimes.h"
#include "diagnosis/floating/search/gain.h"
#include "diagnosis/floating/search/stand_ins.h"

namespace hrp::diagnosis::floating {
namespace {

// Bans a chosen effect, notes the equations that lack something without it, and settles the others.
void drop(size_t effect, const std::string& why, const std::vector<size_t>& unsteady, SearchState* state) {
  say_of(*state, why, state->chosen.effects[effect]);
  state->banned.push_back(state->chosen.effects[effect]);
  state->unsteady.insert(state->unsteady.end(), unsteady.begin(), unsteady.end());
  settle(fit_without(*state, effect).effects, state);
}

double get_nominal(const SearchState& state, size_t channel) { return state.nominal.mean_square[1][channel]; }
double get_left(const SearchState& state, size_t channel) { return state.chosen.mean_square[1][channel]; }

// How many standard errors the effect is away from none. Of three axes chance makes more than of one: the length counts
// as the deviation of one axis that is as improbable.
double calc_certainty(const FoundEffect& f) {
  if (make_estimates(f.effect, f.x, f.std).empty()) return 0;  // no parameter of it is told
  const std::vector<long>& core = f.effect.law->core;
  double square = 0;
  // One core coefficient that is sure is enough: a sole may give about one axis alone. It has to be as sure as a report
  // asks, which says no stiffness otherwise: shifts and damping are no sole, and what bends further up has them, too.
  for (const long k : core) square = std::max(square, std::pow(f.x(k) / std::max(1e-300, f.std(k)), 2));
  if (!core.empty()) return std::sqrt(square);
  // Zeros, turns and displacements look like what the equations are not exact to, so that counts as well; what follows
  // the motion does not.
  const long axes = f.effect.vector ? f.x.size() : 1;
  const Eigen::VectorXd& error = f.effect.vector ? f.std : f.scatter;
  for (long k = 0; k < axes; ++k) square += std::pow(f.x(k) / std::max(1e-300, error(k)), 2);
  return std::sqrt(square) * kAboveNoise / find_length(kAboveNoise, static_cast<size_t>(std::min(3L, axes)));
}

// An effect that may be none, because recordings differ by as much as its size, is not claimed. The least certain one
// goes. It is not banned if it is listed: with another set of effects it may be certain.
bool drop_unsure(const std::vector<FoundEffect>& found, SearchState* state) {
  size_t worst = found.size();
  double least = kAboveNoise;
  for (size_t i = 0; i < found.size(); ++i) {
    const double certainty = calc_certainty(found[i]);
    if (certainty < least) {
      least = certainty;
      worst = i;
    }
  }
  if (worst == found.size()) return false;
  say_of(*state, "not sure:", state->chosen.effects[worst]);
  if (!state->chosen.effects[worst].is_listed()) state->banned.push_back(state->chosen.effects[worst]);
  settle(fit_without(*state, worst).effects, state);
  return true;
}

// Whether the equations were made far from the value of a delay or a turn, so that its columns leave errors of second
// order.
bool is_linearized_elsewhere(const SearchState& state, const FoundEffect& f) {
  if (!state.about || !f.effect.law->linearized) return false;
  double away = 0, size = 0;
  for (size_t k = 0; k < f.effect.terms.size(); ++k) {
    for (const auto& [column, factor] : f.effect.terms[k]) {
      const double value = factor * f.x(static_cast<long>(k));
      away += std::pow(value - (*state.about)(column), 2);
      size += value * value;
    }
  }
  return away > kMinority * kMinority * size;
}

// What was possible beside the first effects may have become impossible beside the last ones, as a load that hangs
// metres away.
bool drop_impossible(SearchState* state) {
  for (size_t i = 0; i < state->chosen.effects.size(); ++i) {
    if (!state->chosen.effects[i].is_listed() || is_possible(*state, state->chosen, i)) continue;
    drop(i, "not possible:", {}, state);
    return true;
  }
  return false;
}

// An effect that takes less than half of its equation's mismatch, where more than half is left, may stand in for the
// cause of all of it. The one with the smallest share goes. Effects that every drive and sensor has may stay beside
// another cause.
bool drop_partial(const std::vector<FoundEffect>& found, SearchState* state) {
  size_t worst = found.size();
  // An effect that leaves more of an equation's mismatch than it takes may stand in for another cause.
  double least = kHalf;
  for (size_t i = 0; i < found.size(); ++i) {
    const FoundEffect& f = found[i];
    if (!f.effect.is_listed() || is_expected(f.effect.info()) || is_linearized_elsewhere(*state, f)) continue;
    const double left = get_left(*state, f.channel), exact = std::pow(state->fitter.find_exactness(f.channel), 2);
    if (left > kHalf * get_nominal(*state, f.channel) && left > exact && f.share < least) {
      least = f.share;
      worst = i;
    }
  }
  if (worst == found.size()) return false;
  drop(worst, "most is left:", {found[worst].channel}, state);
  return true;
}

// Friction or a rotor that is all that was found, and leaves most of its joint's mismatch, stands in for another cause:
// every drive of a real robot has both, so that they show at several joints.
bool drop_lone(const std::vector<FoundEffect>& found, SearchState* state) {
  if (found.size() != 1) return false;
  const FoundEffect& f = found[0];
  if (!f.effect.is_listed() || f.effect.info().place != PlaceKind::kJoint || !is_expected(f.effect.info()))
    return false;
  if (f.share >= kHalf || get_left(*state, f.channel) <= kHalf * get_nominal(*state, f.channel)) return false;
  drop(0, "alone, and most is left:", {f.channel}, state);
  return true;
}

// Weighted squares of what two effects predict, each and both together, over all rows.
struct PairSquares {
  double first = 0, second = 0, sum = 0;
};

PairSquares calc_pair(const SearchState& state, size_t i, size_t k) {
  const std::vector<Candidate> one{state.chosen.effects[i]}, other{state.chosen.effects[k]};
  PairSquares out;
  for (size_t c = 0; c < state.fitter.channels().size(); ++c) {
    const Eigen::VectorXd a = state.fitter.calc_columns(c, one, false) * state.chosen.get(i);
    const Eigen::VectorXd b = state.fitter.calc_columns(c, other, false) * state.chosen.get(k);
    for (long r = 0; r < a.size(); ++r) {
      const double w = state.fitter.get_weight(c, static_cast<size_t>(r));
      out.first += w * a(r) * a(r);
      out.second += w * b(r) * b(r);
      out.sum += w * (a(r) + b(r)) * (a(r) + b(r));
    }
  }
  return out;
}

// Two effects that undo each other, such as a scale and a zero of an accelerometer that always feels the same weight,
// have no values of their own. The less certain one goes.
bool drop_undone(const std::vector<FoundEffect>& found, SearchState* state) {
  for (size_t i = 0; i < found.size(); ++i) {
    for (size_t k = i + 1; k < found.size(); ++k) {
      const PairSquares s = calc_pair(*state, i, k);
      if (s.sum > kDetail * std::min(s.first, s.second)) continue;
      drop(calc_certainty(found[i]) < calc_certainty(found[k]) ? i : k, "undone by another:", {}, state);
      return true;
    }
  }
  return false;
}

bool drop_stand_in(const std::vector<FoundEffect>& found, SearchState* state) {
  const StandIn at = find_stand_in(found, *state);
  if (at.effect == found.size()) return false;
  drop(at.effect, at.why, {found[at.effect].channel}, state);
  return true;
}

// An error of a clock or of a mounting explains the effect as well, and it is smaller than clocks and mountings are
// known. Then there is no mismatch to report.
bool drop_known(const std::vector<FoundEffect>& found, SearchState* state) {
  const auto is_little = [](const Rival& r) { return r.effect.calc_size(r.x) < r.effect.known; };
  for (size_t i = 0; i < found.size(); ++i) {
    if (std::none_of(found[i].rivals.begin(), found[i].rivals.end(), is_little)) continue;
    drop(i, "clocks and mountings are known no better:", {}, state);
    return true;
  }
  return false;
}

// Equations of forces on the body with a mismatch that stands out and that nothing explains.
std::vector<size_t> list_unknown_forces(const SearchState& state) {
  std::vector<size_t> out;
  for (size_t c = 0; c < state.fitter.channels().size(); ++c) {
    const Equation& e = state.fitter.channels()[c].info.equation;
    const bool of_force = e.is(EquationKind::kWeight) || e.is(EquationKind::kForce);
    const double left = get_left(state, c);
    if (!of_force || left < kHalf * get_nominal(state, c)) continue;
    // A real force on the body exceeds noise and exactness by more.
    if (left < kUnlikely * kUnlikely * state.fitter.floor(c)) continue;
    out.push_back(c);
  }
  return out;
}

// An unknown force under a sole makes torques in the joints of the leg, up to the force times the lever of the sole. An
// effect with no shape of its own, such as a drive's gain, that explains no larger torque may be that force.
bool drop_forced(const std::vector<FoundEffect>& found, SearchState* state) {
  const std::vector<size_t> unknown = list_unknown_forces(*state);
  double square = 0;  // [N^2]
  for (size_t c : unknown) square += get_left(*state, c);
  const double force = std::sqrt(square);
  for (size_t i = 0; i < found.size() && force > 0; ++i) {
    const FoundEffect& f = found[i];
    if (f.effect.lever <= 0 || !state->fitter.channels()[f.channel].info.equation.is(EquationKind::kJoint)) continue;
    if (std::sqrt(get_nominal(*state, f.channel)) > force * f.effect.lever) continue;
    drop(i, "an unknown force could make it:", unknown, state);
    return true;
  }
  return false;
}

}  // namespace

bool drop_unsteady(SearchState* state) {
  const LeggedFit& chosen = state->chosen;
  size_t worst = chosen.effects.size(), channel = 0;
  double least = 1e300;
  for (size_t i = 0; i < chosen.effects.size(); ++i) {
    if (!chosen.effects[i].is_listed()) continue;
    const std::vector<Regime> regimes = list_regimes(state->fitter, chosen, i, state->layout);
    if (is_steady(regimes) && (is_expected(chosen.effects[i].info()) || is_alike(regimes))) continue;
    const LeggedFit rest = fit_without(*state, i);
    const double gain = calc_total_gain(*state, rest, chosen);
    if (gain < least) {
      least = gain;
      worst = i;
      channel = find_main_channel(*state, rest, chosen);
    }
  }
  if (worst == chosen.effects.size()) return false;
  drop(worst, "not of one size:", {channel}, state);
  return true;
}

bool drop_doubtful(const std::vector<FoundEffect>& found, SearchState* state) {
  return drop_impossible(state) || drop_undone(found, state) || drop_unsure(found, state) ||
         drop_partial(found, state) || drop_known(found, state) || drop_forced(found, state) ||
         drop_stand_in(found, state) || drop_lone(found, state);
}

}  // namespace hrp::diagnosis::floating
