// SPDX-License-Identifier: BSD-3-Clause
// The robot's description as a log has it, of this version or of one before.
#pragma once

#include <vector>

#include "common/messages/cdr.h"
#include "hrp_idl/model.h"

namespace hrp {

// A description of before there were surfaces ends where the number of surfaces would stand. Four zero bytes behind it are an empty
// list; behind a whole one nobody reads them. Throws DecodeError as decode() does.
inline void decode_logged(Bytes sample, msg::RobotDescription* description) {
  std::vector<uint8_t> bytes(sample.data, sample.data + sample.size);
  bytes.resize(bytes.size() + 4, 0);
  decode(Bytes{bytes.data(), bytes.size()}, description);
}

}  // namespace hrp
