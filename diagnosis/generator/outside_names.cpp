// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/robot_plan.h"

namespace hrp::cases {
namespace {

using Names = std::vector<std::pair<std::string, std::string>>;

// Inside the generator a biped's parts have one set of names; outside they have those of its maker.
const std::vector<Names>& name_schemes() {
  static const std::vector<Names> schemes{
      {},
      {{"left_", "l_"}, {"right_", "r_"}, {"_sole_link", "_foot"}, {"_foot_ft", "_ankle_ft"}, {"trunk", "torso"}},
      {{"left_", "L_"},
       {"right_", "R_"},
       {"hip_yaw", "HIP_Y"},
       {"hip_roll", "HIP_R"},
       {"hip_pitch", "HIP_P"},
       {"knee", "KNEE"},
       {"ankle_pitch", "ANKLE_P"},
       {"ankle_roll", "ANKLE_R"},
       {"hips", "PELVIS"}},
      {{"left_", "leg0-"}, {"right_", "leg1-"}, {"trunk_imu", "imu"}, {"waist", "torso_joint"}}};
  return schemes;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

}  // namespace

std::string find_outside_name(const RobotPlan& robot, std::string text) {
  const auto& schemes = name_schemes();
  for (const auto& [from, to] : schemes[static_cast<std::size_t>(robot.name_scheme) % schemes.size()])
    replace_all(text, from, to);
  return text;
}

}  // namespace hrp::cases
