// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/generator/robot_parts.h"

namespace hrp::cases {
namespace {

double calc_length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

// Distance of each link's frame from that of link `first`, everything stretched [m]; negative: not outboard of it.
std::vector<double> calc_reaches(const RobotPlan& robot, std::size_t first) {
  std::vector<double> reaches(robot.links.size(), -1);
  reaches[first] = 0;
  for (std::size_t i = first + 1; i < robot.links.size(); ++i) {
    const double parent = reaches[static_cast<std::size_t>(robot.links[i].parent)];
    if (parent >= 0) reaches[i] = parent + calc_length(robot.links[i].joint.xyz);
  }
  return reaches;
}

// Mass times squared distance of everything outboard, stretched: an upper bound of what the joint turns [kg m^2].
double calc_outboard_inertia(const RobotPlan& robot, const std::vector<double>& reaches) {
  double inertia = 0;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    if (reaches[i] < 0) continue;
    const LinkPlan& link = robot.links[i];
    const double r = reaches[i] + calc_length(link.com);
    inertia += link.mass * r * r + (link.inertia[0] + link.inertia[1] + link.inertia[2]) / 3;
  }
  return inertia;
}

// Largest moment of everything outboard under gravity [N m].
double calc_outboard_moment(const RobotPlan& robot, const std::vector<double>& reaches) {
  double moment = 0;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    if (reaches[i] >= 0) moment += robot.links[i].mass * 9.81 * (reaches[i] + calc_length(robot.links[i].com));
  }
  return moment;
}

}  // namespace

void draw_servo(RobotPlan& robot, std::size_t link, Prng& random) {
  JointPlan& joint = robot.links[link].joint;
  const std::vector<double> reaches = calc_reaches(robot, link);
  const double bandwidth = random.uniform(24, 42);  // [rad/s]
  const double inertia = calc_outboard_inertia(robot, reaches), moment = calc_outboard_moment(robot, reaches);
  joint.kp = round_to(std::max(inertia * bandwidth * bandwidth, moment * random.uniform(15, 30)), 3);
  joint.kd = round_to(joint.kp * random.uniform(0.025, 0.045), 3);
  joint.limit = round_to(std::max(3.0 * moment, joint.kp * random.uniform(0.15, 0.3)), 2);
}

}  // namespace hrp::cases
