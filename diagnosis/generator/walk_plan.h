// SPDX-License-Identifier: BSD-3-Clause
// Robots that walk under our controller, how they walk, what may be hidden in them and what is recorded of them.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/generator/hidden.h"
#include "diagnosis/generator/recorder.h"

namespace hrp::cases {

// A walk as the controller is asked for it.
struct WalkPlan {
  double single_support = 0.7, double_support = 0.2;  // [s]
  double swing_height = 0.05;                         // [m]
  double length = 0.2, side = 0, turn = 0;            // a step [m], [m], [rad]
  int count = 8;
  bool left_first = false, stabilized = true;
  std::string name;
};

// HRP-1S-like or HRP-2P-like with locked arms, their URDFs in the folder `models`, or a biped drawn anew.
RobotPlan make_walker(const std::string& models, Prng& random);
double calc_mass(const RobotPlan& robot);  // [kg]

WalkPlan draw_walk(const RobotPlan& robot, Prng& random);
// The controller's settings, sensors and servos for this robot, as a scenario file has them.
std::string make_walk_scenario(const RobotPlan& robot, const WalkPlan& plan);

// One effect, or two feet's, with sizes that fit a robot of this weight and these legs.
std::vector<Hidden> draw_walk_hidden(const std::string& effect, const RobotPlan& robot,
                                     const std::vector<std::string>& taken, double boost, Prng& random);
const std::vector<std::string>& walk_effects();
const std::vector<std::string>& walk_unknown_effects();

// Endings of column names that this robot does not record. What is hidden stays visible.
std::vector<std::string> draw_missing(const std::vector<Hidden>& hidden, Prng& random);
bool is_missing(const std::vector<std::string>& missing, const std::string& column);

}  // namespace hrp::cases
