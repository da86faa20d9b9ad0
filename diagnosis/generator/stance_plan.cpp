// SPDX-License-Identifier: BSD-3-Clause
// Humanoids that nobody here wrote, on their feet. What a joint is for is read off its place and axis, not its name.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/base/has.h"
#include "diagnosis/generator/robot_parts.h"

namespace hrp::cases {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kAlong = 0.9;    // least component of an axis along x, y or z that it is named after
constexpr double kLevel = 0.005;  // [m] above its lowest point a sole still touches the ground
constexpr double kFastest = 1e4;  // [1/s] of a drive's damping over what it moves: the integration is explicit
constexpr int kIterations = 20;

Vector3d to_eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }

std::vector<double> list_starts(const RobotPlan& robot) {
  std::vector<double> q;
  for (int j = 0; j < joint_count(robot); ++j) q.push_back(joint(robot, j).start);
  return q;
}

// Links from the base's child to `link`.
std::vector<int> list_chain(const RobotPlan& robot, int link) {
  std::vector<int> chain;
  for (int i = link; i > 0; i = robot.links[static_cast<std::size_t>(i)].parent) chain.insert(chain.begin(), i);
  return chain;
}

JointPlan& joint_of(RobotPlan& robot, int link) { return joint(robot, link - 1); }

// 0, 1, 2 for an axis along x, y, z with the joints at zero, else 3; and its sense.
int find_axis(const RobotPlan& robot, int link, double* sense) {
  const std::vector<double> zero(robot.links.size(), 0.0);
  const Vector3d axis = calc_pose(robot, link, zero).linear() *
                        to_eigen(robot.links[static_cast<std::size_t>(link)].joint.axis).normalized();
  for (int i = 0; i < 3; ++i) {
    *sense = axis(i) > 0 ? 1 : -1;
    if (std::abs(axis(i)) > kAlong) return i;
  }
  return 3;
}

void name_leg(RobotPlan* robot, int foot, const std::string& side) {
  std::vector<int> around[4];
  for (int link : list_chain(*robot, foot)) {
    double sense = 1;
    around[find_axis(*robot, link, &sense)].push_back(link);
    joint_of(*robot, link).sense = sense;
  }
  const auto& [roll, pitch, yaw, other] = around;
  if (roll.empty() || roll.size() > 2 || pitch.size() != 3 || !other.empty()) {
    throw std::runtime_error(robot->name + ": a leg is not of hip, knee and ankle");
  }
  const char* names[] = {"hip_pitch", "knee", "ankle_pitch"};
  for (std::size_t i = 0; i < 3; ++i) joint_of(*robot, pitch[i]).role = side + names[i];
  joint_of(*robot, roll[0]).role = side + "hip_roll";
  if (roll.size() > 1) joint_of(*robot, roll[1]).role = side + "ankle_roll";
  for (int link : yaw) joint_of(*robot, link).role = side + "hip_yaw";
}

// The two links that nothing hangs on, lowest with the joints at zero.
std::vector<int> find_feet(const RobotPlan& robot) {
  const std::vector<double> zero(robot.links.size(), 0.0);
  std::vector<std::pair<double, int>> ends;
  for (int i = 1; i < static_cast<int>(robot.links.size()); ++i) {
    const auto hangs = [i](const LinkPlan& link) { return link.parent == i; };
    if (std::any_of(robot.links.begin(), robot.links.end(), hangs)) continue;
    ends.emplace_back(calc_pose(robot, i, zero).translation().z(), i);
  }
  if (ends.size() < 2) throw std::runtime_error(robot.name + ": fewer than two limbs");
  std::sort(ends.begin(), ends.end());
  std::vector<int> feet{ends[0].second, ends[1].second};
  if (calc_pose(robot, feet[0], zero).translation().y() < calc_pose(robot, feet[1], zero).translation().y()) {
    std::swap(feet[0], feet[1]);
  }
  return feet;  // left, right
}

FootPlan make_foot(const RobotPlan& robot, int link, const std::vector<Vector3d>& points) {
  Vector3d low = Vector3d::Constant(1e9), high = -low;
  for (const Vector3d& p : points) low.z() = std::min(low.z(), p.z());
  for (const Vector3d& p : points) {
    if (p.z() > low.z() + kLevel) continue;
    low.head<2>() = low.head<2>().cwiseMin(p.head<2>()), high.head<2>() = high.head<2>().cwiseMax(p.head<2>());
  }
  const Vector3d size = high - low;
  if (points.empty() || std::min(size.x(), size.y()) < 0.02) {
    throw std::runtime_error(robot.name + ": no flat sole of boxes, spheres or meshes");
  }
  FootPlan foot;
  foot.link = link;
  foot.wrench = robot.links[static_cast<std::size_t>(link)].name + "_ft";
  foot.size = {round_to(size.x(), 4), round_to(size.y(), 4), 0.02};
  foot.center = {round_to((low.x() + high.x()) / 2, 4), round_to((low.y() + high.y()) / 2, 4), low.z() + 0.01};
  return foot;
}

// Heaviest link that is not of a leg carries the IMU; one joint below it is the waist, all others are arms.
void name_upper_body(RobotPlan* robot) {
  int trunk = 0;
  for (int i = 1; i < static_cast<int>(robot->links.size()); ++i) {
    const LinkPlan& link = robot->links[static_cast<std::size_t>(i)];
    if (link.joint.role.empty() && link.mass > robot->links[static_cast<std::size_t>(trunk)].mass) trunk = i;
  }
  const std::vector<int> waist = list_chain(*robot, trunk);
  for (int link : waist) {
    double sense = 1;
    if (find_axis(*robot, link, &sense) == 0 || find_role(*robot, "waist") >= 0) continue;
    joint_of(*robot, link).role = "waist";
  }
  for (int i = 1; i < static_cast<int>(robot->links.size()); ++i) {
    const bool below = has(waist, i);
    if (joint_of(*robot, i).role.empty() && !below) joint_of(*robot, i).role = "arm";
  }
  robot->imu = "imu";
  robot->imu_link = trunk;
}

// Legs and waist hold the whole robot, as drawn bipeds' do; arms what hangs on them. A URDF has no rotors, and feet are
// light: what a drive damps is made heavy enough for an explicit integration, in the model that is handed out, too.
void draw_servos(RobotPlan* robot, double mass, Prng& random) {
  const double stiff = random.uniform(38, 62), damp = random.uniform(0.016, 0.026);
  for (std::size_t i = 1; i < robot->links.size(); ++i) {
    JointPlan& joint = robot->links[i].joint;
    draw_servo(*robot, i, random);
    if (joint.role != "arm") {
      joint.kp = round_to(stiff * mass, 3);
      joint.kd = round_to(joint.kp * damp, 3);
      joint.limit = round_to(6 * mass, 2);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double& inertia = robot->links[i].inertia[axis];
      inertia = std::max(inertia, joint.kd / kFastest);
    }
  }
}

Vector3d calc_com(const RobotPlan& robot, const std::vector<double>& q) {
  Vector3d sum = Vector3d::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const LinkPlan& link = robot.links[i];
    sum += link.mass * (calc_pose(robot, static_cast<int>(i), q) * to_eigen(link.com));
    mass += link.mass;
  }
  return sum / mass;
}

void bend_knees(RobotPlan* robot, double knee) {
  const Vec3 leg = level_leg(*robot, knee);
  for (const std::string side : {"left_", "right_"}) {
    const char* names[] = {"hip_pitch", "knee", "ankle_pitch"};
    for (std::size_t i = 0; i < 3; ++i) {
      JointPlan& joint = hrp::cases::joint(*robot, find_role(*robot, side + names[i]));
      joint.start = round_to(joint.sense * leg[i], 4);
    }
  }
}

}  // namespace

Isometry3d calc_pose(const RobotPlan& robot, int link, const std::vector<double>& q) {
  Isometry3d X = Isometry3d::Identity();
  for (int i : list_chain(robot, link)) {
    const JointPlan& joint = robot.links[static_cast<std::size_t>(i)].joint;
    X.translate(to_eigen(joint.xyz));
    X.rotate(Eigen::AngleAxisd(joint.rpy[2], Vector3d::UnitZ()) * Eigen::AngleAxisd(joint.rpy[1], Vector3d::UnitY()) *
             Eigen::AngleAxisd(joint.rpy[0], Vector3d::UnitX()));
    X.rotate(Eigen::AngleAxisd(q[static_cast<std::size_t>(i) - 1], to_eigen(joint.axis).normalized()));
  }
  return X;
}

// Newton's method on two numbers, how far the left sole is tilted and how far ahead of where it belongs.
Vec3 level_any_leg(const RobotPlan& robot, double knee) {
  const auto find = [&](const char* role) { return find_role(robot, std::string("left_") + role); };
  const int joints[3] = {find("hip_pitch"), find("knee"), find("ankle_pitch")};
  const FootPlan& foot = robot.feet[0];
  Eigen::Vector2d x(-0.5 * knee, -0.5 * knee);
  const auto miss = [&](const Eigen::Vector2d& at) {
    std::vector<double> q = list_starts(robot);
    const double angles[3] = {at(0), knee, at(1)};
    for (int i = 0; i < 3; ++i) q[static_cast<std::size_t>(joints[i])] = joint(robot, joints[i]).sense * angles[i];
    const Isometry3d X = calc_pose(robot, foot.link, q);
    return Eigen::Vector2d(X.linear()(2, 0), (X * to_eigen(foot.center)).x() - robot.sole_ahead);
  };
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector2d at = miss(x);
    if (at.norm() < 1e-12) break;
    constexpr double h = 1e-6;
    Eigen::Matrix2d slope;
    slope.col(0) = (miss(x + Eigen::Vector2d(h, 0)) - at) / h;
    slope.col(1) = (miss(x + Eigen::Vector2d(0, h)) - at) / h;
    x -= slope.inverse() * at;
  }
  return {x(0), knee, x(1)};
}

RobotPlan make_standing_robot(const std::string& urdf_path, Prng& random) {
  SolePoints points;
  RobotPlan robot = read_urdf_links(urdf_path, &points);
  robot.floating = true;
  const std::vector<int> feet = find_feet(robot);
  name_leg(&robot, feet[0], "left_");
  name_leg(&robot, feet[1], "right_");
  for (int link : feet) robot.feet.push_back(make_foot(robot, link, points[static_cast<std::size_t>(link)]));
  name_upper_body(&robot);
  double mass = 0;
  for (const LinkPlan& link : robot.links) mass += link.mass;
  draw_servos(&robot, mass, random);
  const LinkPlan& trunk = robot.links[static_cast<std::size_t>(robot.imu_link)];
  robot.imu_xyz = {trunk.com[0], round_to(random.uniform(-0.02, 0.02), 3), trunk.com[2]};
  const double knee = random.uniform(0.4, 0.8);
  for (int i = 0; i < 5; ++i) {  // the centre of mass moves a little as the legs do
    bend_knees(&robot, knee);
    robot.sole_ahead = calc_com(robot, list_starts(robot)).x();
  }
  bend_knees(&robot, knee);
  const Isometry3d X = calc_pose(robot, robot.feet[0].link, list_starts(robot));
  const double hip = calc_pose(robot, find_role(robot, "left_hip_pitch") + 1, list_starts(robot)).translation().z();
  const double sole = (X * to_eigen(robot.feet[0].center)).z() - robot.feet[0].size[2] / 2;
  robot.leg = hip - sole;
  robot.base_position = {0, 0, std::round(-sole * 1e4) / 1e4};
  robot.ground_friction = random.pick(std::vector<double>{0.7, 0.8, 1.0});
  return robot;
}

}  // namespace hrp::cases
