// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/effect_findings.h"

#include <algorithm>

#include "diagnosis/estimate/enough.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/report/lookalikes.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

// What landings tell of the sole that an effect is of.
SoleLaw find_sole_law(const ReportState& state, const Candidate& effect) {
  const auto foot = static_cast<size_t>(std::max(0, effect.place));
  const bool of_foot = effect.info().place == PlaceKind::kFoot && effect.place >= 0;
  return of_foot && foot < state.soles.size() ? state.soles[foot] : SoleLaw{};
}

double calc_weight(const ReportState& state, const FoundEffect& f) {
  const auto gain_of = [&](Part part) {
    return state.fitter.calc_gain(part, state.outcome.nominal, state.outcome.chosen);
  };
  return std::max(0.0, f.gain) / std::max(1.0, gain_of(Part::kHeld) + gain_of(Part::kTrain));
}

Finding make_effect_finding(const ReportState& state, const FoundEffect& f) {
  const EffectInfo& effect = f.effect.info();
  std::vector<Estimate> parameters = make_estimates(f.effect, f.x, f.std);
  const SoleLaw law = find_sole_law(state, f.effect);
  const bool lands = put_law(law, &parameters);
  Finding out = make_finding(effect, f.effect.where, parameters);
  out.share = f.share;
  out.probability = std::min(kSurest, 1 - 1 / (1 + std::max(0.0, f.gain)));
  out.weight = calc_weight(state, f);
  for (const Rival& r : f.rivals) {
    out.alternatives.push_back(
        make_alternative(r.effect.info(), r.effect.where, make_estimates(r.effect, r.x, r.std),
                         "wider and faster motion of the joints around it, loaded and unloaded"));
  }
  out.grade = f.rivals.empty() ? Grade::kSupported : Grade::kAmbiguous;
  out.statement = get_place(out.where) + ": " + effect.phrase + " (" + describe(out.parameters) + "). It takes " +
                  format("%.0f %% of the held-out mismatch of the equation '", 100 * f.share) +
                  get_text(state.fitter.channels()[f.channel].info.equation) + "' away.";
  if (lands)
    out.statement += format(" How it gives in height is from %.0f landings.", static_cast<double>(law.landings));
  add_lookalikes(state, f, &out);
  return out;
}

// Joins the rotor of a joint whose transmission gives or has play to that finding: the rotor before the transmission is
// a parameter of it, so that both are one cause.
void join_rotors(std::vector<Finding>* findings) {
  for (Finding& play : *findings) {
    const EffectInfo* row = find_effect(play.effect);
    if (!row || row->rotor < 0 || !row->flexible) continue;
    const auto rotor = std::find_if(findings->begin(), findings->end(), [&](const Finding& f) {
      return f.effect == get_laws().rotor_inertia.info().name && f.where == play.where;
    });
    if (rotor == findings->end()) continue;
    play.parameters.push_back(rotor->parameters[0]);
    play.parameters.back().name = row->parameters[static_cast<size_t>(row->rotor)].name;
    play.weight += rotor->weight;
    play.statement += " The rotor before it: " + describe(rotor->parameters) + ".";
    findings->erase(rotor);
    return join_rotors(findings);
  }
}

}  // namespace

void add_effect_findings(ReportState* state) {
  for (const FoundEffect& f : state->outcome.effects) {
    if (f.effect.is_listed()) state->evidence.findings.push_back(make_effect_finding(*state, f));
  }
  join_rotors(&state->evidence.findings);
}

}  // namespace hrp::diagnosis::floating
