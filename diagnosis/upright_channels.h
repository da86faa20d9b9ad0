// SPDX-License-Identifier: BSD-3-Clause
// What a standing robot's recordings say that must agree, as residuals ("channels"), under a hypothesis.
//
//   tilt      each foot's roll and pitch against the level ground: attitude and encoders
//   gap       vector between the feet, less its mean over the recording
//   balance   the six equations of motion of the whole body: IMU and encoders against the foot sensors
//   effort    each drive's effort against inverse dynamics with the measured foot wrenches
//   servo     each drive's effort against its servo law
//   gyro      rate of the attitude against the gyroscope
//   gravity   mean specific force against the attitude
//
// Each is exact for any motion, so nothing has to be simulated; what a hypothesis changes in sensors, masses, joints or
// feet is applied before the residual is taken.
#pragma once

#include "diagnosis/upright_data.h"

namespace hrp::diagnosis::upright {

enum class StandId {
  kViscous, kCoulomb, kRotorInertia, kSpring, kTorqueConstant, kJointOffset, kCommandDelay, kActuatorLag,
  kPayload, kMassError, kComError, kExternalForce,
  kFootCompliance, kFootHardening, kGroundSlope, kGroundFriction,
  kForceBias, kTorqueBias, kForceScale, kTorqueScale, kWrenchDelay, kWrenchMisalignment, kWrenchSkew,
  kGyroBias, kAccelerometerBias, kGyroScale, kAccelerometerScale, kImuDelay, kImuMisalignment, kImuSkew,
  kEffortBias, kEffortScale
};

// One effect at one place (joint, link, foot; unused for the IMU and the ground) with its parameters. Feet's compliance
// is linear in what it is written in: per foot and axis 1/k, c/k, and two nuisances that stand for where the bush's
// centre truly is (vertical and horizontal force times a lever over k); then 1/kz; with hardening one coefficient
// [1/rad^2] for both axes.
struct StandEffect {
  StandId id;
  int place = 0;
  std::vector<double> p;
};
using StandHypothesis = std::vector<StandEffect>;

struct Channel {
  std::string kind;    // as above
  std::string signal;  // the recorded signal nearest to it, as in the report
  std::string joint, foot, sensor, link;  // where it points, empty where it does not
};

std::vector<Channel> list_channels(const StandProblem& problem);

// Ratio of tangential to normal force at which the feet of the recordings were seen to slip: median over the samples in
// which the gap between them changed, and its spread. False when nothing slipped, or at ratios that scatter.
bool find_slip_ratio(const StandProblem& problem, double* ratio, double* spread);

// Residuals [sample][channel], flat, of one recording. 0 where a channel says nothing: tilt and gap of a foot that
// stands on an edge of its sole.
std::vector<double> calc_channels(const StandProblem& problem, const StandHypothesis& hypothesis, size_t recording);

constexpr size_t kFootParameters = 9;

}  // namespace hrp::diagnosis::upright
