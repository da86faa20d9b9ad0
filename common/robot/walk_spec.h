// SPDX-License-Identifier: BSD-3-Clause
// Settings of the walking controller: the section `controller.walk` of a scenario (docs/scenario.md).
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct FootstepSpec {
  std::string frame =
      "support";     // support: of the other foot; swing: of this foot's own place; start: between the feet
  std::string side;  // left or right; empty: alternates
  double x = 0.0, y = 0.0, z = 0.0;  // [m]; z: above the plane through the supporting foot
  double theta = 0.0;                // [rad]
};

// Three laws, each with its own switch.
struct StabilizerSpec {
  bool inclination = false;            // body inclination control
  double inclination_gain = 1.0;       // turn of the body against a lean [rad/rad]
  double inclination_rate = 0.1;       // [s]
  double inclination_integral = 0.0;   // [1/s]
  double inclination_limit = 0.15;     // [rad]
  bool zmp_damping = false;            // ZMP damping control
  double zmp_gain = 0.2;               // [1/s] velocity of the body per ZMP error [m/s per m]
  double zmp_return = 2.0;             // [1/s] how fast the body comes back to its reference
  double zmp_limit = 0.05;             // [m]
  bool foot_adjusting = false;         // foot adjusting control
  double foot_damping = 100.0;         // [N m s/rad] D
  double foot_return = 0.2;            // [s] T
  double foot_limit = 0.17;            // [rad]
  double height_damping = 5000.0;      // [N s/m] D_z
  double height_return_double = 1.5;   // [s] T_z on both feet
  double height_return_single = 0.08;  // [s] T_z on one foot
  double height_limit = 0.025;         // [m]
  bool tracking = false;           // LIPM tracking: ZMP commanded from the state of the centre of mass (Kajita 2010)
  double tracking_position = 0.0;  // p_cmd = p_ref + position (c - c_ref) + velocity (v - v_ref) + zmp (p_ref - p)
  double tracking_velocity = 0.0;  // [s]
  double tracking_integral = 0.0;  // [1/s]
  bool landing = false;            // a foot that meets the ground too early stops there
  double landing_force = 60.0;     // [N] that counts as touching
  double landing_return = 0.3;     // [s] how fast the height difference is given back on both feet
  double force_filter = 0.01;      // [s] time constant on measured forces
  double rate_filter = 0.03;       // [s] on the gyro: turning the body over its feet shakes it a little
};

// Footholds placed anew from the measured divergent component of motion (capture point).
struct StepAdjustmentSpec {
  bool on = false;
  double gain = 1.0;        // foothold moved per difference of the divergent component [m/m]
  double follow = 5.0;      // [rad/s] how fast the body follows feet that have been moved
  double dead_band = 0.03;  // [m] differences that are left to the stabilizer
  double limit = 0.2;       // [m] most that a step is moved
  double freeze = 0.1;      // [s] before landing: the foot's place is final
};

// Attitude from gyro and accelerometer alone instead of the IMU's own orientation.
struct AttitudeFilterSpec {
  bool on = false;
  double time_constant = 5.0;  // [s]
};

struct WalkSpec {
  std::string left_foot, right_foot;      // links above the bushes
  std::string left_sensor = "left_foot";  // names of force sensors
  std::string right_sensor = "right_foot";
  std::string imu;                  // empty: the first
  double com_height = 0.0;          // [m] zc over the soles; 0: that of the initial pose
  double single_support = 0.7;      // [s]
  double double_support = 0.1;      // [s]
  double settle = 1.0;              // [s] from the initial pose to upright over the middle of the feet
  double transfer = 1.2;            // [s] of the first and the last shift of weight
  double swing_height = 0.05;       // [m]
  double landing_speed = 0.0;       // [m/s] downward reference speed of the swing foot when it touches
  double zmp_x = 0.0, zmp_y = 0.0;  // [m] ZMP reference from the middle of the sole: forward, inward
  double placement_position = 10.0, placement_velocity = 1.0;  // a, b of the foot placement
  bool measured_ground = false;         // the ground is tilted as the soles are at the start; else level
  double base_pitch = 0.0;              // [rad] lean of the body
  std::string first = "right";          // foot that steps first
  int count = 0;                        // steps that move by length, side, turn; one more brings the feet together
  double length = 0.0, side = 0.0;      // [m] a step
  double turn = 0.0;                    // [rad] a step
  std::vector<FootstepSpec> footsteps;  // instead of count
  double max_length = 0.40, min_width = 0.12, max_width = 0.40;  // [m] what the legs can do
  double max_turn = 0.6;                                         // [rad]
  double max_rise = 0.12;                                        // [m]
  StepAdjustmentSpec step_adjustment;
  AttitudeFilterSpec attitude_filter;
  StabilizerSpec stabilizer;
};

}  // namespace hrp
