// SPDX-License-Identifier: BSD-3-Clause
// Residuals ("channels") of a standing robot: equations between its recorded signals, under a hypothesis.
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
// Each equation is exact for any motion, so no simulation is needed. Effects of a hypothesis change sensors, masses,
// joints or feet before the residuals are computed.
#pragma once

#include "diagnosis/standing/drive.h"
#include "diagnosis/standing/layout.h"

namespace hrp::diagnosis::standing {

// Results of one recording. Effects of one drive (StandRow::at_drive) change only the channels of that drive.
struct StandBase {
  std::vector<double> residuals;
  std::vector<DriveState> states;  // by sample, by joint
  std::vector<char> flat;          // by sample: all feet stand flat
  std::vector<double> ratios;      // by sample: friction that a foot asks for, the most of all
};

// Residuals of one recording, flat: [sample][channel]. 0 means that a channel says nothing: tilt and gap of a foot on
// an edge of its sole, or a joint that friction holds.
std::vector<double> calc_channels(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording,
                                  StandBase* base = nullptr);

// Distance [rad] that a joint's link must move against its encoder, without regard to torque, so that the feet stay in
// place. It is the range of nine tenths of the training samples.
double find_play(const StandProblem& problem, const Hypothesis& hypothesis, size_t joint);

// Writes the observed motion [rad] of a free link into `backlash` (p[3]) if no torque ever held it at both ends of the
// gap; else 0. If no torque held it at either end, the gap is set to kMostPlay and the link counts as free everywhere.
void find_seen_play(const StandProblem& problem, const Hypothesis& hypothesis, Effect* backlash);

// As calc_channels(), but fast: for a hypothesis that differs from that of `base` only in effects of one joint's drive.
std::vector<double> calc_drive_channels(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording,
                                        const StandBase& base, int joint);

}  // namespace hrp::diagnosis::standing
