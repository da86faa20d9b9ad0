// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "diagnosis/generator/robot_plan.h"

namespace hrp::cases {

// Solid box of the given mass [kg], its centre at the centre of mass; sizes in m.
void set_box(LinkPlan& link, double mass, const Vec3& com, const Vec3& box);

LinkPlan make_link(const std::string& name, int parent, const std::string& joint_name, const Vec3& xyz,
                   const Vec3& axis);

// Gains and limit of the joint that moves the link (its index) of a fixed base, by what it carries.
void draw_servo(RobotPlan& robot, std::size_t link, Prng& random);

// Hip, knee, ankle pitch of a robot from a URDF, as level_leg() has them.
Vec3 level_any_leg(const RobotPlan& robot, double knee);

// Where a link is from the base, with joints at the given angles.
Eigen::Isometry3d calc_pose(const RobotPlan& robot, int link, const std::vector<double>& q);

// Lowest points of each link's boxes and spheres, in its frame.
using SolePoints = std::vector<std::vector<Eigen::Vector3d>>;

// The links of a URDF with what is fixed to them, no gains yet; `points` may be null.
RobotPlan read_urdf_links(const std::string& urdf_path, SolePoints* points);

// Rounds to so many significant digits.
double round_to(double value, int digits);

}  // namespace hrp::cases
