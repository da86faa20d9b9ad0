// SPDX-License-Identifier: BSD-3-Clause
// One motor with a disc, whose log tells no unit of its efforts.
#pragma once

#include <string>

#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {

// A disc on a vertical axis: friction, and a rotor of fifty times its inertia, take all of the effort, in whatever
// unit.
inline const std::string kDisc = R"(<robot name="disc"><link name="stand"/>
    <link name="disc"><inertial><mass value="0.1"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.002"/></inertial></link>
    <joint name="motor" type="revolute"><parent link="stand"/><child link="disc"/><axis xyz="0 0 1"/>
      <limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";
// A disc that takes most of its drive's torque, beside dry friction.
inline Experiment simulate_heavy_disc(const std::string& name) {
  std::string disc = kDisc;
  const std::string light = R"(ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.002")";
  disc.replace(disc.find(light), light.size(), R"(ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.2")");
  Experiment e = make_simulated_experiment(name, disc, {"motor"}, {{EffectId::kCoulomb, 0, {0.3, 0.0, 5e-4}}});
  e.scenario.drive = "effort";
  return e;
}

}  // namespace hrp::diagnosis
