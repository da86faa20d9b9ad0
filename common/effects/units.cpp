// SPDX-License-Identifier: BSD-3-Clause
#include "common/effects/units.h"

#include <map>

namespace hrp {

std::string get_joint_unit(const JointSpec& joint, const std::string& unit) {
  static const std::map<std::string, std::string> of_slides{
      {"rad", "m"},           {"rad/s", "m/s"},   {"rad/s^2", "m/s^2"}, {"1/rad", "1/m"},          {"N m", "N"},
      {"N m s/rad", "N s/m"}, {"N m/rad", "N/m"}, {"kg m^2", "kg"},     {"N m/(rad/s)", "N/(m/s)"}};
  const auto it = of_slides.find(unit);
  return joint.kind == JointKind::kPrismatic && it != of_slides.end() ? it->second : unit;
}

std::string get_joint_unit(const JointSpec& joint, const EffectParameter& parameter) {
  return parameter.angle ? parameter.unit : get_joint_unit(joint, parameter.unit);
}

}  // namespace hrp
