// SPDX-License-Identifier: BSD-3-Clause
// Finds the events of a run in the samples that are logged, so that equal runs have equal logs, events and all.
#pragma once

#include <cstdint>
#include <vector>

#include "common/messages/convert.h"
#include "common/robot/fall_watch.h"
#include "common/robot/movers.h"
#include "servers/logger/log_writer.h"

namespace hrp {

class EventFinder {
 public:
  EventFinder(const RobotDescription& robot, const Scenario& scenario);
  // From encoded RobotState and ContactForces of one step: encoded RobotEvents, each for the topic of its robot. Steps
  // come in order. Nothing is decoded but the base's pose while a robot that is alone stands.
  std::vector<LogWriter::Part> find(const std::vector<uint8_t>& state, const std::vector<uint8_t>& forces);

 private:
  struct Base {
    Eigen::Quaterniond R_WB;
    Vector3d p_WB;
  };
  bool update_bases(const std::vector<uint8_t>& state);
  bool starts_epoch(const std::vector<uint8_t>& state);
  LogWriter::Part make_part(const FallEvent& event, const std::string& robot) const;

  Scenario scenario_;
  std::vector<Mover> robots_;
  std::vector<FallWatch> watches_;  // one a robot
  std::vector<Base> bases_;         // likewise, of the step
  bool any_epoch_ = false;
  uint64_t epoch_ = 0;
  msg::RobotState state_message_;
  ObjectStates others_;
  msg::ContactForces forces_message_;
};

// The samples of an encoded Pictures, each for its own topic of ROS 2.
std::vector<LogWriter::Part> unpack_pictures(const std::vector<uint8_t>& sample);

}  // namespace hrp
