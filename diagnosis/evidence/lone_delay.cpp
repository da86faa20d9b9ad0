// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/lone_delay.h"

#include <algorithm>

#include "common/base/has.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/evidence/torque/rivals.h"
#include "diagnosis/measurement/torque/term_rows.h"

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
    if (other.parameters[0] > 0.0)
      g->rivals.push_back({other.term, other.parameters, other.width, without.model, place});
  }
}

// [s] Delay of all commands that takes as much torque as the joint's viscous friction; 0 if the effort was logged.
double find_like_delay(const TorqueDesign& design, const GradedTerm& g) {
  if (g.place.joint < 0 || !is_viscous(g.term)) return 0.0;
  const TorqueData& data = *design.data;
  const auto joint = static_cast<size_t>(design.joints[static_cast<size_t>(g.place.joint)].joint);
  const double kp =
      get_servo_gains(data.experiment->scenario, data.experiment->robot.tree.joint(static_cast<int>(joint)).name).kp;
  return data.source[joint] == EffortSource::kServoLaw && kp > 0.0 ? g.parameters[0] / kp : 0.0;
}

// The joint's delay that is nearest to this one.
const Term* find_delay_term(const JointDesign& joint, double delay) {
  const Term* best = nullptr;
  for (const Term& t : joint.terms) {
    if (t.row->late && (!best || std::abs(t.shape - delay) < std::abs(best->shape - delay))) best = &t;
  }
  return best;
}

}  // namespace

void doubt_viscous_of_one_delay(const TorqueDesign& design, std::vector<GradedTerm>* graded) {
  std::vector<double> delays;
  for (const GradedTerm& g : *graded) {
    if (const double delay = find_like_delay(design, g); delay > 0.0) delays.push_back(delay);
  }
  if (delays.size() < 2 || delays.size() < design.joints.size()) return;
  const double mean = calc_mean(delays);
  const auto differs = [&](double delay) { return std::abs(delay - mean) > kMinority * mean; };
  if (mean > kLongest || std::any_of(delays.begin(), delays.end(), differs)) return;
  for (GradedTerm& g : *graded) {
    if (!(find_like_delay(design, g) > 0.0)) continue;
    g.grade = Grade::kAmbiguous;
    const Term* late = find_delay_term(design.joints[static_cast<size_t>(g.place.joint)], mean);
    const bool listed = std::any_of(g.rivals.begin(), g.rivals.end(), [](const Rival& r) { return r.term.row->late; });
    if (late && !listed)
      g.rivals.push_back(
          {*late, Eigen::VectorXd::Constant(1, mean), Eigen::VectorXd::Constant(1, kMinority * mean), {}, {}});
  }
}

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
