// SPDX-License-Identifier: BSD-3-Clause
// What a drive's effort, its servo and its velocity reading leave unexplained, joint by joint.
#pragma once

#include "common/robot/scenario.h"
#include "diagnosis/standing/terms.h"

namespace hrp::diagnosis::standing {

// One joint at one instant, as the rest of the hypothesis has it.
struct DriveState {
  double encoder = 0;       // [rad] what the servo reads
  double link = 0;          // [rad] where the link truly is
  double velocity = 0;      // [rad/s] of the motor
  double acceleration = 0;  // [rad/s^2]
  double torque = 0;        // [N m] by inverse dynamics
};

class Drives {
 public:
  Drives(const StandProblem& problem, const StandRecording& recording, const Terms& terms);

  // Torque that the drive was asked for at sample k, with its rate: the logged effort, or the servo law where there is
  // none, or where the law agrees with it and is less noisy.
  double find_effort(size_t joint, size_t k, const DriveState& s, double* rate) const;

  // What a joint's missing effort at sample k would change by if its hysteresis had begun with half a yield angle more;
  // 0 without hysteresis.
  double find_memory(size_t joint, size_t k) const;

  // Residuals of a joint at a sample.
  void add(size_t joint, size_t k, const DriveState& state, std::vector<double>* out) const;

 private:
  double take_friction(size_t joint, size_t k, double v, double given, double missing) const;
  double read_log(size_t joint, size_t k, double* rate) const;
  double calc_servo(size_t joint, size_t k, const DriveState& s, double* rate) const;
  // A series that is read `later` seconds after sample k.
  double read(const std::vector<double>& values, size_t k, double later) const;

  const StandProblem& p_;
  const StandRecording& r_;
  const Terms& terms_;
  std::vector<ServoGains> servo_;
  std::vector<std::vector<double>> wound_, aside_;  // Bouc-Wen states by joint, begun unwound and half a yield angle
                                                    // aside; empty without hysteresis
  size_t near_ = 1;                                 // samples of the recording between two kept ones
};

// How a recording's hysteresis began is not known: of the missing efforts (every `stride`-th of `rows` from `first` on,
// a sample each) what another beginning within the yield angle explains is taken out.
void take_out_memory(const Drives& drives, const StandRecording& recording, size_t joint, size_t first, size_t stride,
                     std::vector<double>* rows);

}  // namespace hrp::diagnosis::standing
