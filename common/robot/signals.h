// SPDX-License-Identifier: BSD-3-Clause
// What the cores exchange: the contents of the stepped topics without any bus. Units, frames, signs: idl/*.idl.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Dense>

#include "common/multibody/state.h"
#include "common/spatial/transform.h"

namespace hrp {

constexpr int kGround = -1;                                  // body index of the ground
constexpr int make_obstacle_index(int k) { return -2 - k; }  // body index of obstacle k
// Everything that moves beside the robot (movers.h): the scenario's objects, then the links of its other robots.
constexpr int kFirstObject = 1000000;
constexpr int make_object_index(int k) { return kFirstObject + k; }  // body index of object k
constexpr bool is_object(int body) { return body >= kFirstObject; }

// Of the scenario's objects (trees of one link), then of its other robots, in its order.
using ObjectStates = std::vector<State>;

struct ContactPoint {
  Vector3d p_WC = Vector3d::Zero();     // [m] the point, half way into the penetration
  Vector3d n_BA_W = Vector3d::UnitZ();  // unit normal from body B towards body A
  double depth = 0.0;                   // [m] positive when overlapping
};

struct ContactPair {
  int body_a = 0;        // link index (>= 0), an object or a link of another robot
  int body_b = kGround;  // the same, kGround or an obstacle
  std::vector<ContactPoint> points;
  Vector3d separation = Vector3d::Zero();       // [m] smallest translation of A that ends the overlap, world axes
  Vector3d separation_turn = Vector3d::Zero();  // [rad] small rotation of A about p_WR that levels the patch
  Vector3d p_WR = Vector3d::Zero();             // [m] reference point of A for moments and rotations
  double friction = 0.0;
};

using ContactSet = std::vector<ContactPair>;

// Force on body A at one point, world axes. total = spring + damper + friction in exactly this order.
struct PointForce {
  Vector3d p_WC = Vector3d::Zero();
  Vector3d n_BA_W = Vector3d::UnitZ();
  double depth = 0.0;
  Vector3d spring = Vector3d::Zero();
  Vector3d damper = Vector3d::Zero();
  Vector3d friction = Vector3d::Zero();
  Vector3d total = Vector3d::Zero();
  Vector3d slip = Vector3d::Zero();  // [m/s] tangential velocity of A against B
  bool clipped = false;
};

// Wrench on body A about p_WR, world axes, [moment; force]. total = spring + damper + friction in this order.
struct PairForce {
  int body_a = 0;
  int body_b = kGround;
  Vector3d p_WR = Vector3d::Zero();
  Vector6d spring = Vector6d::Zero();
  Vector6d damper = Vector6d::Zero();
  Vector6d friction = Vector6d::Zero();
  Vector6d total = Vector6d::Zero();
  bool clipped = false;
  std::vector<PointForce> points;
};

using ContactForces = std::vector<PairForce>;

struct ImuSample {
  Eigen::Quaterniond R_WS = Eigen::Quaterniond::Identity();
  Vector3d angular_velocity = Vector3d::Zero();     // [rad/s] w_WS_S
  Vector3d linear_acceleration = Vector3d::Zero();  // [m/s^2] specific force, sensor axes
};

struct WrenchSample {
  Vector3d force = Vector3d::Zero();   // [N] what the sensor's link exerts on its parent, link axes
  Vector3d torque = Vector3d::Zero();  // [N m] about the link frame's origin
};

// Orders of imus and wrenches: those of Scenario::sensors.
struct SensorSample {
  Eigen::VectorXd q, qd, effort;
  std::vector<ImuSample> imus;
  std::vector<WrenchSample> wrenches;
  bool has_base_pose = false;
  Transform X_WB;
  Vector6d V_WB = Vector6d::Zero();
};

// A force from outside on a point Q of a link.
struct PushForce {
  std::string name;  // of the scenario's push or hand; empty: of somebody who pushes live
  std::string link;
  Vector3d p_LQ = Vector3d::Zero();     // [m] where it acts, link axes
  Vector3d force_W = Vector3d::Zero();  // [N] on the link
};

using PushForces = std::vector<PushForce>;

// Servo references. Empty vectors of qd and effort mean zero.
struct JointCommand {
  Eigen::VectorXd q, qd, effort;
};

}  // namespace hrp
