// SPDX-License-Identifier: BSD-3-Clause
// What tests of the torque stage share: how to look into a verdict, and what they put into experiments.
#pragma once

#include <cmath>
#include <string>

#include "diagnosis/evidence/torque/findings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {

inline const Finding* find(const TorqueVerdict& verdict, const std::string& effect, const std::string& place) {
  for (const Finding& f : verdict.evidence.findings) {
    if (f.effect == effect && f.where.begin().value() == place) return &f;
  }
  return nullptr;
}

constexpr const char* kPendulum = R"(<robot name="pendulum"><link name="base"/>
    <link name="rod"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
    <joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
      <limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";

// Texture of friction over position: in no list.
inline void add_texture(double amplitude, Experiment* e) {
  for (Recording& r : e->recordings) {
    for (JointColumns& joint : r.joints) {
      for (size_t k = 0; k < r.size(); ++k)
        joint.signal[2][k] += amplitude * std::sin(9.0 * joint.signal[0][k]) * std::tanh(joint.signal[1][k] / 0.05);
    }
  }
}

inline void expect_drives(const TorqueVerdict& verdict, const Hypothesis& hidden) {
  for (const Effect& truth : hidden) {
    const Finding* f = find(verdict, get_effect(truth.id).name, kArmJoints[static_cast<size_t>(truth.place.index)]);
    ASSERT_NE(f, nullptr) << get_effect(truth.id).name << " at joint " << truth.place.index;
    EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
    // 15 %: texture of a tenth of the friction is in no term; it moves viscous friction, the smallest part, most.
    EXPECT_NEAR(f->parameters[0].value[0], truth.p[0], 0.15 * truth.p[0]) << f->statement;
  }
}

// Without them no servo's law tells the effort of a log.
inline void forget_commands(Recording* r) {
  for (JointColumns& joint : r->joints) {
    joint.command.clear();
    joint.command_rate.clear();
  }
}

}  // namespace hrp::diagnosis
