// SPDX-License-Identifier: BSD-3-Clause
// Effects of a joint that the tool knows, as the generator hides them: a row says how large an effect is drawn and what
// it does. A new effect is a new row.
#pragma once

#include "diagnosis/generator/joint_reality.h"

namespace hrp::cases {

struct JointEffect {
  const char* name;
  // Parameters as the report has them; sizes follow the servo's stiffness kp [N m/rad], which says how strong a joint
  // is.
  nlohmann::ordered_json (*draw)(const JointPlan& joint, double boost, Prng& random);
  void (*hide)(JointReality& joint, const Hidden& hidden);
};

const std::vector<JointEffect>& list_joint_effects();
const JointEffect* find_joint_effect(const std::string& name);  // null: there is none

}  // namespace hrp::cases
