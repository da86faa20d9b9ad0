// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/generator/prng.h"
#include "diagnosis/generator/robot_plan.h"

namespace hrp::cases {

// One thing that the experiment's model leaves out. Names, places and parameters as the tool's report has them.
struct Hidden {
  std::string effect;
  std::string where_kind;  // joint, link, foot, sensor, ground
  std::string where;
  nlohmann::ordered_json parameters;

  double get(const char* key, double absent = 0) const {
    return parameters.contains(key) ? parameters.at(key).get<double>() : absent;
  }
  Vec3 get3(const char* key) const { return parameters.contains(key) ? parameters.at(key).get<Vec3>() : Vec3{}; }
};

nlohmann::ordered_json to_json(const Hidden& hidden);

// Names of the families a case may belong to, and of the effects that can be asked for by name.
const std::vector<std::string>& joint_effects();
const std::vector<std::string>& link_effects();
const std::vector<std::string>& arm_sensor_effects();
const std::vector<std::string>& foot_effects();
const std::vector<std::string>& biped_sensor_effects();
const std::vector<std::string>& unknown_effects();        // physics outside the tool's list, on arms
const std::vector<std::string>& stand_unknown_effects();  // the same, on standing robots

// Four significant digits, so that the truth prints as it was used.
double tidy(double value);
// Each number within +-size.
Vec3 draw_vector(double size, Prng& random);

// Draws place and size for `effect` on `robot`, scaled by `boost`; `taken` joints are avoided. Feet come in pairs where
// both are soft, hence the list.
std::vector<Hidden> draw_hidden(const std::string& effect, const RobotPlan& robot,
                                const std::vector<std::string>& taken, double boost, Prng& random);

}  // namespace hrp::cases
