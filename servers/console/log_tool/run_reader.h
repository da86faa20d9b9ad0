// SPDX-License-Identifier: BSD-3-Clause
// Goes once through the log of a run and hands out what others want to show of it, thinned to a rate.
#pragma once

#include <string>

#include "common/bus/bus.h"
#include "common/mcap/reader.h"
#include "common/multibody/state.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"

namespace hrp {

// Where and when a message stands in the log.
struct LogPlace {
  uint64_t log_time = 0;  // [ns] simulated
  uint32_t sequence = 0;
  double time = 0.0;  // [s] simulated
};

struct RunStep {
  State state;  // of the first robot
  ObjectStates others;
  ContactForces forces;
  PushForces pushes;  // from outside
};

class RunListener {
 public:
  virtual ~RunListener() = default;
  // Once, before all others.
  virtual void on_robot(const RobotDescription& robot, const Scenario& scenario, const LogPlace& place) = 0;
  // States and forces of one step; the forces of step 0 are empty.
  virtual void on_step(const RunStep& step, const LogPlace& place) = 0;
  // `robot`: 0 is the first one, then the others in the order of the scenario.
  virtual void on_sensors(size_t robot, const msg::SensorData& sensors, const LogPlace& place) = 0;
  virtual void on_commands(size_t robot, const msg::JointCommands& commands, const LogPlace& place) = 0;
  // A picture or a scan ("rt/<camera>/image_raw") of this type of ROS 2, as it was sent, whatever the rate.
  virtual void on_picture(const std::string& topic, const std::string& type, Bytes sample, const LogPlace& place) {
    (void)topic, (void)type, (void)sample, (void)place;
  }
  // Every message as it stands in the log, whatever the rate.
  virtual void on_message(const mcap::Message&) {}
};

// `rate` [Hz]: samples a second of simulated time, 0: every one. Damage is said and ends the log. Throws
// std::runtime_error when the log has no robot. Returns an exit code: 1 when the log is damaged.
int read_run(mcap::Reader* log, double rate, RunListener* listener);

}  // namespace hrp
