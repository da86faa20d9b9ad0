// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/state.h"

#include <algorithm>
#include <set>

#include "diagnosis/floating/fit/candidate_laws.h"

namespace hrp::diagnosis::floating {
namespace {

// Of fits about the place of a mass, each exact about the last one's place; of weights, which change by a few percent
// in the last.
constexpr int kRounds = 4;

// Takes the terms of a mass about the place that a fit has found. False: its terms need no place, or none is possible.
bool place_mass(const SearchState& state, const Eigen::VectorXd& x, Candidate* effect) {
  return effect->law->refine && effect->law->refine(state.layout, x, effect);
}

// Bans chosen effects with a column that is noise alone by the present weights, and returns the others. It happens when
// an effect explains the mismatch of rough rows: they gain weight then, and their columns are the noisiest.
std::vector<Candidate> ban_without_information(SearchState* state) {
  std::vector<Candidate> told;
  for (const Candidate& c : state->chosen.effects) {
    const bool tells = state->fitter.fit({c}).x.allFinite();
    if (!tells) say_of(*state, "noise alone tells:", c);
    (tells ? told : state->banned).push_back(c);
  }
  // Each one alone can be fitted, all together cannot: the last one goes.
  if (told.size() == state->chosen.effects.size()) {
    state->banned.push_back(told.back());
    told.pop_back();
  }
  return told;
}

// Columns that fits of these effects use. The place of a mass is a result of the fit, and takes others of its link.
std::vector<int> list_columns(const ColumnLayout& layout, const std::vector<Candidate>& effects) {
  std::set<int> out;
  for (const Candidate& c : effects) {
    for (const Terms& t : c.terms) {
      for (const auto& [column, factor] : t) {
        const int link = column / kInertialParameters;
        out.insert(column);
        for (int p = 0; link < layout.links && p < kInertialParameters; ++p) out.insert(layout.link(link, p));
      }
    }
  }
  return {out.begin(), out.end()};
}

}  // namespace

bool is_same(const Candidate& a, const Candidate& b) {
  return a.law->effect == b.law->effect && a.law->unlisted == b.law->unlisted && a.where == b.where;
}

bool is_banned(const SearchState& state, const Candidate& candidate) {
  return std::any_of(state.banned.begin(), state.banned.end(),
                     [&](const Candidate& b) { return is_same(b, candidate); });
}

LeggedFit fit_effects(const SearchState& state, std::vector<Candidate> effects) {
  LeggedFit out = state.fitter.fit(effects);
  for (int round = 0; round < kRounds; ++round) {
    bool any = false;
    for (size_t i = 0; i < effects.size(); ++i) any = place_mass(state, out.get(i), &effects[i]) || any;
    if (!any) break;
    out = state.fitter.fit(effects);
  }
  return out;
}

LeggedFit fit_without(const SearchState& state, size_t effect) {
  std::vector<Candidate> rest = state.chosen.effects;
  rest.erase(rest.begin() + static_cast<long>(effect));
  return fit_effects(state, std::move(rest));
}

void settle(const std::vector<Candidate>& effects, SearchState* state) {
  state->chosen = fit_effects(*state, effects);
  const std::vector<int> own = list_columns(state->layout, effects);  // until the last round no other effect is fitted
  for (int round = 0; round < kRounds; ++round) {
    state->fitter.update_weights(state->chosen, round + 1 < kRounds ? &own : nullptr);
    state->chosen = fit_effects(*state, state->chosen.effects);
    if (!state->chosen.x.allFinite()) return settle(ban_without_information(state), state);
  }
  state->nominal = state->fitter.fit({});
}

void say_of(const SearchState& state, const std::string& what, const Candidate& candidate) {
  if (!state.say) return;
  const std::string name = candidate.is_listed() ? candidate.info().name : candidate.law->unlisted;
  std::string place;
  for (const auto& [kind, own] : candidate.where.items())
    place += (place.empty() ? "" : ", ") + (own.is_string() ? own.get<std::string>() : own.dump());
  state.say(what + " " + name + " at " + place);
}

}  // namespace hrp::diagnosis::floating
