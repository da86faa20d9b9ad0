// SPDX-License-Identifier: BSD-3-Clause
// What a log has of this version or of one before: the robot's description, and its state.
#pragma once

#include <vector>

#include "common/messages/cdr.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"

namespace hrp {

// A description of before there were surfaces, visuals or other robots ends where their number would stand, and a state
// of before there were objects or other robots likewise. Four zero bytes are an empty list; behind a whole one nobody
// reads them. Throws DecodeError as decode() does. Message: RobotDescription or RobotState.
template <typename Message>
void decode_logged(Bytes sample, Message* message) {
  std::vector<uint8_t> bytes(sample.data, sample.data + sample.size);
  bytes.resize(bytes.size() + 16, 0);
  decode(Bytes{bytes.data(), bytes.size()}, message);
}

}  // namespace hrp
