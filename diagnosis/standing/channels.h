// SPDX-License-Identifier: BSD-3-Clause
// What a standing robot's recordings say that must agree, as residuals ("channels"), under a hypothesis.
//
//   tilt      roll and pitch of each flat foot against the level ground: attitude and encoders
//   stand     place of the first foot by the base's recorded pose, less its mean over the recording
//   gap       vector between the feet, less its mean over the recording
//   balance   the six equations of motion of the whole body: IMU and encoders against the foot sensors
//   base      the base's recorded attitude against the IMU's
//   effort    each drive's effort (by its servo law where not logged) against inverse dynamics with the foot wrenches
//   servo     each drive's effort against its servo law
//   velocity  each encoder's velocity against the rate of its position
//   gyro      rate of the attitude against the gyroscope
//   gravity   mean specific force against the attitude
//
// Each is exact for any motion, so nothing has to be simulated; what a hypothesis changes in sensors, masses, joints or
// feet is applied before the residual is taken.
#pragma once

#include "diagnosis/standing/drive.h"
#include "diagnosis/standing/layout.h"

namespace hrp::diagnosis::standing {

// What effects of drives (StandRow::at_drive) leave as it is, of one recording.
struct StandBase {
  std::vector<double> residuals;
  std::vector<DriveState> states;  // by sample, by joint
  std::vector<char> flat;          // by sample: all feet stand flat
  std::vector<double> ratios;      // by sample: friction that a foot asks for, the most of all
};

// Residuals [sample][channel], flat, of one recording. 0 where a channel says nothing: tilt and gap of a foot that
// stands on an edge of its sole, a joint that is stuck.
std::vector<double> calc_channels(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording,
                                  StandBase* base = nullptr);

// [rad] How far a joint's link would have to move against its encoder, whatever the torque, for the feet to stand where
// they stand: range of nine tenths of the training samples.
double find_play(const StandProblem& problem, const Hypothesis& hypothesis, size_t joint);

// [rad] Notes in a loose transmission what its free link was seen to move, if no torque ever held it at both ends of
// the gap. Where none held it at either end the gap may be any: then the link is free wherever it is.
void find_seen_play(const StandProblem& problem, const Hypothesis& hypothesis, Effect* backlash);

// The same for a hypothesis that differs from that of `base` only in effects of one joint's drive: fast.
std::vector<double> calc_drive_channels(const StandProblem& problem, const Hypothesis& hypothesis,
                                        size_t recording, const StandBase& base, int joint);

}  // namespace hrp::diagnosis::standing
