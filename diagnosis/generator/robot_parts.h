// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "diagnosis/generator/robot_plan.h"

namespace hrp::cases {

// Solid box of the given mass [kg], its centre at the centre of mass; sizes in m.
void set_box(LinkPlan& link, double mass, const Vec3& com, const Vec3& box);

LinkPlan make_link(const std::string& name, int parent, const std::string& joint_name, const Vec3& xyz,
                   const Vec3& axis);

// Gains and limit of the joint that moves the link (its index) of a fixed base, by what it carries.
void draw_servo(RobotPlan& robot, std::size_t link, Prng& random);

// Rounds to so many significant digits.
double round_to(double value, int digits);

}  // namespace hrp::cases
