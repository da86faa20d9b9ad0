// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/joint_effects.h"

#include <cmath>

#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/effects/effect_target.h"

namespace hrp {
namespace {

ServoGains find_gains(const Scenario& scenario, const JointSpec& joint) {
  const auto at = scenario.servo_joints.find(joint.name);
  ServoGains gains = at == scenario.servo_joints.end() ? scenario.servo_default : at->second;
  if (!std::isfinite(gains.effort_limit)) gains.effort_limit = joint.effort_limit;
  return gains;
}

bool is_unactuated(const Scenario& scenario, const JointSpec& joint) {
  const auto& names = scenario.unactuated;
  return !joint.actuated || has(names, joint.name);
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

void apply_stated_joint_effect(const std::string& joint, const StatedEffect& stated, JointLaws* laws) {
  const EffectInfo* effect = find_effect(stated.effect);
  const std::string field = "joint_laws." + joint + "." + stated.effect;
  if (!effect || effect->place != PlaceKind::kJoint || !effect->reported) refuse_input({"", field}, "unknown effect");
  std::vector<double> values;
  const ValueFault fault = find_values(*effect, stated.parameters, &values);
  if (!fault.message.empty()) refuse_input({"", field + "." + fault.parameter}, fault.message);
  EffectTarget target;
  target.joint = laws;
  effect->apply(values.data(), target);
}

std::vector<JointLaws> make_joint_laws(const Scenario& scenario, TreeSpec* tree) {
  for (const auto& [name, specs] : scenario.joint_laws) {
    if (tree->find_joint(name) < 0) refuse_input({"", "joint_laws." + name}, "the robot has no such joint");
  }
  std::vector<JointLaws> all;
  for (int i = 0; i < tree->num_joints(); ++i) {
    JointSpec& joint = tree->joint(i);
    JointLaws laws = make_nominal_laws(scenario, joint);
    const auto at = scenario.joint_laws.find(joint.name);
    if (at != scenario.joint_laws.end()) {
      for (const StatedEffect& stated : at->second) apply_stated_joint_effect(joint.name, stated, &laws);
    }
    joint.rotor_inertia = laws.elastic ? 0.0 : laws.motor_inertia;
    if (const char* fault = find_law_fault(laws)) refuse_input({"", "joint '" + joint.name + "'"}, fault);
    all.push_back(laws);
  }
  return all;
}

}  // namespace hrp
