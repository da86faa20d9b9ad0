// SPDX-License-Identifier: BSD-3-Clause
// Residuals of each drive: of its effort, of its servo law and of its velocity reading.
#pragma once

#include "common/robot/scenario.h"
#include "diagnosis/standing/terms.h"

namespace hrp::diagnosis::standing {

// State of one joint at one sample, under the hypothesis.
struct DriveState {
  double encoder = 0;       // [rad] reading of the servo
  double link = 0;          // [rad] true position of the link
  double velocity = 0;      // [rad/s] of the motor
  double acceleration = 0;  // [rad/s^2]
  double torque = 0;        // [N m] by inverse dynamics of the link side
};

// Residuals of all drives in one recording under one hypothesis.
class Drives {
 public:
  Drives(const StandProblem& problem, const StandRecording& recording, const Terms& terms);

  // Torque [N m] that the drive was asked for at sample k, and its rate [N m/s]. It is the logged effort. It is the
  // servo law if there is no log, or if the law agrees with the log and is less noisy (StandProblem::has_law).
  double find_effort(size_t joint, size_t k, const DriveState& s, double* rate) const;

  // Change of a joint's missing effort [N m] at sample k if its hysteresis had started half a yield angle away; 0
  // without hysteresis.
  double find_memory(size_t joint, size_t k) const;

  // Appends the residuals of a joint at sample k: effort, servo, velocity, as far as recorded.
  void add(size_t joint, size_t k, const DriveState& state, std::vector<double>* out) const;

 private:
  double take_friction(size_t joint, size_t k, double v, double given, double missing) const;
  double read_log(size_t joint, size_t k, double* rate) const;
  double calc_servo(size_t joint, size_t k, const DriveState& s, double* rate) const;
  // Interpolates a series `later` seconds after sample k.
  double read(const std::vector<double>& values, size_t k, double later) const;

  const StandProblem& p_;
  const StandRecording& r_;
  const Terms& terms_;
  std::vector<ServoGains> servo_;
  std::vector<std::vector<double>> wound_, aside_;  // Bouc-Wen states [rad] by joint, started at 0 and half a
                                                    // yield angle aside; empty without hysteresis
  size_t near_ = 1;                                 // samples of the recording from one kept sample to the next
};

// Subtracts what an unknown initial state of the hysteresis, within its yield angle, explains. `rows`: residuals of one
// sample each, every `stride`-th from index `first`.
void take_out_memory(const Drives& drives, const StandRecording& recording, size_t joint, size_t first, size_t stride,
                     std::vector<double>* rows);

}  // namespace hrp::diagnosis::standing
