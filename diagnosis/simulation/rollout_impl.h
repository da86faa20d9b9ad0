// SPDX-License-Identifier: BSD-3-Clause
// The simulation along one recording behind rollout.h: its state, and what each stage does with it. Private to
// simulation. rollout.cpp runs along the rows, rollout_forces.cpp has the joints' laws at a state, rollout_step.cpp one
// step of the integrator.
//
// Coordinates: 0 to n - 1 are the joints' links; each elastic transmission adds one for its motor, from n to N - 1.
// Units: rad or m, N m or N, s.
#pragma once

#include <cmath>
#include <vector>

#include "diagnosis/simulation/rollout.h"

namespace hrp::diagnosis {

inline const double kGamma = 1.0 - 1.0 / std::sqrt(2.0);  // of ROS2: the value that makes it L-stable

// Positions and speeds by coordinate; by joint lagged effort, hysteresis relative to its largest value (-1 to 1), and
// the deflection of dry friction's bristles.
struct RolloutState {
  std::vector<double> q, v, u, z, b;
};

class Rollout {
 public:
  // Simulates `joints` of the robot with the dynamics `bodies`.
  Rollout(const Plant& plant, const Recording& recording, const SmoothRecording& smooth, std::vector<int> joints,
          Bodies* bodies);
  // Fills `readings` [row][joint][quantity], and `links` if given. Returns false if the motion becomes infinite.
  bool run(const RolloutOptions& options, const StartState* start, std::vector<double>* readings,
           std::vector<LinkMotion>* links);

 private:
  size_t index(int j) const { return static_cast<size_t>(joints_[static_cast<size_t>(j)]); }  // in the robot
  const JointLaws& laws(int j) const { return plant_.laws[index(j)]; }

  // ---- Along the recording (rollout.cpp)
  // Starts from the measured state at sample k.
  void begin(size_t k);
  void correct(const StartState& start);
  // Initial deflection of the bristles: from the drive's effort minus that of the motion.
  void start_bristles(size_t k);
  // Start of elastic joints. The encoder is on the motor; the link differs by the twist under the present load.
  void start_transmissions(size_t k);
  // Columns of joints that are not simulated stay 0.
  void write(size_t k, std::vector<double>* readings);
  void prepare_links(size_t rows);

  // ---- Laws of the joints at a state (rollout_forces.cpp)
  void choose_follow_gains();
  // Pulls the joint to its recorded motion.
  void follow(int j, double t, double q, double v);
  // Servo (or recorded) effort of joint j before lag. Sets K_ and D_ of its motor coordinate to the derivatives.
  double calc_drive(int j, double t, const RolloutState& x);
  // Viscous friction and cogging on the motor side. Adds the derivative to `slope`.
  double calc_friction(int j, double q, double v, double* slope) const;
  // Level of dry friction at a speed. The direction is that of the bent bristles `b`, since a joint at rest has none.
  double calc_level(int j, double speed, double load, double b) const;
  // A gear that is hard to drive backwards multiplies the braking effort of the drive (joint_law.h), with the rotor's
  // inertia. The factor grows with the deflection of its bristles, `bend` from -1 to 1.
  void add_gear(int j, double drive, double bend);
  // Dry friction by bristles that bend and slip (Dahl, AIAA J. 14, 1976): effort = -level b / d, b' = v - |v| b / d,
  // with the pre-sliding displacement d. The level follows speed and load without delay. While sliding, friction
  // therefore equals the law's level, however fast that changes.
  double calc_dry_friction(int j, double h, double v, double load, double b, double* slope);
  // Lags the effort u of the drive behind what it is asked for. Returns the effort now.
  double lag_effort(int j, double h, double u, const RolloutState& x);
  void add_hysteresis(int j, double h, const RolloutState& x);
  void calc_joint_forces(int j, double t, double h, const RolloutState& x);
  void calc_transmission(int j, const RolloutState& x);
  // Computes forces f_, derivatives K_ and D_, and mass matrix M_ at a state.
  void evaluate(double t, double h, const RolloutState& x);

  // ---- One step (rollout_step.cpp)
  // True for transmissions, which are much stiffer than a servo, and for dry friction along a recorded path. Small
  // steps cost little there, and steps of 1 ms would hide other effects of the joint.
  bool wants_small_steps() const;
  // True if dry friction holds a joint, or if it stops or starts within about a step of h [s]. The force is then not a
  // smooth function of time, and no method has order 2.
  bool is_turning(double h) const;
  // Solves (M + c D + c^2 K) x = rhs_ for x, with c = gamma h. Returns false if the matrix is not positive definite.
  bool solve(double c, double* x);
  // Subtracts c K dq, the change of the stiff terms, from rhs_.
  void subtract_stiffness(double c, const double* dq);
  // True if the servo is too stiff for its link. One step at the effort limit would then move the link far beyond the
  // reference, to the other limit. The simulation would oscillate between the limits, whatever the real servo does in
  // between.
  bool throws_over(int j, double h) const;
  // One step in which such servos leave their limit. The step assumes a servo without limit and is valid if the effort
  // at its end is within the limit. Otherwise the step is repeated with the limit.
  bool step_within_limits(double t, double h);
  bool clear_within();
  // One step of h [s]; false if it cannot be solved or the motion becomes infinite.
  bool step(double t, double h);
  bool start_stage(double c, const std::vector<double>& v, std::vector<double>* kv);
  bool run_first_stage(double h);
  bool run_second_stage(double h);
  double finish_bristles(int j, double c, const double* kv) const;
  // Limits bristles to the largest friction, whatever the step.
  void limit_bristles(int j);
  // Adds the forces on the motors from changes of lagged efforts and bristles within the stage.
  void add_lag(double c, const double* fu);
  void finish_memory(int j, double fu, double fz, const double* kq, const double* kv, double* ku, double* kz) const;

  const Plant& plant_;
  const Recording& recording_;
  const SmoothRecording& smooth_;
  std::vector<int> joints_;  // in the robot, by simulated joint
  Bodies& bodies_;
  int n_, N_ = 0;           // joints; coordinates
  std::vector<int> motor_;  // by joint: the coordinate of its motor; its own where the transmission is rigid
  std::vector<LinkMotion>* links_ = nullptr;
  size_t near_ = 0;  // row near the present time
  bool free_running_ = false;
  std::vector<double> follow_k_, follow_d_;  // by joint: the pull to the recorded motion
  std::vector<char> free_;                   // by joint: the drive does not hold it at present
  std::vector<char> within_;                 // by joint: the servo is within its limit again at the end of this step

  RolloutState x_, predicted_;  // at the start of a step; where its first stage leads to
  // By coordinate: force f, its negative derivatives K over position and D over speed, slopes of both stages.
  std::vector<double> f_, K_, D_, k1q_, k1v_, k2q_, k2v_, rhs_;
  std::vector<double> couple_k_, couple_d_;  // by motor coordinate: the derivatives over its link's motion
  std::vector<double> A_, M_;                // N x N: matrix of a stage and its factors; mass matrix with rotors
  std::vector<double> mass_, bias_;          // of the bodies, n x n and n
  // By joint: rates of lagged effort (u), hysteresis (z) and bristles (b), and their slopes in the first stage.
  std::vector<double> fu_, fz_, fb_, k1u_, k1z_, k1b_;
  // By joint, how these states follow the motion within a stage. Memories are eliminated from its equations.
  std::vector<double> lag_factor_, lag_k_, lag_d_, bristle_k_, bristle_a_, bristle_slip_;
  std::vector<double> gear_;  // by joint: share of the drive's effort by which the gear holds the load
};

}  // namespace hrp::diagnosis
