// SPDX-License-Identifier: BSD-3-Clause
// Flags of the samples whose torques can be used: full grid, one flag per sample.
#pragma once

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

using Flags = Eigen::Array<bool, Eigen::Dynamic, 1>;

constexpr double kFilterReach = 0.5;  // [periods of the cutoff] distance to which the filter spreads a sample

// True where the direction of motion is known: faster than `slow`, and outside the filter's reach of sticking.
Flags find_moving(const Eigen::VectorXd& v, double slow, double step, double cutoff);

// Clears the flags near gaps of a signal (NaN: no sample). A signal that was not recorded has no gaps. `sample_time`
// [s], `cutoff` [Hz].
void mark_gaps(const std::vector<double>& time, const std::vector<double>& signal, const TorqueRecording& r,
               double sample_time, double cutoff, Flags* read);

// True where every encoder stays within its noise for a while. `raw`: unfiltered positions on the grid.
Flags find_still(const Eigen::MatrixXd& raw, const std::vector<double>& noise, double step);

// Finds frozen logs. A joint that sticks breaks loose at its friction, so efforts at rest stay within those in motion.
// If they do not, the encoders no longer measure the robot.
Flags find_frozen(const TorqueRecording& r, const Flags& still);

// Sets the flags at impacts, where the filter removes more of a foot's force than noise explains, and `reach` samples
// around.
void mark_sudden(const Eigen::VectorXd& raw, const Eigen::VectorXd& smooth, long reach, Flags* sudden);

// Finds efforts at a limit: within 1 % of the largest one for more than a fiftieth of the recording, which does not
// happen by chance. The log does not tell the drive's true effort there.
Flags find_clipped(const Eigen::VectorXd& effort);

}  // namespace hrp::diagnosis
