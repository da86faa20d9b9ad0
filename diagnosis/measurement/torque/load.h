// SPDX-License-Identifier: BSD-3-Clause
// Choices that the training recordings make before anything is judged: encoders behind the gears, the speed and the
// load that friction follows.
#pragma once

#include "diagnosis/measurement/torque/work.h"

namespace hrp::diagnosis {

// Regressors of a drive's effort beside the bodies' torque, on the full grid: acceleration, speed, direction,
// direction x |load|, position and 1 (a spring beside the drive).
Eigen::MatrixXd make_drive_columns(const TorqueData& data, const TorqueRecording& recording, int joint);

// Takes the links' motion from their own encoders. The training recordings decide, because an encoder may be faulty.
void choose_encoders(TorqueWork* work);

// Chooses a joint's speed (sharp or smoothed) and load, see TorqueData::loaded_by_drive.
void choose_speed_and_load(TorqueWork* work, int joint);

}  // namespace hrp::diagnosis
