// SPDX-License-Identifier: BSD-3-Clause
// Effects of a joint by name: parameters with units and bounds, and how each changes the joint's laws. The names are
// those of the diagnosis tool's list; scenario.joint_laws switches them on.
#pragma once

#include <string>
#include <vector>

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "servers/dynamics/joint_law.h"

namespace hrp {

struct EffectParameter {
  const char* name;
  const char* unit;
  bool required;
  double value;         // default; for required ones a value of usual size to start a search from
  double lower, upper;  // bounds
};

struct JointEffect {
  const char* name;
  const char* meaning;  // one sentence in plain words
  std::vector<EffectParameter> parameters;
  // Puts parameter values (in the order above) into the laws.
  void (*apply)(const double* values, JointLaws* laws);
};

const std::vector<JointEffect>& list_joint_effects();
const JointEffect* find_joint_effect(const std::string& name);

// Switches an effect on. Throws InputError naming joint, effect, parameter, value and bounds.
void apply_joint_effect(const std::string& joint, const JointLawSpec& spec, JointLaws* laws);

// Laws of every joint of the tree as the scenario has them. Moves rotor inertias of elastic joints from the tree to
// the motor side and puts those of the scenario in. Throws InputError.
std::vector<JointLaws> make_joint_laws(const Scenario& scenario, TreeSpec* tree);

}  // namespace hrp
