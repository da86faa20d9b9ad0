// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/generator/robot_parts.h"

namespace hrp::cases {
namespace {

// What both legs share: sizes drawn once.
struct LegPlan {
  double foot_length = 0.24, foot_width = 0.13, foot_drop = 0.09, foot_forward = 0.02;  // for 0.6 m of leg [m]
  bool roll_before_yaw = false;
};

LegPlan draw_leg(Prng& random) {
  return {random.uniform(0.2, 0.28), random.uniform(0.1, 0.15), random.uniform(0.06, 0.11), random.uniform(0.0, 0.035),
          random.chance(0.3)};
}

void add_leg(RobotPlan& robot, const std::string& side, double sign, const LegPlan& plan) {
  const double hip = robot.base_position[0];  // half hip width, kept there while the robot is built
  const double thigh = robot.thigh, shank = robot.shank, size = (thigh + shank) / 0.6;
  auto add = [&](const char* name, int parent, const char* joint_name, const Vec3& xyz, const Vec3& axis) {
    robot.links.push_back(make_link(side + name, parent, side + joint_name, xyz, axis));
    return static_cast<int>(robot.links.size()) - 1;
  };
  const double m = size * size;
  const Vec3 first{0, sign * hip, -0.05}, x{1, 0, 0}, z{0, 0, 1};
  int at = plan.roll_before_yaw ? add("_hip_roll_link", 0, "_hip_roll", first, x)
                                : add("_hip_yaw_link", 0, "_hip_yaw", first, z);
  set_box(robot.links.back(), 1.1 * m, {0, 0, 0}, {0.1, 0.1, 0.1});
  at = plan.roll_before_yaw ? add("_hip_yaw_link", at, "_hip_yaw", {}, z)
                            : add("_hip_roll_link", at, "_hip_roll", {}, x);
  set_box(robot.links.back(), 1.5 * m, {0, 0, 0}, {0.11, 0.11, 0.11});
  at = add("_thigh", at, "_hip_pitch", {0, 0, 0}, {0, 1, 0});
  set_box(robot.links.back(), 4.5 * m, {0, 0, -0.46 * thigh}, {0.12, 0.13, thigh});
  at = add("_shank", at, "_knee", {0, 0, -thigh}, {0, 1, 0});
  set_box(robot.links.back(), 3.1 * m, {0.005, 0, -0.42 * shank}, {0.1, 0.1, shank});
  at = add("_ankle_link", at, "_ankle_pitch", {0, 0, -shank}, {0, 1, 0});
  set_box(robot.links.back(), 0.6 * m, {0, 0, 0}, {0.07, 0.07, 0.07});
  at = add("_sole_link", at, "_ankle_roll", {0, 0, 0}, {1, 0, 0});
  const double length = plan.foot_length * size, width = plan.foot_width * size, drop = plan.foot_drop * size;
  const double forward = plan.foot_forward * size;
  set_box(robot.links.back(), 1.6 * m, {forward, 0, -0.6 * drop}, {length, width, 0.05});
  robot.feet.push_back({at, side + "_foot_ft", {forward, 0, -drop + 0.01}, {length, width, 0.02}});
}

void add_arm(RobotPlan& robot, const std::string& side, double sign, int torso, double size) {
  robot.links.push_back(
      make_link(side + "_upper_arm", torso, side + "_shoulder", {0, sign * 0.2 * size, 0.33 * size}, {0, 1, 0}));
  const int upper = static_cast<int>(robot.links.size()) - 1;
  set_box(robot.links.back(), 2.2 * size, {0, sign * 0.02, -0.13 * size}, {0.08, 0.08, 0.27 * size});
  robot.links.push_back(make_link(side + "_lower_arm", upper, side + "_elbow", {0, 0, -0.27 * size}, {0, 1, 0}));
  set_box(robot.links.back(), 1.6 * size, {0, 0, -0.13 * size}, {0.07, 0.07, 0.26 * size});
  robot.links.back().joint.start = -0.5;
}

void draw_biped_servos(RobotPlan& robot, double mass, Prng& random) {
  const double stiff = random.uniform(38, 62), damp = random.uniform(0.016, 0.026);
  for (std::size_t i = 1; i < robot.links.size(); ++i) {
    JointPlan& joint = robot.links[i].joint;
    const bool arm = joint.name.find("shoulder") != std::string::npos || joint.name.find("elbow") != std::string::npos;
    joint.kp = round_to(arm ? 4.0 * mass : stiff * mass, 3);
    joint.kd = round_to(joint.kp * (arm ? 0.05 : damp), 3);
    joint.limit = round_to(arm ? mass : 6 * mass, 2);
  }
}

}  // namespace

Vec3 level_leg(const RobotPlan& robot, double knee) {
  if (robot.thigh == 0) return level_any_leg(robot, knee);
  const double hip = -std::atan2(robot.shank * std::sin(knee), robot.thigh + robot.shank * std::cos(knee));
  return {hip, knee, -(hip + knee)};
}

RobotPlan make_biped(Prng& random) {
  const double size = random.log_uniform(0.55, 1.5);
  RobotPlan robot;
  robot.name = "stander";
  robot.floating = true;
  robot.thigh = 0.3 * size * random.uniform(0.9, 1.1);
  robot.shank = 0.3 * size * random.uniform(0.9, 1.1);
  robot.leg = robot.thigh + robot.shank;
  robot.links.push_back({});
  robot.links[0].name = "hips";
  set_box(robot.links[0], 10 * size * size, {0, 0, 0.04}, {0.18, 0.26 * size, 0.16});
  robot.base_position[0] = 0.09 * size;
  const LegPlan leg_plan = draw_leg(random);
  add_leg(robot, "left", 1, leg_plan);
  add_leg(robot, "right", -1, leg_plan);
  const Vec3 waist_axis = random.chance(0.6) ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  robot.links.push_back(make_link("trunk", 0, "waist", {0, 0, 0.11 * size}, waist_axis));
  const int trunk = static_cast<int>(robot.links.size()) - 1;
  set_box(robot.links.back(), 15 * size * size * random.uniform(0.8, 1.2), {random.uniform(-0.01, 0.01), 0, 0.2 * size},
          {0.2, 0.3 * size, 0.4 * size});
  if (random.chance(0.6)) {
    add_arm(robot, "left", 1, trunk, size);
    add_arm(robot, "right", -1, trunk, size);
  }
  double mass = 0;
  for (const LinkPlan& link : robot.links) mass += link.mass;
  for (std::size_t i = 1; i < robot.links.size(); ++i) robot.links[i].joint.role = robot.links[i].joint.name;
  draw_biped_servos(robot, mass, random);
  robot.imu = "trunk_imu";
  robot.imu_link = trunk;
  robot.imu_xyz = {0, random.uniform(-0.02, 0.02), random.uniform(0.1, 0.3) * size};
  const Vec3 leg = level_leg(robot, random.uniform(0.4, 0.8));
  for (const char* side : {"left", "right"}) {
    joint(robot, find_joint(robot, std::string(side) + "_hip_pitch")).start = round_to(leg[0], 4);
    joint(robot, find_joint(robot, std::string(side) + "_knee")).start = round_to(leg[1], 4);
    joint(robot, find_joint(robot, std::string(side) + "_ankle_pitch")).start = round_to(leg[2], 4);
  }
  const double sole = robot.feet[0].center[2] - robot.feet[0].size[2] / 2;
  const double height = 0.05 + robot.thigh * std::cos(leg[0]) + robot.shank * std::cos(leg[0] + leg[1]) - sole;
  robot.base_position = {0, 0, std::round(height * 1e4) / 1e4};
  robot.name_scheme = random.below(4);
  robot.ground_friction = random.pick(std::vector<double>{0.7, 0.8, 1.0});
  return robot;
}

}  // namespace hrp::cases
