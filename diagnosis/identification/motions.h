// SPDX-License-Identifier: BSD-3-Clause
// The motions of [M14] for a robot with the legs of HRP-2: tilting of the chest in three stances with and without
// vertical sway, sways by an external hand on two feet and on one, random sweeps of the upper body, a squat. Soles stay
// on the floor; what is commanded is the pelvis over them, the attitude of each foot above its bush, and the upper
// body.
#pragma once

#include <map>
#include <random>
#include <string>
#include <vector>

#include "common/robot/scenario.h"
#include "controller/motion/motion.h"

namespace hrp::identification {

// amplitude sin(2 pi frequency t + phase), faded in and out over the ends of the motion.
struct Wave {
  double amplitude = 0.0, frequency = 0.0, phase = 0.0;  // [m or rad], [Hz], [rad]
};
using Waves = std::vector<Wave>;

struct MotionPlan {
  std::string name, meaning;
  double duration = 25.0;              // [s]
  unsigned long long seed = 0;         // beyond the scenario's: each motion has sensor noise of its own
  double width = 0.0, stride = 0.0;    // [m] each foot this much further out; right foot forward, left foot back
  Waves pelvis[3];                     // [m] x, y, z
  Waves lean[2], turn;                 // [rad] roll, pitch of the pelvis; yaw
  Waves foot[2][2];                    // [rad] foot (right, left), roll and pitch of what is above the bush
  std::map<std::string, Waves> upper;  // [rad] joints of the upper body
  Waves push[2];                       // [N] force on the trunk along x, y by an external hand
  // Single support: this foot (0 right, 1 left) is lifted and stays up, while a hand holds the trunk by a spring
  // and moves by `hand` [m] along x, y.
  int lifted = -1;
  Waves hand[2];
};

// Uniform in [0, 1), the same with every standard library.
inline double draw_share(std::mt19937_64* random) { return static_cast<double>((*random)() >> 11) * 0x1.0p-53; }

// Ours: eighteen motions after the paper's fourteen, with added turns of the feet, and four that show the vertical
// stiffness and the body. `scale` makes them shorter (tests): duration times scale, not below 0.5, or a foot that is
// lifted has no time in the air.
std::vector<MotionPlan> make_plans(double scale = 1.0);
// The paper's fourteen and nothing else: tilt1 to 3 in stances A, B, C and tilt4 to 6 the same with vertical motion;
// five sways by hand, one on two feet and two on each; two sweeps of the upper body; a squat.
std::vector<MotionPlan> make_paper_plans(double scale = 1.0);

// Joint trajectories every 10 ms. Throws std::runtime_error when a leg does not reach.
Motion make_motion(const MotionPlan& plan);
// Writes PLAN.csv and PLAN.yaml (`base` with motion, pose, pushes or hand, duration) into a folder; returns the
// scenario's path.
std::string write_motion(const MotionPlan& plan, const Scenario& base, const std::string& folder);
// The same for a motion that no plan made.
std::string write_motion(const Motion& motion, const std::string& name, const std::string& meaning,
                         unsigned long long seed, const Scenario& base, const std::string& folder);
// `base` with other rubber, to see whether the identification finds it; returns the scenario's path.
//   hardening:  stiffness about roll and pitch times 1 + (angle / kHardeningAngle)^2
//   hysteresis: a Bouc-Wen element beside the spring, about roll and pitch (joint law `hysteresis`)
enum class Rubber { kAsGiven, kHardening, kHysteresis };
constexpr double kHardeningAngle = 0.08;                            // [rad] a quarter stiffer at 40 mrad
constexpr double kHysteresisStiffness = 80.0, kYieldAngle = 0.006;  // [N m/rad], [rad] a fifth of K, up to 0.48 N m
std::string write_robot(const Scenario& base, Rubber rubber, const std::string& folder);

// The robot hanging with its feet in the air, to zero the force sensors.
std::string write_hanging(const Scenario& base, const std::string& folder);

// A look at a motion before it is used: a run in this process without noise.
struct MotionCheck {
  // While the feet stand that the plan wants to stand; of the foot that is lifted while it stands (standing.h).
  double margin = 0.0;         // [m] smallest distance of a foot's centre of pressure from the sole's edge
  double smallest_load = 0.0;  // [N] on either foot
  double in_the_air = 0.0;     // [s] that the lifted foot carries nothing
  bool as_planned = false;     // feet that should stand always do; a foot that is lifted gets into the air
  double condition = 0.0;      // of the scaled regressor [q qd 1], worst foot and axis
  // By foot, axis: Fisher information of stiffness [N m/rad], damping [N m s/rad] and offset [N m], where the torque's
  // noise is 1 N m in a band of 1 Hz. That of several motions adds (next/information.h).
  Eigen::Matrix3d fisher[2][2] = {{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()},
                                  {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()}};
  bool ok() const { return as_planned && margin > 0.005 && smallest_load > 30.0; }
};
// lifted: as in the plan.
MotionCheck check_motion(const std::string& scenario_path, int lifted = -1);

}  // namespace hrp::identification
