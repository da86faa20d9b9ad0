// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/stand_ins.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/conventions/sides.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/report/words.h"
#include "diagnosis/floating/search/gain.h"

namespace hrp::diagnosis::floating {
namespace {

// Of a joint, and of that family.
bool is(const Candidate& c, EffectFamily family) {
  return c.is_listed() && c.law->info().place == PlaceKind::kJoint && c.law->info().family == family;
}

bool are_sides(const Candidate& a, const Candidate& b) {
  const std::string first = get_place(a.where), second = get_place(b.where);
  return has(list_right_names(first), second) || has(list_right_names(second), first);
}

bool is_chosen(const SearchState& state, const Candidate& c) {
  const std::vector<Candidate>& all = state.chosen.effects;
  return std::any_of(all.begin(), all.end(), [&](const Candidate& e) { return is_same(e, c); });
}

// Whether the same joint of the other side asks for a zero of this size, to a factor of two, beyond chance. Two
// encoders do not lose the same angle together. A body that is tilted against what its sensors say turns all limbs by
// one angle.
bool is_shared(const SearchState& state, size_t zero) {
  const double size = std::abs(state.chosen.get(zero)(0));
  return std::any_of(state.candidates.begin(), state.candidates.end(), [&](const Candidate& other) {
    if (!is(other, EffectFamily::kZero) || !are_sides(state.chosen.effects[zero], other) || is_chosen(state, other))
      return false;
    std::vector<Candidate> effects = state.chosen.effects;
    effects.push_back(other);
    const LeggedFit with = fit_effects(state, std::move(effects));
    const size_t at = with.effects.size() - 1;
    const double beside = std::abs(with.get(at)(0));
    return beside > kHalf * size && kHalf * beside < size && is_significant(state, with, at);
  });
}

// Whether this joint's transmission was found to give or to have play. Which law it follows is not told there, and what
// the found one leaves moves the limb's weight with the joint, as a spring does.
bool is_of_transmission(const std::vector<FoundEffect>& found, const FoundEffect& spring) {
  return std::any_of(found.begin(), found.end(), [&](const FoundEffect& f) {
    return is(f.effect, EffectFamily::kPlay) && f.effect.where == spring.effect.where;
  });
}

}  // namespace

StandIn find_stand_in(const std::vector<FoundEffect>& found, const SearchState& state) {
  for (size_t i = 0; i < found.size(); ++i) {
    const FoundEffect& f = found[i];
    if (is(f.effect, EffectFamily::kZero) && is_shared(state, i)) return {i, "the other side asks for it, too:"};
    if (is(f.effect, EffectFamily::kTorqueOverPosition) && f.share < kMostly && is_of_transmission(found, f))
      return {i, "what the transmission's law leaves:"};
  }
  return {found.size(), ""};
}

}  // namespace hrp::diagnosis::floating
