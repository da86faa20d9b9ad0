// SPDX-License-Identifier: BSD-3-Clause
// How far soles that stand are from level by the encoders and the base's attitude, recording by recording.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnosis/floating/checks/checks.h"

namespace hrp::diagnosis::floating {

using TiltByRecording = std::map<int, Eigen::Vector2d>;  // roll, pitch [rad]

// Medians of a foot's tilt while it stands, in recordings where both are known.
TiltByRecording list_tilts(const std::vector<ChannelRows>& channels, const std::string& foot);

// A remaining difference for each flat foot that is askew. It may be the zeros of the leg's encoders, the ground, a
// sole that gives, or the attitude; one number cannot tell which. `recordings`: their names.
void check_soles(const std::vector<ChannelRows>& channels, const std::vector<std::string>& recordings,
                 CheckResult* out);

}  // namespace hrp::diagnosis::floating
