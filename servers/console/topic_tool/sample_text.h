// SPDX-License-Identifier: BSD-3-Clause
// Text as `ros2 topic pub` takes it (YAML, so JSON, too) -> the encoded sample.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/messages/reflection/schema.h"

namespace hrp {

// "{joint_names: [knee], points: [{positions: [0.3], time_from_start: {sec: 2}}]}". What the text does not mention is
// zero or empty. Throws InputError naming field, value and what was expected.
std::vector<uint8_t> encode_text(const StructType& type, const std::string& text);

}  // namespace hrp
