// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/joint_effects.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

constexpr double kInf = kUnlimited;
// A transmission that is stiff for any purpose, for a backlash whose teeth are not given.
constexpr double kToothStiffness = 1.0e4;  // [N m/rad]
constexpr double kToothDamping = 3.0;      // [N m s/rad]

void set_elastic(JointLaws* laws, double stiffness, double damping, double inertia) {
  laws->elastic = true;
  laws->stiffness = stiffness;
  laws->damping = damping;
  if (inertia > 0.0) laws->motor_inertia = inertia;
}

std::vector<JointEffect> make_drive_effects() {
  return {
      {"torque_constant_error", "true torque = scale x logged effort",
       {{"scale", "1", true, 1.0, 0.0, 10.0}}, [](const double* p, JointLaws* laws) { laws->torque_scale = p[0]; }},
      {"torque_saturation", "the true torque saturates below what is logged",
       {{"limit", "N m", true, 100.0, 0.0, kInf}}, [](const double* p, JointLaws* laws) { laws->saturation = p[0]; }},
      {"actuator_lag", "the true torque follows the logged effort with a first-order lag",
       {{"time_constant", "s", true, 0.01, 0.0, 1.0}}, [](const double* p, JointLaws* laws) { laws->lag = p[0]; }},
      {"command_delay", "the servo sees its references late",
       {{"delay", "s", true, 0.01, 0.0, 1.0}}, [](const double* p, JointLaws* laws) { laws->command_delay = p[0]; }},
      {"joint_offset", "the encoder reads true + offset",
       {{"offset", "rad", true, 0.0, -3.2, 3.2}}, [](const double* p, JointLaws* laws) { laws->joint_offset = p[0]; }},
  };
}

std::vector<JointEffect> make_friction_effects() {
  return {
      {"viscous_friction", "friction grows with speed",
       {{"coefficient", "N m s/rad", true, 1.0, 0.0, kInf}},
       [](const double* p, JointLaws* laws) { laws->viscous += p[0]; }},
      {"coulomb_friction", "friction of a fixed level against motion",
       {{"level", "N m", true, 1.0, 0.0, kInf}, {"asymmetry", "1", false, 0.0, -1.0, 1.0}},
       [](const double* p, JointLaws* laws) {
         laws->coulomb += p[0];
         laws->asymmetry = p[1];
       }},
      {"stribeck_friction", "more friction at rest than in motion",
       {{"coulomb", "N m", true, 1.0, 0.0, kInf},
        {"static", "N m", true, 2.0, 0.0, kInf},
        {"stribeck_velocity", "rad/s", true, 0.1, 1e-6, kInf},
        {"viscous", "N m s/rad", false, 0.0, 0.0, kInf}},
       [](const double* p, JointLaws* laws) {
         laws->static_level = laws->coulomb + p[1];
         laws->coulomb += p[0];
         laws->stribeck_velocity = p[2];
         laws->viscous += p[3];
       }},
      {"load_dependent_friction", "the friction level grows with the drive's effort",
       {{"ratio", "1", true, 0.1, 0.0, 1.0}}, [](const double* p, JointLaws* laws) { laws->load_ratio = p[0]; }},
      {"cogging", "effort that ripples with position",
       {{"amplitude", "N m", true, 1.0, -kInf, kInf},
        {"periods", "1/rad", true, 20.0, 0.0, kInf},
        {"phase", "rad", false, 0.0, -kInf, kInf}},
       [](const double* p, JointLaws* laws) {
         laws->cogging_amplitude = p[0];
         laws->cogging_periods = p[1];
         laws->cogging_phase = p[2];
       }},
  };
}

std::vector<JointEffect> make_transmission_effects() {
  return {
      {"rotor_inertia", "reflected inertia of the rotor",
       {{"inertia", "kg m^2", true, 0.1, 0.0, kInf}},
       [](const double* p, JointLaws* laws) { laws->motor_inertia = p[0]; }},
      {"joint_elasticity", "the transmission gives; encoder on the motor side",
       {{"stiffness", "N m/rad", true, 1000.0, 1e-3, kInf},
        {"damping", "N m s/rad", true, 1.0, 0.0, kInf},
        {"rotor_inertia", "kg m^2", true, 0.1, 1e-9, kInf}},
       [](const double* p, JointLaws* laws) { set_elastic(laws, p[0], p[1], p[2]); }},
      {"backlash", "the teeth have play; encoder on the motor side",
       {{"gap", "rad", true, 0.005, 0.0, 1.0},
        {"stiffness", "N m/rad", false, kToothStiffness, 1e-3, kInf},
        {"damping", "N m s/rad", false, kToothDamping, 0.0, kInf},
        {"rotor_inertia", "kg m^2", false, 0.0, 0.0, kInf}},
       [](const double* p, JointLaws* laws) {
         if (!laws->elastic) set_elastic(laws, p[1], p[2], p[3]);
         laws->gap = p[0];
       }},
      {"parallel_spring", "a spring beside the joint",
       {{"stiffness", "N m/rad", true, 10.0, 0.0, kInf}, {"rest", "rad", false, 0.0, -kInf, kInf}},
       [](const double* p, JointLaws* laws) {
         const double k = laws->spring_stiffness + p[0];
         if (k > 0.0) laws->spring_rest = (laws->spring_stiffness * laws->spring_rest + p[0] * p[1]) / k;
         laws->spring_stiffness = k;
       }},
      {"hysteresis", "elastic friction that remembers (Bouc-Wen)",
       {{"stiffness", "N m/rad", true, 100.0, 0.0, kInf}, {"yield_angle", "rad", true, 0.01, 1e-9, kInf}},
       [](const double* p, JointLaws* laws) {
         laws->hysteresis_stiffness = p[0];
         laws->hysteresis_yield = p[1];
       }},
  };
}

[[noreturn]] void fail(const std::string& field, const std::string& message) {
  Diagnostic diagnostic;
  diagnostic.field = field;
  diagnostic.message = message;
  throw InputError(diagnostic);
}

ServoGains find_gains(const Scenario& scenario, const JointSpec& joint) {
  const auto at = scenario.servo_joints.find(joint.name);
  ServoGains gains = at == scenario.servo_joints.end() ? scenario.servo_default : at->second;
  if (!std::isfinite(gains.effort_limit)) gains.effort_limit = joint.effort_limit;
  return gains;
}

bool is_unactuated(const Scenario& scenario, const JointSpec& joint) {
  const auto& names = scenario.unactuated;
  return !joint.actuated || std::find(names.begin(), names.end(), joint.name) != names.end();
}

// Of the roll and pitch joints of a foot's bush (common/robot/foot_bush.h names them) [1/rad^2].
double find_bush_hardening(const Scenario& scenario, const std::string& joint) {
  for (const auto& [foot, bush] : scenario.foot_bush) {
    if (bush.hardening_angle <= 0.0 || (joint != foot + "_bush_roll" && joint != foot + "_bush_pitch")) continue;
    return 1.0 / (bush.hardening_angle * bush.hardening_angle);
  }
  return 0.0;
}

JointLaws make_nominal_laws(const Scenario& scenario, const JointSpec& joint) {
  JointLaws laws;
  if (!is_unactuated(scenario, joint) && scenario.drive != "effort") {
    const ServoGains gains = find_gains(scenario, joint);
    laws.kp = gains.kp;
    laws.kd = gains.kd;
    laws.effort_limit = gains.effort_limit;
  }
  laws.viscous = joint.viscous_friction;
  laws.coulomb = joint.coulomb_friction;
  laws.spring_stiffness = joint.spring.stiffness;
  laws.spring_damping = joint.spring.damping;
  laws.spring_rest = joint.spring.rest;
  laws.spring_hardening = find_bush_hardening(scenario, joint.name);
  laws.motor_inertia = joint.rotor_inertia;
  const auto rotor = scenario.rotor_inertia.find(joint.name);
  if (rotor != scenario.rotor_inertia.end()) laws.motor_inertia = rotor->second;
  return laws;
}

}  // namespace

const std::vector<JointEffect>& list_joint_effects() {
  static const std::vector<JointEffect> effects = [] {
    std::vector<JointEffect> all = make_friction_effects();
    for (auto* make : {&make_transmission_effects, &make_drive_effects}) {
      for (JointEffect& effect : (*make)()) all.push_back(std::move(effect));
    }
    return all;
  }();
  return effects;
}

const JointEffect* find_joint_effect(const std::string& name) {
  for (const JointEffect& effect : list_joint_effects()) {
    if (name == effect.name) return &effect;
  }
  return nullptr;
}

void apply_joint_effect(const std::string& joint, const JointLawSpec& spec, JointLaws* laws) {
  const std::string field = "joint_laws." + joint + "." + spec.effect;
  const JointEffect* effect = find_joint_effect(spec.effect);
  if (!effect) fail(field, "unknown effect");
  std::vector<double> values;
  for (const EffectParameter& parameter : effect->parameters) {
    const auto at = spec.parameters.find(parameter.name);
    if (at == spec.parameters.end() && parameter.required) fail(field + "." + parameter.name, "missing");
    const double value = at == spec.parameters.end() ? parameter.value : at->second;
    if (!(value >= parameter.lower && value <= parameter.upper)) {
      fail(field + "." + parameter.name, "is " + std::to_string(value) + " " + parameter.unit + ", expected " +
                                             std::to_string(parameter.lower) + " to " +
                                             std::to_string(parameter.upper));
    }
    values.push_back(value);
  }
  for (const auto& [name, value] : spec.parameters) {
    const auto same = [&n = name](const EffectParameter& parameter) { return n == parameter.name; };
    if (std::none_of(effect->parameters.begin(), effect->parameters.end(), same)) fail(field + "." + name, "unknown");
  }
  effect->apply(values.data(), laws);
}

std::vector<JointLaws> make_joint_laws(const Scenario& scenario, TreeSpec* tree) {
  for (const auto& [name, specs] : scenario.joint_laws) {
    if (tree->find_joint(name) < 0) fail("joint_laws." + name, "the robot has no such joint");
  }
  std::vector<JointLaws> all;
  for (int i = 0; i < tree->num_joints(); ++i) {
    JointSpec& joint = tree->joint(i);
    JointLaws laws = make_nominal_laws(scenario, joint);
    const auto at = scenario.joint_laws.find(joint.name);
    if (at != scenario.joint_laws.end()) {
      for (const JointLawSpec& spec : at->second) apply_joint_effect(joint.name, spec, &laws);
    }
    joint.rotor_inertia = laws.elastic ? 0.0 : laws.motor_inertia;
    if (const char* fault = find_law_fault(laws)) fail("joint '" + joint.name + "'", fault);
    all.push_back(laws);
  }
  return all;
}

}  // namespace hrp
