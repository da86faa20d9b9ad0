// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "diagnosis/generator/prng.h"

namespace hrp::cases {

using Vec3 = std::array<double, 3>;

// A joint turns `axis` (joint frame); `xyz`, `rpy` place the joint frame in the parent link (URDF convention).
struct JointPlan {
  std::string name;
  Vec3 xyz{}, rpy{}, axis{0, 0, 1};
  double kp = 0;     // [N m/rad] nominal servo
  double kd = 0;     // [N m s/rad]
  double limit = 0;  // [N m] nominal effort limit
  double start = 0;  // [rad] nominal start position
  // What a standing robot's joint is for: left_hip_pitch, right_knee, waist, left_shoulder, arm, ... and whether it
  // turns as axes x forward, y left, z up have it (1) or against (-1). Motions are drawn by role.
  std::string role;
  double sense = 1;
};

// `inertia` are ixx iyy izz ixy ixz iyz about the centre of mass in link axes [kg m^2].
struct LinkPlan {
  std::string name;
  int parent = -1;  // index of the parent link; -1: the base
  JointPlan joint;  // unused for the base
  double mass = 0;  // [kg]; 0: a base without inertia
  Vec3 com{};
  std::array<double, 6> inertia{};
  Vec3 box{};  // visual only
};

struct FootPlan {
  int link = 0;
  std::string wrench;  // name of the force sensor at that link
  Vec3 center{};       // of the sole box in the link's frame [m]
  Vec3 size{};
};

struct RobotPlan {
  std::string name;
  bool floating = false;
  std::vector<LinkPlan> links;  // links[0] is the base; every other link owns the joint to its parent
  std::vector<FootPlan> feet;
  std::string imu;  // empty: none
  int imu_link = 0;
  // Of fixed bases, behind the gears: a force sensor at a link's frame (empty: none), torque sensors and second
  // encoders at all joints.
  std::string wrist;
  int wrist_link = 0;
  bool joint_torques = false, link_encoders = false;
  Vec3 imu_xyz{};
  Vec3 base_position{};  // nominal start [m]
  double ground_friction = 0.8;
  double thigh = 0, shank = 0;  // of a biped of ours [m]
  double leg = 0;               // length of a standing robot's leg [m]
  double sole_ahead = 0;        // of the base, kept there while the knees bend; of robots from a URDF [m]
  int name_scheme = 0;          // what a biped's parts are called outside the generator
};

inline int joint_count(const RobotPlan& robot) { return static_cast<int>(robot.links.size()) - 1; }
inline JointPlan& joint(RobotPlan& robot, int j) { return robot.links[static_cast<std::size_t>(j) + 1].joint; }
inline const JointPlan& joint(const RobotPlan& robot, int j) {
  return robot.links[static_cast<std::size_t>(j) + 1].joint;
}
int find_joint(const RobotPlan& robot, const std::string& name);  // -1: none
int find_role(const RobotPlan& robot, const std::string& role);   // joint; -1: none

// A text with the names that the robot's parts have outside the generator.
std::string find_outside_name(const RobotPlan& robot, std::string text);

// An arm of 2 to 7 joints (serial, planar or SCARA-like) with random geometry, mass, names and gains.
RobotPlan make_arm(Prng& random);

// The robot of a URDF with its root link held and gains drawn; joints that do not turn are held, too. Throws
// std::runtime_error where it cannot be read, or a link that turns has no mass.
RobotPlan make_hung_robot(const std::string& urdf_path, Prng& random);

// The humanoid of a URDF on its feet, knees bent, with gains drawn: links as hung robots have them, soles as boxes that
// span the lowest points of the feet's boxes and spheres. Throws where no two legs of hip, knee and ankle end in soles.
RobotPlan make_standing_robot(const std::string& urdf_path, Prng& random);

// A standing biped with random sizes (0.55 to 1.5 of a small human): twelve leg joints, a waist, and perhaps arms.
RobotPlan make_biped(Prng& random);

// Hip, knee, ankle pitch (turning about y) that hold the foot level and below the hip at the given knee angle [rad].
Vec3 level_leg(const RobotPlan& robot, double knee);

}  // namespace hrp::cases
