// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/rivals.h"

#include <algorithm>

#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/search/deviations.h"
#include "diagnosis/floating/search/gain.h"
#include "diagnosis/floating/search/trials.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr long kMostPlaces = 6;  // of one effect in a list of rivals

bool is_same_effect(const Candidate& a, const Candidate& b) { return a.law->effect == b.law->effect; }
bool is_same_finding(const Candidate& a, const Candidate& b) { return is_same_effect(a, b) && a.where == b.where; }

// Whether a candidate wins far more on fitted rows than what was found, and loses nothing on held-out rows. It may be
// the cause although held-out rows do not confirm it.
bool is_strong(const SearchState& state, const LeggedFit& rest, const LeggedTrial& t, double gain) {
  if (t.held <= 0 || t.gain <= kSeveralTimes * gain) return false;
  const size_t channel = find_main_channel(state, rest, t.fit);
  return calc_share(state, rest, t.fit, channel) > kDetail && is_significant(state, t.fit, t.at());
}

// Whether a candidate explains what was found, and not as much of another equation.
bool explains_same(const SearchState& state, const LeggedFit& rest, const LeggedFit& with, const FoundEffect& found) {
  return calc_share(state, rest, with, found.channel) > kHalf * calc_share(state, rest, state.chosen, found.channel);
}

// How far a link is from where its encoder says: by a constant, by the sign of the torque, or in proportion to it.
bool leaves_encoder(const ColumnLayout& layout, const Candidate& c) {
  const int at = c.terms[0].empty() ? -1 : c.terms[0][0].first - layout.joint(0, 0), kind = at % kJointColumns;
  return at >= 0 && at < kJointColumns * layout.joints && kind >= kOffsetColumn && kind <= kGiveColumn;
}

// The last effect of `with` as a rival of what was found.
Rival make_rival(const SearchState& state, const LeggedFit& with) {
  const size_t at = with.effects.size() - 1;
  return {with.effects[at], with.get(at), calc_deviation(state, with, at)};
}

// Adds the other laws of how far a link is from its encoder. A leg that stands bears a torque of one sign and of about
// one size. There these laws predict about the same, and gains do not decide between them.
void add_other_departures(const SearchState& state, const LeggedFit& rest, const FoundEffect& found,
                          std::vector<Rival>* rivals) {
  for (const Candidate& c : state.candidates) {
    if (!leaves_encoder(state.layout, c) || c.where != found.effect.where || is_same_effect(c, found.effect)) continue;
    const bool listed =
        std::any_of(rivals->begin(), rivals->end(), [&](const Rival& r) { return is_same_finding(r.effect, c); });
    // Beyond this squared correlation, what no law holds (damping, links that bend) is larger than what the laws differ
    // by.
    if (listed || state.fitter.calc_overlap(found.effect, c) < kMostly) continue;
    std::vector<Candidate> effects = rest.effects;
    effects.push_back(c);
    const LeggedFit with = fit_effects(state, std::move(effects));
    const size_t at = with.effects.size() - 1;
    if (!is_possible(state, with, at)) continue;
    rivals->push_back(make_rival(state, with));
  }
}

}  // namespace

std::vector<Rival> list_rivals(const SearchState& state, const LeggedFit& rest, const FoundEffect& found) {
  std::vector<Rival> out;
  const double least = found.gain - std::max(kTie, kDetail * found.gain);
  const auto is_kept = [&](const LeggedTrial& t) { return is_confirmed(t) || is_strong(state, rest, t, found.gain); };
  for (const LeggedTrial& t : list_trials(state, rest, Pool::kListed, is_kept)) {
    const double gain = t.gain + t.held + calc_cost(t.added());
    if (gain < least || is_same_finding(t.added(), found.effect) || !explains_same(state, rest, t.fit, found)) continue;
    // Links that move alike share a load in many places. These must not crowd out effects of other kinds.
    const auto alike =
        std::count_if(out.begin(), out.end(), [&](const Rival& r) { return is_same_effect(r.effect, t.added()); });
    if (alike < kMostPlaces) out.push_back(make_rival(state, t.fit));
  }
  if (leaves_encoder(state.layout, found.effect)) add_other_departures(state, rest, found, &out);
  return out;
}

}  // namespace hrp::diagnosis::floating
