// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/words.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/data/held_out.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/indistinguishable.h"
#include "diagnosis/evidence/torque/rivals.h"
#include "diagnosis/findings/estimate_words.h"

namespace hrp::diagnosis {
namespace {

std::string get_place_name(const Experiment& e, const Term& term) {
  const PlaceKind place = term.row->place;
  if (place == PlaceKind::kJoint) return e.robot.tree.joint(term.place).name;
  return e.robot.tree.links[place == PlaceKind::kLink ? static_cast<size_t>(term.place) : 0].name;
}

bool is_of_link(const Term& term) { return term.row->place != PlaceKind::kJoint; }

Where make_place(const Experiment& e, const Term& term) {
  if (term.row->of_log) return {{"sensor", e.signal_name(term.place, Quantity::kEffort)}};
  return {{is_of_link(term) ? "link" : "joint", get_place_name(e, term)}};
}

// Parameters with the names and units of the effect table, for a revolute joint, from coefficients p with standard
// deviations s.
std::vector<Estimate> list_estimates(const Term& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s) {
  if (term.row->excess)  // the level belongs to another term
    return {make_one("excess", "N m", p[0], s[0]),
            make_one("stribeck_velocity", "rad/s", term.shape, 0.5 * term.shape)};
  const TermValues values = calc_values(term, p, s);
  const std::vector<EffectParameter>& row = term.effect().parameters;
  std::vector<Estimate> list;
  for (size_t i = 0; i < values.value.size(); ++i) {
    if (row[i].axis <= 0) list.push_back({row[i].name, row[i].unit, {}, {}, row[i].axis == 0});
    list.back().value.push_back(values.value[i]);
    list.back().std.push_back(values.std[i]);
  }
  return list;
}

// Parameters of an effect at this joint, from the units of one that turns.
void convert_units(const JointSpec& joint, const EffectInfo& effect, std::vector<Estimate>* list) {
  for (Estimate& estimate : *list) {
    const int at = find_parameter(effect, estimate.name);
    const bool angle = at >= 0 && effect.parameters[static_cast<size_t>(at)].angle;
    if (!angle) estimate.unit = get_joint_unit(joint, estimate.unit);
  }
}

std::vector<Estimate> make_parameters(const Experiment& e, const Term& term, const Eigen::VectorXd& p,
                                      const Eigen::VectorXd& s) {
  std::vector<Estimate> list = list_estimates(term, p, s);
  if (is_of_link(term)) return list;
  convert_units(e.robot.tree.joint(term.place), term.effect(), &list);
  return list;
}

// Alternatives at this joint and in its log state the units of one that turns.
void convert_units(const JointSpec& joint, std::vector<Alternative>* list) {
  for (Alternative& a : *list) {
    const EffectInfo* effect = find_effect(a.effect);
    if (effect && (a.where.contains("joint") || a.where.contains("sensor")))
      convert_units(joint, *effect, &a.parameters);
  }
}

std::string get_phrase(const TermRow& row) {
  return row.is_of_bus() ? row.effect->phrase + ", at all joints alike" : row.effect->phrase;
}

// A constant torque beside dry friction is friction that differs by direction, which says more to whoever knows the
// machine.
std::string make_direction_words(const std::vector<Alternative>& alternatives) {
  for (const Alternative& a : alternatives) {
    if (a.effect != get_effect(EffectId::kCoulomb).name || a.parameters.size() != 2) continue;
    const double level = a.parameters[0].value[0], share = a.parameters[1].value[0];
    return " Or dry friction differs by direction: " + number(level * (1.0 + share), 2) + " " + a.parameters[0].unit +
           " forward, " + number(level * (1.0 - share), 2) + " " + a.parameters[0].unit + " backward.";
  }
  return "";
}

std::string make_statement(const Experiment& e, const GradedTerm& g, const Finding& f, const std::string& phrase) {
  std::string text =
      get_place_name(e, g.term) + ": " + phrase + ", " + describe(f.parameters) + " (" + get_grade_name(f.grade) + ").";
  text += " It takes away " + number(100.0 * std::clamp(g.share, 0.0, 1.0), 2) + " % of the missing torque" +
          (has_held_out(e.recordings) ? " on held-out data." : ".");
  // Alternatives say it themselves.
  if (f.grade == Grade::kAmbiguous && f.alternatives.empty() && g.doubt[0])
    text += std::string(" It is ambiguous because ") + g.doubt + ".";
  if (g.balanced >= 0)
    text += " It follows gravity, and " + e.robot.tree.joint(g.balanced).name +
            " alone shows it: a spring or a counterweight that balances the joint does the same.";
  text += make_direction_words(f.alternatives);
  if (!g.instead.empty()) text += " In its place, " + g.instead + " predicts held-out data better.";
  return text;
}

// A rotor as the link's own inertia, which differs from the model's: less, for a rotor below zero.
Alternative make_own_inertia(const Experiment& e, const Rival& rival) {
  const double own = calc_own_inertia(e.robot.tree, rival.term.place);
  return make_alternative(get_effect(EffectId::kInertiaError),
                          {{"link", e.robot.tree.links[static_cast<size_t>(rival.term.place) + 1].name}},
                          {make_one("scale", "1", 1.0 + rival.parameters[0] / own, rival.width[0] / own)},
                          "swings of other sizes, up to half a turn");
}

// Adds a rival unless its effect is already listed at that place, or is the finding itself there. A delay of the bus is
// listed as one of this joint.
void add_rival(const Experiment& e, const GradedTerm& g, const Rival& rival, std::vector<Alternative>* list) {
  Term term = rival.term;
  if (term.row->is_of_bus() && !g.term.whole()) term.place = g.term.place;
  const bool of_link = is_rotor(term) && (rival.parameters[0] < 0.0 || is_rotor(g.term));
  Alternative a = of_link
                      ? make_own_inertia(e, rival)
                      : make_alternative(term.effect(), make_place(e, term),
                                         make_parameters(e, term, rival.parameters, rival.width), g.term.row->motion);
  const bool same = a.effect == g.term.effect().name && a.where == make_place(e, g.term);
  const bool there = std::any_of(list->begin(), list->end(),
                                 [&](const Alternative& b) { return a.effect == b.effect && a.where == b.where; });
  if (!same && !there) list->push_back(std::move(a));
}

}  // namespace

Finding make_finding(const Experiment& e, const GradedTerm& g, const GradedTerm* excess,
                     const std::vector<Alternative>& alternatives) {
  const TermRow& row = excess ? *excess->term.row : *g.term.row;
  Finding f = make_finding(*row.effect, make_place(e, g.term), make_parameters(e, g.term, g.parameters, g.width));
  if (excess) {
    const auto unit = [&](const char* turning) { return get_joint_unit(e.robot.tree.joint(g.term.place), turning); };
    f.parameters = {make_one("coulomb", unit("N m"), g.parameters[0], g.width[0]),
                    make_one("static", unit("N m"), g.parameters[0] + excess->parameters[0],
                             std::hypot(g.width[0], excess->width[0])),
                    make_one("stribeck_velocity", unit("rad/s"), excess->term.shape, 0.5 * excess->term.shape)};
    if (g.curve.there)
      f.parameters = {make_ranged("coulomb", unit("N m"), g.curve.level, g.width[0]),
                      make_ranged("static", unit("N m"), g.curve.rest, g.width[0]),
                      make_ranged("stribeck_velocity", unit("rad/s"), g.curve.velocity, 0.0)};
  }
  f.grade = g.grade;
  f.probability = std::min(kSurest, g.probability);
  f.share = std::clamp(g.share + (excess ? excess->share : 0.0), 0.0, 1.0);
  f.weight = g.weight + (excess ? excess->weight : 0.0);
  f.alternatives = alternatives;
  if (!is_of_link(g.term)) convert_units(e.robot.tree.joint(g.term.place), &f.alternatives);
  for (const Rival& r : g.rivals) {  // in the units of their own joints
    if (f.alternatives.size() < kMostInList) add_rival(e, g, r, &f.alternatives);
  }
  f.statement = make_statement(e, g, f, get_phrase(row));
  return f;
}

std::optional<Effect> make_effect(const GradedTerm& g, const GradedTerm* excess) {
  if (g.term.row->excess || g.term.row->scales_model) return std::nullopt;
  const EffectInfo& row = excess ? excess->term.effect() : g.term.effect();
  std::vector<double> values = calc_values(g.term, g.parameters, g.width).value;
  if (excess && g.curve.there)
    values = {g.curve.level.value, g.curve.rest.value, g.curve.velocity.value};
  else if (excess)
    values = {values[0], values[0] + excess->parameters[0], excess->term.shape};
  while (values.size() < row.parameters.size()) values.push_back(row.parameters[values.size()].value);
  if (g.term.row->of_log) return Effect{row.id, at_sensor(g.term.place, Reading::kEffort), values};
  return Effect{row.id, g.term.place, values};
}

NotIdentifiable make_detail(const Experiment& e, const GradedTerm& g) {
  std::string why = "it helps to predict, but ";
  const TermValues told = calc_values(g.term, g.parameters, g.width);
  if (!g.helps_held)
    why = "it fits the training recordings, but the held-out ones are predicted worse with it";
  else if (g.gain <= 0.0)
    why += "hardly";
  else if (g.disagrees)
    why += "parts of the recordings give it opposite signs";
  else if (g.unsized)
    why += "its size is not known: " + number(told.value[0], 2) + " +- " + number(kNinetyFive * told.std[0], 2) + " " +
           (is_of_link(g.term) ? g.term.effect().parameters[0].unit
                               : get_joint_unit(e.robot.tree.joint(g.term.place), g.term.effect().parameters[0]));
  else
    why += "takes away only " + number(100.0 * std::clamp(g.share, 0.0, 1.0), 2) + " % of the missing torque";
  return {g.term.effect().name, make_place(e, g.term), why, g.term.row->motion};
}

std::string make_coupled_words(const Experiment& e, int joint, const CoupledDrives& coupled) {
  const std::string own = e.robot.tree.joint(joint).name, unit = get_joint_unit(e.robot.tree.joint(joint), "N m");
  std::string words;
  for (const CoupledDrive& d : coupled.drives) {
    words += (words.empty() ? "dry friction of " : " and of ") + number(d.level, 2) + " " + unit + " at the rate of " +
             own + (d.ratio > 0.0 ? " plus " : " minus ") + number(std::abs(d.ratio), 2) + " times that of " +
             e.robot.tree.joint(d.other).name;
  }
  return words + ": a drive turns with both joints (differential, parallelogram, tendons or shafts inside one another)";
}

std::string make_remaining_words(const Experiment& e, int joint, const Remaining& r, const std::string& follows) {
  return e.robot.tree.joint(joint).name + ": of " + number(r.before, 3) + " " + r.unit +
         " missing torque (root mean square), " + number(r.after, 3) + " " + r.unit + " remain" +
         (follows.empty() ? "." : ", which follow " + follows + ".");
}

}  // namespace hrp::diagnosis
