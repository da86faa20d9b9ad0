// SPDX-License-Identifier: BSD-3-Clause
// Samples of every topic: the first byte chooses the type, the rest is what came from the bus.
#include "common/messages/cdr.h"
#include "hrp_idl/collision.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"
#include "hrp_idl/scheduling.h"
#include "hrp_idl/view.h"
#include "tests/fuzz/fuzz.h"

namespace {

// What was decoded can be encoded, and that again decoded.
template <typename Message>
void try_type(hrp::Bytes sample) {
  Message message;
  try {
    hrp::decode(sample, &message);
  } catch (const hrp::DecodeError&) {
    return;
  }
  std::vector<char> buffer;
  const hrp::Bytes again = hrp::encode(message, &buffer);
  Message same;
  hrp::decode(again, &same);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  namespace msg = hrp::msg;
  static void (*const kTypes[])(hrp::Bytes) = {try_type<msg::RobotDescription>,
                                               try_type<msg::ModelRefused>,
                                               try_type<msg::RobotState>,
                                               try_type<msg::SensorData>,
                                               try_type<msg::ContactSet>,
                                               try_type<msg::ContactForces>,
                                               try_type<msg::RobotEvent>,
                                               try_type<msg::JointCommands>,
                                               try_type<msg::ServerStatus>,
                                               try_type<msg::StepGrant>,
                                               try_type<msg::RunControl>,
                                               try_type<msg::RunStatus>,
                                               try_type<msg::View>};
  kTypes[data[0] % (sizeof kTypes / sizeof kTypes[0])]({data + 1, size - 1});
  return 0;
}
