// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "diagnosis/generator/hidden.h"

namespace hrp::cases {

// Torque of the drive [N m] from what it would give without the law, at the motor's speed v [rad/s].
using DriveLaw = std::function<double(double torque, double v)>;

// What is hidden in one joint; everything is off by default. Units SI, angles in rad.
struct JointReality {
  // friction
  double viscous = 0, coulomb = 0, asymmetry = 0, load_ratio = 0;
  double stribeck_coulomb = 0, stribeck_static = 0, stribeck_velocity = 0;
  double bump_level = 0, bump_center = 0, bump_width = 1;      // dry friction around one position
  double drift_level = 0, drift_time = 1;                      // dry friction that fades as the gear warms up
  double texture = 0, texture_periods = 1, texture_phase = 0;  // share by which dry friction varies over position
  double fade_drop = 0, fade_time = 1;                         // share of all dry friction that fades with time
  double bouc_wen_stiffness = 0, bouc_wen_yield = 1;
  // drive
  double torque_scale = 1, saturation = std::numeric_limits<double>::infinity(), lag = 0, delay = 0, offset = 0;
  double heat_loss = 0, heat_reference = 1, heating_time = 1, cooling_time = 1;  // torque lost as the coil warms up
  double slip_fraction = 0, slip_period = 1, slip_length = 0;
  std::vector<DriveLaw> drive_laws;  // of rows that bring a law along
  double periodic_amplitude = 0, periodic_frequency = 0, periodic_phase = 0;
  // mechanics
  double rotor = 0;
  bool elastic = false;
  double stiffness = 0, damping = 0, gap = 0;  // of the transmission
  double spring = 0, spring_rest = 0, cubic = 0, cubic_center = 0;
  double cogging = 0, cogging_periods = 0, cogging_phase = 0;
  double stop_angle = 0, stop_side = 0, stop_stiffness = 0;
  double drag = 0;
  double detent = 0, detent_center = 0, detent_width = 1;  // a magnet at one angle
  int coupled_to = -1;
  double coupling = 0;
};

std::vector<JointReality> make_joint_realities(const RobotPlan& robot, const std::vector<Hidden>& hidden);

// Torque of the drive on the motor shaft from what the servo asked for [N m], at the motor's speed v [rad/s]; `heat` is
// the state of the law below.
double calc_drive_torque(const JointReality& joint, double asked, double v, double heat, double time);

// Warmth of the coil, 1 after `heating_time` at the reference torque: d(heat)/dt from the torque asked for.
double calc_heat_rate(const JointReality& joint, double asked, double heat);

// Torque through the transmission, positive on the link [N m]: spring and damper behind a dead zone of `gap`.
double calc_transmission_torque(const JointReality& joint, double q_motor, double q_link, double v_motor,
                                double v_link);

// Smooth torques on the motor shaft and on the link [N m]; `z` is the Bouc-Wen state [rad].
double calc_motor_side_torque(const JointReality& joint, double q, double v, double z, double time);
double calc_link_side_torque(const JointReality& joint, double q, double v);

// Bouc-Wen (Wen 1976) with n = 1, beta = gamma = 1/2, z in rad: zd = v - (|v| z + v |z|) / (2 yield).
double calc_bouc_wen_rate(const JointReality& joint, double v, double z);

// Level of dry friction, two-sided about a bias of -coulomb x asymmetry [N m].
double calc_dry_friction(const JointReality& joint, double q, double v, double torque, double time);

}  // namespace hrp::cases
