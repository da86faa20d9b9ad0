// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/lone_delay.h"

#include <algorithm>

#include "common/base/has.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

// The model with friction and rotor of the joint in place of its delay. Friction of another law stays the dry one.
TorqueModel exchange_delay(const TorqueDesign& design, TorqueModel model, const TermPlace& place) {
  const auto i = static_cast<size_t>(place.joint);
  std::vector<size_t>& own = model.own[i];
  const std::vector<Term>& terms = design.joints[i].terms;
  own.erase(own.begin() + static_cast<long>(place.at));
  const bool dry = std::any_of(own.begin(), own.end(), [&](size_t t) { return terms[t].row->is_dry(); });
  const std::vector<std::vector<size_t>> usual = list_usual_terms(design);
  for (size_t term : usual[i]) {
    if (!has(own, term) && !(dry && terms[term].row->is_dry())) own.push_back(term);
  }
  std::sort(own.begin(), own.end());
  return model;
}

double get_left(const TorqueDesign& design, const TorqueFit& fit, size_t i) {
  return design.joints[i].has_held ? fit.held[i] : fit.cross[i];
}

// Those that the model with the delay does not have.
void add_rivals(const TorqueDesign& design, const Choice& with_delay, const Choice& without, GradedTerm* g) {
  const auto i = static_cast<size_t>(g->place.joint);
  for (size_t at = 0; at < without.model.own[i].size(); ++at) {
    if (has(with_delay.model.own[i], without.model.own[i][at])) continue;
    const TermPlace place{g->place.joint, at};
    const GradedTerm other = grade_term(design, without, place);
    if (other.parameters[0] > 0.0) g->rivals.push_back({other.term, other.parameters, other.width, without.model, place});
  }
}

}  // namespace

void doubt_lone_delays(const TorqueDesign& design, const Choice& choice, std::vector<GradedTerm>* graded) {
  for (GradedTerm& g : *graded) {
    if (!g.term.row->late || g.term.row->is_of_bus() || g.place.joint < 0) continue;
    const auto i = static_cast<size_t>(g.place.joint);
    Choice without = choice;
    without.model = exchange_delay(design, choice.model, g.place);
    without.fit = fit_torque(design, without.model);
    if (get_left(design, choice.fit, i) < kPart * get_left(design, without.fit, i)) continue;
    g.grade = Grade::kAmbiguous;
    add_rivals(design, choice, without, &g);
  }
}

}  // namespace hrp::diagnosis
