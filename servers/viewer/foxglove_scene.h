// SPDX-License-Identifier: BSD-3-Clause
// What Foxglove's 3D panel draws, made from topics of the run only for clients that read it: frames, shapes, forces.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/messages/reflection/schema.h"
#include "hrp_idl/model.h"

namespace hrp {

class FoxgloveScene {
 public:
  struct Channel {
    std::string topic, type;
    std::string source;  // the topic of the run that it is made from
  };
  FoxgloveScene();
  ~FoxgloveScene();
  static const std::vector<Channel>& channels();
  // Until then every message is empty.
  void set_robot(const msg::RobotDescription& description);
  // The JSON message of a channel from the sample of its source; empty when it cannot be made.
  std::string make(const Channel& channel, double time, Bytes source) const;

 private:
  struct Robot;
  std::unique_ptr<Robot> robot_;
};

}  // namespace hrp
