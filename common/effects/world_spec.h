// SPDX-License-Identifier: BSD-3-Clause
// Sections of a scenario that effects act on: ground, contact, soles, sensors.
#pragma once

#include <optional>
#include <string>

#include "common/spatial/transform.h"

namespace hrp {

struct GroundSpec {
  bool present = true;
  double height = 0.0;  // [m]
  double friction = 0.8;
  double roll = 0.0;  // [rad] the plane turned by roll, then pitch about world axes
  double pitch = 0.0;
  bool all_touch = true;  // every shape of a robot with a floating base touches it; false: soles only
};

// Sensor faults and limits; all zero = ideal.
struct SensorErrors {
  Vector3d noise = Vector3d::Zero();  // standard deviation, per channel group (see docs/scenario.md)
  Vector3d bias = Vector3d::Zero();
  double delay = 0.0;                 // [s]
  double clock_skew = 0.0;            // the reading stamped t is that of t (1 + skew), less the delay; docs/scenario.md
  double quantum = 0.0;               // step of the reading
  Vector3d scale = Vector3d::Ones();  // true value 1 reads as scale
  Vector3d misalignment = Vector3d::Zero();  // [rad] rpy of the sensor against its link: it reads R(rpy)^T v
};

// Law and parameters of every contact of the scenario; see docs/physics.md.
struct ContactSpec {
  std::string model = "spring_damper";  // or "impulse"
  // As good as rigid: a humanoid of 175 kg sinks in by less than 0.2 mm, and a sole 0.14 m wide has a tilt stiffness of
  // 5e4 N m/rad, where robots of human size need more than m g h, about 1e3.
  double stiffness = 1e7;             // [N/m] per pair, normal; shared among its points
  double exponent = 1.0;              // n of equations (1), (3)
  double alpha = 2.4;                 // [s/m] lambda = 3/2 alpha K, equation (3)
  double tangential_damping = 2e3;    // [N s/m] C of equation (5), per pair
  double restitution = 0.0;           // impulse model
  int shared_points = 4;              // each point of a pair has 1 / shared_points of the pair's stiffness and damping
  std::string damping = "projected";  // normal damper on the projected velocity of equation (2), or "two_sided"
  double length_scale = 0.1;          // [m] weighs rotation against translation in the projection of equation (2)
  double tangential_stiffness = 1e7;  // [N/m] per pair, holds what sticks (beyond the paper); 0 = equation (5) alone
  double margin = 0.0;  // [m] points of a sole this near the ground take part: they may touch within the step
};

// Sole bush between a foot's force sensor and its sole: slide z, roll, pitch.
struct FootBushSpec {
  double kz = 0, cz = 0;                                    // [N/m], [N s/m]
  double k_roll = 0, c_roll = 0, k_pitch = 0, c_pitch = 0;  // [N m/rad], [N m s/rad]
  double offset_roll = 0, offset_pitch = 0;                 // [N m]
  double hardening_angle = 0;      // [rad] roll and pitch stiffness times 1 + (angle / this)^2; 0: linear
  std::optional<Vector3d> center;  // [m] in the foot link; not given: centre of the sole's lower face
  double upper_mass_ratio = 0.1;   // share of the foot's mass above the bush
};

}  // namespace hrp
