// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/generator/hidden.h"
#include "diagnosis/generator/motion.h"
#include "diagnosis/generator/robot_plan.h"

namespace hrp::cases {

// Everything a sensor could have read at one instant, without noise.
struct Reading {
  double time = 0;
  std::vector<double> position, velocity, effort;  // encoder [rad], [rad/s]; the servo's commanded effort [N m]
  std::vector<double> link_position;               // behind the transmission [rad]
  std::vector<double> link_torque;                 // that the transmission passes to the link [N m]
  Vec3 wrist_force{}, wrist_torque{};              // of the link and what it carries on its parent, link axes
  Vec3 base_position{};
  std::array<double, 4> base_orientation{1, 0, 0, 0};  // w x y z
  std::array<double, 4> imu_orientation{1, 0, 0, 0};
  Vec3 imu_rate{}, imu_acceleration{};
  std::vector<Vec3> foot_force, foot_torque;
};

constexpr const char* kDiverges = "diverges";  // of InsaneCase::why

// Thrown when a drawn case does not run sanely (falls, diverges); the caller draws another.
struct InsaneCase {
  std::string why;
  double time = 0.0;  // [s] when a joint left its command; 0 for other reasons
};

// The robot with everything hidden in it, on MuJoCo. MuJoCo computes the multibody dynamics, dry friction and contact;
// servo, drive and every other law are this class's own formulas, integrated together with the state.
class Reality {
 public:
  Reality(const RobotPlan& robot, const std::vector<Hidden>& hidden);
  ~Reality();

  // Readings at the given increasing times (from 0 on). `push` acts on the imu link until time 0 [N, world axes].
  // `soles_lift`: with steps that a soft sole needs while its edge is in the air, about a tenth of the usual ones.
  std::vector<Reading> run(const Commands& commands, const std::vector<double>& times, const Vec3& push,
                           bool soles_lift = false);

  // In closed loop: every `period` [s] from 0 on, `brain` sees the robot and says where the joints are to be. They are
  // there two periods later: the drives interpolate through what came before and after, so that speeds are those of the
  // positions. Readings at `times` until the robot falls; `commands` has what was played.
  using Brain = std::function<void(const Reading&, std::vector<double>* position)>;
  std::vector<Reading> walk(const Brain& brain, double period, const std::vector<double>& times, Commands* commands);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// MuJoCo's description of the robot with the hidden bodies, joints and masses (also used by the tests).
std::string make_mjcf(const RobotPlan& robot, const std::vector<Hidden>& hidden);

}  // namespace hrp::cases
