// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque_words.h"

#include <algorithm>
#include <cmath>

#include "common/effects/units.h"
#include "diagnosis/data/rounding.h"
#include "diagnosis/evidence/torque_twins.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kMostAlternatives = 5;

std::string get_place_name(const Experiment& e, const Term& term) {
  switch (term.kind) {
    case TermKind::kPayload: case TermKind::kMassError: case TermKind::kComError: case TermKind::kForce:
      return e.robot.tree.links[static_cast<size_t>(term.place)].name;
    case TermKind::kTilt:
      return e.robot.tree.links[0].name;
    default:
      return e.robot.tree.joint(term.place).name;
  }
}

bool is_of_link(const Term& term) {
  return term.kind == TermKind::kPayload || term.kind == TermKind::kMassError || term.kind == TermKind::kComError ||
         term.kind == TermKind::kForce || term.kind == TermKind::kTilt;
}

Where make_place(const Experiment& e, const Term& term) {
  return {{is_of_link(term) ? "link" : "joint", get_place_name(e, term)}};
}

Estimate scalar(const char* name, const std::string& unit, double value, double std) {
  return {name, unit, {value}, {std}, false};
}

Estimate vector(const char* name, const char* unit, const Eigen::VectorXd& value, const Eigen::VectorXd& std) {
  return {name, unit, {value.data(), value.data() + value.size()}, {std.data(), std.data() + std.size()}, true};
}

// Parameters of the report from coefficients p with deviations s, at a joint that turns.
std::vector<Estimate> list_estimates(const Term& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s) {
  switch (term.kind) {
    case TermKind::kViscous: return {scalar("coefficient", "N m s/rad", p[0], s[0])};
    case TermKind::kDry: return {scalar("level", "N m", p[0], s[0])};
    case TermKind::kLoadDry: case TermKind::kBackdriven: return {scalar("ratio", "1", p[0], s[0])};
    case TermKind::kStribeck:
      return {scalar("excess", "N m", p[0], s[0]), scalar("stribeck_velocity", "rad/s", term.shape, 0.5 * term.shape)};
    case TermKind::kRotor: return {scalar("inertia", "kg m^2", p[0], s[0])};
    case TermKind::kGain: return {scalar("scale", "1", 1.0 - p[0], s[0])};
    case TermKind::kGainOfModel: return {scalar("scale", "1", 1.0 / (1.0 + p[0]), s[0])};
    case TermKind::kConstant: return {scalar("torque", "N m", p[0], s[0])};
    case TermKind::kSpring: {
      const double rest = p[0] != 0.0 ? -p[1] / p[0] : 0.0;
      return {scalar("stiffness", "N m/rad", p[0], s[0]),
              scalar("rest", "rad", rest, std::hypot(s[1], rest * s[0]) / std::max(1e-12, std::abs(p[0])))};
    }
    case TermKind::kLag: return {scalar("time_constant", "s", p[0], s[0])};
    case TermKind::kCommandDelay: case TermKind::kBusDelay: return {scalar("delay", "s", p[0], s[0])};
    case TermKind::kCogging:
      return {scalar("amplitude", "N m", p.norm(), s[0]), scalar("periods", "1/rad", term.shape, 0.1 * term.shape),
              scalar("phase", "rad", std::atan2(p[1], p[0]), s[0] / std::max(1e-12, p.norm()))};
    case TermKind::kPayload:
      return {scalar("mass", "kg", p[0], s[0]), vector("com", "m", p.tail<3>() / p[0], s.tail<3>() / std::abs(p[0]))};
    case TermKind::kMassError: return {scalar("scale", "1", 1.0 + p[0], s[0])};
    case TermKind::kComError: return {vector("offset", "m", p, s)};
    case TermKind::kForce: return {vector("force", "N", p, s)};
    case TermKind::kOffset: return {scalar("offset", "rad", p[0], s[0])};
    case TermKind::kTilt: return {scalar("roll", "rad", p[0], s[0]), scalar("pitch", "rad", p[1], s[1])};
  }
  return {};
}

std::vector<Estimate> make_parameters(const Experiment& e, const Term& term, const Eigen::VectorXd& p,
                                      const Eigen::VectorXd& s) {
  std::vector<Estimate> list = list_estimates(term, p, s);
  if (is_of_link(term)) return list;
  for (Estimate& estimate : list) estimate.unit = get_joint_unit(e.robot.tree.joint(term.place), estimate.unit);
  return list;
}

std::string describe(const std::vector<Estimate>& parameters) {
  std::string text;
  for (const Estimate& e : parameters) {
    std::string value;
    for (size_t i = 0; i < e.value.size(); ++i)
      value += (i > 0 ? ", " : "") + number(e.value[i], 3) + " +- " + number(1.96 * e.std[i], 2);
    text += (text.empty() ? "" : ", ") + e.name + " " + (e.vector ? "(" + value + ")" : value) +
            (e.unit == "1" ? "" : " " + e.unit);
  }
  return text;
}

const char* get_phrase(TermKind kind) {
  switch (kind) {
    case TermKind::kViscous: return "viscous friction";
    case TermKind::kDry: return "dry friction";
    case TermKind::kLoadDry: return "dry friction that grows with the load";
    case TermKind::kBackdriven: return "a gear that loses more when the load turns it than when the motor does";
    case TermKind::kStribeck: return "dry friction that is larger at rest";
    case TermKind::kRotor: return "reflected inertia of the rotor";
    case TermKind::kGain: case TermKind::kGainOfModel: return "a wrong torque constant";
    case TermKind::kConstant: return "a constant torque";
    case TermKind::kSpring: return "a spring across the joint";
    case TermKind::kLag: return "a drive that lags";
    case TermKind::kCommandDelay: return "commands that arrive late";
    case TermKind::kBusDelay: return "commands that arrive late, at all joints alike";
    case TermKind::kCogging: return "torque that ripples with position";
    case TermKind::kPayload: return "a load";
    case TermKind::kMassError: return "a wrong mass";
    case TermKind::kComError: return "a centre of mass elsewhere";
    case TermKind::kForce: return "a constant force";
    case TermKind::kOffset: return "an encoder whose zero is off";
    case TermKind::kTilt: return "a base that is tilted";
  }
  return "";
}

const char* get_motion(TermKind kind) {
  switch (kind) {
    case TermKind::kDry: case TermKind::kLoadDry: case TermKind::kBackdriven: case TermKind::kStribeck: case TermKind::kViscous:
      return "constant speeds, slow and fast, in both directions, in postures of different load";
    case TermKind::kRotor: case TermKind::kLag: case TermKind::kCommandDelay: case TermKind::kBusDelay:
      return "short, fast reversals of this joint alone";
    case TermKind::kConstant: case TermKind::kSpring: case TermKind::kOffset: case TermKind::kCogging:
      return "slow sweeps of the joint over its whole range, in postures of different load";
    default:
      return "postures held, and slow motion of every joint, with a known mass hung on and without";
  }
}

std::string make_statement(const Experiment& e, const GradedTerm& g, const Finding& f, const char* phrase) {
  std::string text = get_place_name(e, g.term) + ": " + phrase + ", " + describe(f.parameters) + " (" +
                     get_grade_name(f.grade) + ").";
  text += " It takes away " + number(100.0 * std::max(0.0, g.share), 2) + " % of the missing torque on held-out data.";
  if (f.alternatives.empty()) return text;
  text += " These recordings cannot tell it from";
  for (size_t i = 0; i < f.alternatives.size(); ++i)
    text += (i == 0 ? " " : ", ") + f.alternatives[i].effect + " (" + describe(f.alternatives[i].parameters) + ")";
  return text + ".";
}

}  // namespace

Finding make_finding(const Experiment& e, const GradedTerm& g, const GradedTerm* excess,
                     const std::vector<Alternative>& twins) {
  Finding f;
  f.effect = excess ? get_effect_name(TermKind::kStribeck) : get_effect_name(g.term.kind);
  f.family = get_family_name(get_family(g.term.kind));
  f.where = make_place(e, g.term);
  f.parameters = make_parameters(e, g.term, g.parameters, g.width);
  if (excess) {
    const auto unit = [&](const char* turning) { return get_joint_unit(e.robot.tree.joint(g.term.place), turning); };
    f.parameters = {scalar("coulomb", unit("N m"), g.parameters[0], g.width[0]),
                    scalar("static", unit("N m"), g.parameters[0] + excess->parameters[0], std::hypot(g.width[0], excess->width[0])),
                    scalar("stribeck_velocity", unit("rad/s"), excess->term.shape, 0.5 * excess->term.shape)};
    if (g.curve.there)
      f.parameters = {make_ranged("coulomb", unit("N m"), g.curve.level, g.width[0]),
                      make_ranged("static", unit("N m"), g.curve.rest, g.width[0]),
                      make_ranged("stribeck_velocity", unit("rad/s"), g.curve.velocity, 0.0)};
  }
  f.grade = g.grade;
  f.probability = std::min(0.99, g.probability);
  f.share = std::clamp(g.share + (excess ? excess->share : 0.0), 0.0, 1.0);
  f.weight = g.weight + (excess ? excess->weight : 0.0);
  f.alternatives = twins;
  for (const Rival& r : g.rivals) {
    if (f.alternatives.size() == kMostAlternatives) break;
    const Eigen::VectorXd std = 0.5 * r.parameters.cwiseAbs();
    f.alternatives.push_back({get_effect_name(r.term.kind), get_family_name(get_family(r.term.kind)), make_place(e, r.term),
                              make_parameters(e, r.term, r.parameters, std), get_motion(g.term.kind)});
  }
  f.statement = make_statement(e, g, f, get_phrase(excess ? TermKind::kStribeck : g.term.kind));
  return f;
}

std::optional<Effect> make_effect(const GradedTerm& g, const GradedTerm* excess) {
  const Eigen::VectorXd& p = g.parameters;
  const auto make = [&](EffectId id, std::vector<double> values) -> Effect { return {id, g.term.place, std::move(values)}; };
  switch (g.term.kind) {
    case TermKind::kViscous: return make(EffectId::kViscous, {p[0]});
    case TermKind::kDry:
      if (excess && g.curve.there)
        return make(EffectId::kStribeck,
                    {g.curve.level.value, g.curve.rest.value, g.curve.velocity.value, 0.0, kPresliding});
      if (excess)
        return make(EffectId::kStribeck,
                    {p[0], p[0] + excess->parameters[0], excess->term.shape, 0.0, kPresliding});
      return make(EffectId::kCoulomb, {p[0], 0.0, kPresliding});
    case TermKind::kLoadDry: return make(EffectId::kLoadFriction, {p[0], kPresliding});
    case TermKind::kBackdriven: return make(get_effect_id(g.term.kind), {p[0], kPresliding});
    case TermKind::kRotor: return make(EffectId::kRotorInertia, {p[0]});
    case TermKind::kGain: return make(EffectId::kTorqueConstant, {1.0 - p[0]});
    case TermKind::kSpring: return make(EffectId::kSpring, {p[0], p[0] != 0.0 ? -p[1] / p[0] : 0.0});
    case TermKind::kLag: return make(EffectId::kLag, {p[0]});
    case TermKind::kCommandDelay: case TermKind::kBusDelay: return make(EffectId::kDelay, {p[0]});
    case TermKind::kCogging: return make(EffectId::kCogging, {p.norm(), g.term.shape, std::atan2(p[1], p[0])});
    case TermKind::kPayload: return make(EffectId::kPayload, {p[0], p[1] / p[0], p[2] / p[0], p[3] / p[0], 0.0});
    case TermKind::kMassError: return make(EffectId::kMassError, {1.0 + p[0]});
    case TermKind::kComError: return make(EffectId::kComError, {p[0], p[1], p[2]});
    case TermKind::kForce: return make(EffectId::kExternalForce, {p[0], p[1], p[2]});
    case TermKind::kOffset: return make(EffectId::kJointOffset, {p[0]});
    case TermKind::kConstant: return make(get_effect_id(TermKind::kConstant), {p[0]});
    case TermKind::kTilt: return make(get_effect_id(TermKind::kTilt), {p[0], p[1]});
    default: return std::nullopt;
  }
}

NotIdentifiable make_detail(const Experiment& e, const GradedTerm& g) {
  std::string why = "it helps to predict, but ";
  if (!g.helps_held)
    why = "it fits the training recordings, but the held-out ones are predicted worse with it";
  else if (g.gain <= 0.0)
    why += "hardly";
  else
    why += "takes away only " + number(100.0 * std::max(0.0, g.share), 2) + " % of the missing torque";
  return {get_effect_name(g.term.kind), make_place(e, g.term), why, get_motion(g.term.kind)};
}

std::string make_remaining_words(const Experiment& e, int joint, const Remaining& r, const std::string& follows) {
  return e.robot.tree.joint(joint).name + ": of " + number(r.before, 3) + " " + r.unit + " missing torque (root mean square), " +
         number(r.after, 3) + " " + r.unit + " remain" + (follows.empty() ? "." : ", which follow " + follows + ".");
}

}  // namespace hrp::diagnosis
