// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/robot_plan.h"

#include <algorithm>
#include <cmath>

namespace hrp::cases {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Solid box of the given mass, its centre at the centre of mass.
void set_box(LinkPlan& link, double mass, const Vec3& com, const Vec3& box) {
  const double x = box[0] * box[0], y = box[1] * box[1], z = box[2] * box[2];
  link.mass = mass;
  link.com = com;
  link.box = box;
  link.inertia = {mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12, 0, 0, 0};
}

LinkPlan make_link(const std::string& name, int parent, const std::string& joint_name, const Vec3& xyz,
                   const Vec3& axis) {
  LinkPlan link;
  link.name = name;
  link.parent = parent;
  link.joint.name = joint_name;
  link.joint.xyz = xyz;
  link.joint.axis = axis;
  return link;
}

// Mass times squared distance of everything outboard, arms stretched: an upper bound of what the joint turns.
double outboard_inertia(const RobotPlan& robot, std::size_t first) {
  double inertia = 0, reach = 0;
  for (std::size_t i = first; i < robot.links.size(); ++i) {
    const LinkPlan& link = robot.links[i];
    if (i > first) reach += std::hypot(link.joint.xyz[0], link.joint.xyz[1], link.joint.xyz[2]);
    const double r = reach + std::hypot(link.com[0], link.com[1], link.com[2]);
    inertia += link.mass * r * r + (link.inertia[0] + link.inertia[1] + link.inertia[2]) / 3;
  }
  return inertia;
}

double outboard_moment(const RobotPlan& robot, std::size_t first) {
  double moment = 0, reach = 0;
  for (std::size_t i = first; i < robot.links.size(); ++i) {
    const LinkPlan& link = robot.links[i];
    if (i > first) reach += std::hypot(link.joint.xyz[0], link.joint.xyz[1], link.joint.xyz[2]);
    moment += link.mass * 9.81 * (reach + std::hypot(link.com[0], link.com[1], link.com[2]));
  }
  return moment;
}

double round_to(double value, int digits) {
  if (value == 0) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - digits + 1);
  return std::round(value / unit) * unit;
}

void draw_arm_servo(RobotPlan& robot, std::size_t i, Prng& random) {
  JointPlan& joint = robot.links[i].joint;
  const double bandwidth = random.uniform(24, 42);  // [rad/s]
  const double inertia = outboard_inertia(robot, i), moment = outboard_moment(robot, i);
  joint.kp = round_to(std::max(inertia * bandwidth * bandwidth, moment * random.uniform(15, 30)), 3);
  joint.kd = round_to(joint.kp * random.uniform(0.025, 0.045), 3);
  joint.limit = round_to(std::max(3.0 * moment, joint.kp * random.uniform(0.15, 0.3)), 2);
}

Vec3 draw_axis(std::size_t i, Prng& random) {
  static const std::vector<Vec3> axes{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  if (i == 1) return random.chance(0.5) ? axes[0] : axes[1];
  return random.chance(0.6) ? axes[1] : random.pick(axes);
}

void add_leg(RobotPlan& robot, const std::string& side, double sign, Prng& random) {
  (void)random;
  const double hip = robot.base_position[0];  // half hip width, kept there while the robot is built
  const double thigh = robot.thigh, shank = robot.shank, size = (thigh + shank) / 0.6;
  auto add = [&](const char* name, int parent, const char* joint_name, const Vec3& xyz, const Vec3& axis) {
    robot.links.push_back(make_link(side + name, parent, side + joint_name, xyz, axis));
    return static_cast<int>(robot.links.size()) - 1;
  };
  const double m = size * size;
  int at = add("_hip_yaw_link", 0, "_hip_yaw", {0, sign * hip, -0.05}, {0, 0, 1});
  set_box(robot.links.back(), 1.1 * m, {0, 0, 0}, {0.1, 0.1, 0.1});
  at = add("_hip_roll_link", at, "_hip_roll", {0, 0, 0}, {1, 0, 0});
  set_box(robot.links.back(), 1.5 * m, {0, 0, 0}, {0.11, 0.11, 0.11});
  at = add("_thigh", at, "_hip_pitch", {0, 0, 0}, {0, 1, 0});
  set_box(robot.links.back(), 4.5 * m, {0, 0, -0.46 * thigh}, {0.12, 0.13, thigh});
  at = add("_shank", at, "_knee", {0, 0, -thigh}, {0, 1, 0});
  set_box(robot.links.back(), 3.1 * m, {0.005, 0, -0.42 * shank}, {0.1, 0.1, shank});
  at = add("_ankle_link", at, "_ankle_pitch", {0, 0, -shank}, {0, 1, 0});
  set_box(robot.links.back(), 0.6 * m, {0, 0, 0}, {0.07, 0.07, 0.07});
  at = add("_sole_link", at, "_ankle_roll", {0, 0, 0}, {1, 0, 0});
  const double length = 0.24 * size, width = 0.13 * size, drop = 0.09 * size;
  set_box(robot.links.back(), 1.6 * m, {0.02, 0, -0.6 * drop}, {length, width, 0.05});
  robot.feet.push_back({at, side + "_foot_ft", {0.02, 0, -drop + 0.01}, {length, width, 0.02}});
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

int find_joint(const RobotPlan& robot, const std::string& name) {
  for (int j = 0; j < joint_count(robot); ++j) {
    if (joint(robot, j).name == name) return j;
  }
  return -1;
}

int find_link(const RobotPlan& robot, const std::string& name) {
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    if (robot.links[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

RobotPlan make_arm(Prng& random) {
  static const std::vector<std::string> prefixes{"joint_", "axis", "a", "q", "seg_"};
  const int count = 3 + random.below(5);
  const std::string prefix = random.pick(prefixes);
  RobotPlan robot;
  robot.name = "serial" + std::to_string(count);
  robot.links.push_back({});
  robot.links[0].name = "mount";
  const double scale = random.uniform(0.6, 1.5);
  double mass = 9.0 * scale * scale * random.uniform(0.7, 1.3), length = 0.34 * scale;
  for (int i = 1; i <= count; ++i) {
    const double previous = i == 1 ? 0.12 : robot.links.back().box[2];
    const double side = i == 1 ? 0 : random.uniform(-0.05, 0.05);
    robot.links.push_back(make_link("body" + std::to_string(i), i - 1, prefix + std::to_string(i), {0, side, previous},
                                    draw_axis(static_cast<std::size_t>(i), random)));
    LinkPlan& link = robot.links.back();
    if (i == 1 && random.chance(0.4)) link.joint.rpy = {random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2), 0};
    if (i > 1 && random.chance(0.3)) link.joint.rpy[2] = random.pick(std::vector<double>{kPi / 2, -kPi / 2, 0.3});
    const double w = random.uniform(0.22, 0.4) * length;
    set_box(link, mass, {random.uniform(-0.03, 0.03), random.uniform(-0.02, 0.02), length * random.uniform(0.35, 0.6)},
            {w, w * random.uniform(0.8, 1.2), length});
    if (random.chance(0.5)) link.joint.start = random.uniform(-0.7, 0.7);
    mass *= random.uniform(0.5, 0.78);
    length *= random.uniform(0.72, 0.98);
  }
  for (std::size_t i = 1; i < robot.links.size(); ++i) draw_arm_servo(robot, i, random);
  return robot;
}

Vec3 level_leg(const RobotPlan& robot, double knee) {
  const double hip = -std::atan2(robot.shank * std::sin(knee), robot.thigh + robot.shank * std::cos(knee));
  return {hip, knee, -(hip + knee)};
}

RobotPlan make_biped(Prng& random) {
  const double size = random.uniform(0.75, 1.3);
  RobotPlan robot;
  robot.name = "stander";
  robot.floating = true;
  robot.thigh = 0.3 * size * random.uniform(0.9, 1.1);
  robot.shank = 0.3 * size * random.uniform(0.9, 1.1);
  robot.links.push_back({});
  robot.links[0].name = "hips";
  set_box(robot.links[0], 10 * size * size, {0, 0, 0.04}, {0.18, 0.26 * size, 0.16});
  robot.base_position[0] = 0.09 * size;
  add_leg(robot, "left", 1, random);
  add_leg(robot, "right", -1, random);
  robot.links.push_back(make_link("trunk", 0, "waist", {0, 0, 0.11 * size}, {0, 1, 0}));
  const int trunk = static_cast<int>(robot.links.size()) - 1;
  set_box(robot.links.back(), 15 * size * size * random.uniform(0.8, 1.2), {random.uniform(-0.01, 0.01), 0, 0.2 * size},
          {0.2, 0.3 * size, 0.4 * size});
  if (random.chance(0.6)) {
    add_arm(robot, "left", 1, trunk, size);
    add_arm(robot, "right", -1, trunk, size);
  }
  double mass = 0;
  for (const LinkPlan& link : robot.links) mass += link.mass;
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
  robot.ground_friction = random.pick(std::vector<double>{0.7, 0.8, 1.0});
  return robot;
}

}  // namespace hrp::cases
