// SPDX-License-Identifier: BSD-3-Clause
// Choices that the training recordings make before anything is judged: encoders behind the gears, the speed and the load
// that friction follows.
#pragma once

#include "diagnosis/measurement/torque_work.h"

namespace hrp::diagnosis {

// Takes the links' motion from their own encoders. The training recordings decide, because an encoder may be faulty.
void choose_encoders(TorqueWork* work);

// Chooses a joint's speed (sharp or smoothed) and load, see TorqueData::loaded_by_drive.
void choose_speed_and_load(TorqueWork* work, int joint);

}  // namespace hrp::diagnosis
