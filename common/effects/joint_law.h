// SPDX-License-Identifier: BSD-3-Clause
// Laws of one joint: pure functions and their parameters. A joint's effort is affine in its velocity at the end of the
// step, effort = a - b v', which makes stiff laws implicit; what switches (limits, friction, gaps) is a regime.
// Efforts in N m (N for a slide), positions in rad (m). Sources and equations: docs/physics.md.
#pragma once

#include <limits>
#include <vector>

namespace hrp {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// [rad] displacement before slipping of rolling and sliding contacts in gears, where nothing is known.
constexpr double kPresliding = 5e-4;

// effort = a - b v'
struct AffineEffort {
  double a = 0.0;  // [N m]
  double b = 0.0;  // [N m s/rad]
  double at(double v) const { return a - b * v; }
};

// A law of the drive without memory that a row of the table brings along, with its own numbers: no field for it here.
struct DriveTerm {
  // Torque [N m] behind the term from that before it, at the motor's speed v [rad/s].
  double (*calc_torque)(const double* p, double torque, double v) = nullptr;
  double p[2] = {0.0, 0.0};
};

// Everything that a joint can have; what is left at its default is absent. Source: effect list of the diagnosis tool.
struct JointLaws {
  // Drive
  double kp = 0.0, kd = 0.0;         // [N m/rad], [N m s/rad] joint servo; fact sheet 4.5
  double effort_limit = kUnlimited;  // [N m] of the servo's output (logged)
  double command_delay = 0.0;        // [s]
  double joint_offset = 0.0;         // [rad] encoder reads true + offset
  double lag = 0.0;                  // [s] first-order lag of the drive's effort
  double saturation = kUnlimited;    // [N m] of the true torque (not logged)
  double torque_scale = 1.0;         // true torque = scale x logged effort
  std::vector<DriveTerm> terms;      // behind scale and saturation, in their order
  // Friction, on the motor side of an elastic transmission
  double viscous = 0.0;             // [N m s/rad]
  double coulomb = 0.0;             // [N m] level while moving
  double asymmetry = 0.0;           // level x (1 + asymmetry) forward, x (1 - asymmetry) backward
  double static_level = 0.0;        // [N m] largest level, at rest; at least coulomb
  double stribeck_velocity = 0.0;   // [rad/s] 0: no Stribeck curve
  double load_ratio = 0.0;          // level grows by ratio x |drive effort|
  double backdriven = 0.0;          // share of the load that the gear takes while the load drives it; below 1
  double presliding = kPresliding;  // [rad] at it dry friction is full, along a path
  bool bends = false;               // a simulator's dry friction, too; else it holds exactly
  double cogging_amplitude = 0.0, cogging_periods = 0.0, cogging_phase = 0.0;  // [N m], per rad, [rad]
  // Transmission
  bool elastic = false;
  double stiffness = 0.0, damping = 0.0;  // [N m/rad], [N m s/rad]
  double motor_inertia = 0.0;             // [kg m^2] reflected
  double gap = 0.0;                       // [rad] whole backlash
  // Link side
  double spring_stiffness = 0.0, spring_damping = 0.0, spring_rest = 0.0;  // parallel spring
  double spring_hardening = 0.0;  // [1/rad^2] parallel spring: - stiffness hardening q^3 beside the linear part
  double hysteresis_stiffness = 0.0, hysteresis_yield = 0.0;  // Bouc-Wen, [N m/rad], [rad]
  double lower = -kUnlimited, upper = kUnlimited;             // [rad] stops
  double stop_stiffness = 0.0, stop_damping = 0.0;

  bool has_friction() const { return coulomb > 0.0 || static_level > 0.0 || load_ratio > 0.0 || backdriven > 0.0; }
};

// Servo: kp (r - measured) + kd (r' - measured rate) + feed-forward, before its limit.
double calc_servo_effort(const JointLaws& laws, double error, double error_rate, double feed_forward);

// The drive's equation, forward: torque [N m] on the motor at speed v from the effort of the servo, or of its log,
// behind the lag: scale, then saturation of the true torque, then terms.
double calc_given_torque(const JointLaws& laws, double effort, double v);
// Its slopes over effort and over v; 0 over effort: at a limit.
struct TorqueSlope {
  double over_effort = 1.0, over_v = 0.0;
};
TorqueSlope calc_given_slope(const JointLaws& laws, double effort, double v);
// Inverse: torque [N m] that rotor, viscous friction, cogging and parallel spring of a joint take at q, v, a.
double calc_taken_torque(const JointLaws& laws, double q, double v, double a);

// Direction of motion, -1 to 1, smooth through rest, for what is linear in dry friction. Velocities that were smoothed
// from encoders of 1e-5 rad at 500 Hz have about 1 mrad/s of noise: a tenth of the speed at which it is 3/4.
constexpr double kDirectionSpeed = 0.01;  // [rad/s]
double calc_direction(double v);

// Level of dry friction at speed v (Coulomb, Stribeck: level = coulomb + (static - coulomb) exp(-(v / v_s)^2)),
// raised by ratio x |load|; `direction` +-1 is that of motion.
double calc_friction_level(const JointLaws& laws, double speed, double load, double direction);
// Largest friction at rest against motion in `direction`, what a gear holds back included.
double calc_static_level(const JointLaws& laws, double load, double direction);

// A gear of high ratio loses more when the load turns it than when the motor does: the share `backdriven` of the load's
// torque, while that drives the joint. The load is seen from the link: `load` [N m] is what the motion takes (inverse
// dynamics). Level of dry friction [N m]; 0 while the load is along `direction` of motion, so that the drive leads.
double calc_backdriven_level(const JointLaws& laws, double load, double direction);
// The same loss seen from the motor: while the torque `drive` [N m] that it puts into the gear brakes, the link feels
// drive / (1 - backdriven). Level of dry friction beside `drive` [N m].
double calc_holding_level(const JointLaws& laws, double drive, double direction);

// Cogging effort: amplitude sin(periods q + phase); slope over q.
double calc_cogging(const JointLaws& laws, double q);
double calc_cogging_slope(const JointLaws& laws, double q);

// Twist beyond the gap: zero inside, signed outside.
double calc_backlash_twist(double gap, double twist);

// Bouc-Wen with n = 1, beta = gamma = 1/2: zd = (v / yield) (1 - |z| (1 + sgn(v z)) / 2), effort = -stiffness yield z.
double calc_hysteresis_rate_factor(double z, double v);  // zd = factor v / yield

// Parameter checks: empty when the laws can be simulated, else what is wrong with which parameter.
const char* find_law_fault(const JointLaws& laws);

}  // namespace hrp
