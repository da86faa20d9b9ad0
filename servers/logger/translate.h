// SPDX-License-Identifier: BSD-3-Clause
// Finds the events of a run in the samples that are logged, so that equal runs have equal logs, events and all.
#pragma once

#include <cstdint>
#include <vector>

#include "common/messages/convert.h"
#include "common/robot/fall_watch.h"
#include "servers/logger/log_writer.h"

namespace hrp {

class EventFinder {
 public:
  EventFinder(const RobotDescription& robot, const Scenario& scenario) : watch_(robot, scenario) {}
  // From encoded RobotState and ContactForces of one step: an encoded RobotEvent, valid until the next call, or nullptr.
  // Steps come in order. Nothing is decoded but the base's pose while the robot stands.
  const std::vector<uint8_t>* find(const std::vector<uint8_t>& state, const std::vector<uint8_t>& forces);

 private:
  FallWatch watch_;
  bool any_epoch_ = false;
  uint64_t epoch_ = 0;
  msg::ContactForces forces_message_;
  ContactForces forces_;
  std::vector<uint8_t> event_;
};

// The samples of an encoded Pictures, each for its own topic of ROS 2.
std::vector<LogWriter::Part> unpack_pictures(const std::vector<uint8_t>& sample);

}  // namespace hrp
