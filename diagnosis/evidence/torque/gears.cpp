// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/gears.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// The regressor of kLoadOfBodies contains the load of the nominal mass, so its coefficient is mass_factor times too
// large.
void relate_to_true_load(double mass_factor, GradedTerm* friction) {
  if (friction->term.shape != kLoadOfBodies) return;
  friction->parameters /= mass_factor;
  friction->std /= mass_factor;
  friction->width /= mass_factor;
}

// Torque that the drive needs to lift the true link, over the link's own torque [1]. See the table in torque/gears.h.
double calc_lift(const GradedTerm& friction) {
  const double mu = friction.parameters[0];
  return friction.term.shape == kLoadOfBodies ? 1.0 + mu : 1.0 / (1.0 - mu);
}

// Compares prior costs [nats]; the recordings fit both explanations equally.
bool is_likelier(const GradedTerm& mass, const GradedTerm& friction) {
  const double mu = friction.parameters[0];
  const double as_gear = find_term_row(&TermRow::backwards).cost + find_term_row(&TermRow::scales_effort).cost +
                         calc_factor_cost(calc_gear_gain(mass, friction));
  const double as_mass = find_term_row(&TermRow::by_load).cost + calc_term_cost(*mass.term.row, mass.parameters);
  return mu > 0.0 && mu < 1.0 && as_gear + kOdds < as_mass;  // the mass needs odds against it, else it stays
}

void replace(GradedTerm* mass, GradedTerm* friction) {
  const double mu = friction->parameters[0], slope = 2.0 / ((1.0 + mu) * (1.0 + mu)),
               k = calc_gear_gain(*mass, *friction);
  const double own = friction->width[0] / (friction->term.shape == kLoadOfBodies ? 1.0 + mu : 1.0 - mu),
               of_mass = mass->width[0] / (1.0 + mass->parameters[0]);
  const Rival rival{mass->term, mass->parameters, mass->width, {}, {}};
  friction->rivals = {{friction->term, friction->parameters, friction->width, {}, {}}, rival};
  friction->term.row = &find_term_row(&TermRow::backwards);
  friction->parameters[0] = calc_backward_loss(mu);
  friction->std *= slope;
  friction->width *= slope;
  friction->share += mass->share;
  friction->weight += mass->weight;
  mass->term = {&find_term_row(&TermRow::scales_effort), friction->term.place};
  mass->place = friction->place;
  mass->parameters = Eigen::VectorXd::Constant(1, 1.0 - k);
  mass->std = mass->width = Eigen::VectorXd::Constant(1, k * std::hypot(own, of_mass));
  mass->named = std::abs(k - 1.0) > std::max(mass->term.row->material, kNinetyFive * mass->width[0]);
  mass->grade = Grade::kAmbiguous;
  mass->rivals = {rival};
  mass->share = mass->weight = 0.0;  // counted for the gear
}

}  // namespace

double calc_gear_gain(const GradedTerm& mass, const GradedTerm& friction) {
  return 1.0 / ((1.0 + mass.parameters[0]) * calc_lift(friction));
}

double calc_backward_loss(double mu) { return 2.0 * mu / (1.0 + mu); }
double calc_loaded_friction(double loss) { return loss / (2.0 - loss); }
double calc_loaded_friction_slope(double loss) { return 2.0 / ((2.0 - loss) * (2.0 - loss)); }

GradedTerm* find_gear(const TorqueDesign& design, const GradedTerm& mass, std::vector<GradedTerm>* graded) {
  if (!mass.term.row->factor) return nullptr;
  const TreeSpec& tree = design.data->experiment->robot.tree;
  const LinkSpec& link = tree.links[static_cast<size_t>(mass.term.place)];
  for (GradedTerm& g : *graded) {
    const bool carries = !g.term.whole() && link.parent == 0 && tree.joint(g.term.place).name == link.joint.name;
    if (g.term.row->by_load && carries && g.named) return &g;
  }
  return nullptr;
}

void explain_by_gears(const TorqueDesign& design, std::vector<GradedTerm>* graded) {
  for (GradedTerm& mass : *graded) {
    GradedTerm* friction = find_gear(design, mass, graded);
    if (!friction) continue;
    relate_to_true_load(1.0 + mass.parameters[0], friction);
    if (is_likelier(mass, *friction)) replace(&mass, friction);
  }
}

}  // namespace hrp::diagnosis
