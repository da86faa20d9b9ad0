// SPDX-License-Identifier: BSD-3-Clause
// What dynamics sends to the logger: the samples of several steps as one packet. No step waits for the log, and a
// packet for each sample is half of the processor time of a run.
#pragma once

#include <string>

#include "common/messages/pubsub.h"
#include "hrp_idl/view.h"

namespace hrp {

class LogSamples {
 public:
  explicit LogSamples(Bus& bus);
  // Samples go nowhere until a logger was seen that reads them. Costs a question to the bus while none is.
  void look_for_reader() {
    if (!read_) update_readers();
  }
  // A sample of another topic, byte for byte; in the order of the calls. Sends what waits when that is enough for one
  // packet.
  void add(const std::string& topic, Bytes sample);
  void flush();
  // To be called at idle times: the reader may have gone.
  void update_readers() { read_ = publisher_.has_readers(); }

 private:
  Publisher<msg::View> publisher_;
  msg::View batch_;
  size_t count_ = 0;  // of the batch's samples that wait; the others keep their memory
  size_t bytes_ = 0;
  bool read_ = false;
};

}  // namespace hrp
