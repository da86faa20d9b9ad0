// SPDX-License-Identifier: BSD-3-Clause
// Which samples of a recording say something of its torques. Full grid, one flag a sample.
#pragma once

#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

using Flags = Eigen::Array<bool, Eigen::Dynamic, 1>;

constexpr double kFilterReach = 0.5;  // periods of the cutoff: so far a filter carries what happens at one sample

// Where the direction of motion is known: faster than `slow`, and out of the filter's reach of where the joint sticks.
Flags find_moving(const Eigen::VectorXd& v, double slow, double step, double cutoff);

// Full grid: far from gaps of a signal; NaN is no sample. A signal that nobody recorded has no gaps.
void mark_gaps(const std::vector<double>& time, const std::vector<double>& signal, const TorqueRecording& r, double sample_time,
               double cutoff, Flags* read);

// Where every encoder stays within its noise for a while from here on. `raw`: positions on the grid, not smoothed.
Flags find_still(const Eigen::MatrixXd& raw, const std::vector<double>& noise, double step);

// A joint that sticks breaks loose at its friction: efforts at rest stay within those in motion. Where they do not, the
// encoders no longer tell what the robot does.
Flags find_frozen(const TorqueRecording& r, const Flags& still);

// Impacts: what the filter takes off a foot's force is beyond any noise. `reach` samples around are left out with it.
void mark_sudden(const Eigen::VectorXd& raw, const Eigen::VectorXd& smooth, long reach, Flags* sudden);

// Efforts that stand at a limit: within 1 % of the greatest one for more than a fiftieth of the recording, which no
// motion does by chance. How much the drive gave there the log does not say.
Flags find_clipped(const Eigen::VectorXd& effort);

}  // namespace hrp::diagnosis
