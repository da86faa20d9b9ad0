// SPDX-License-Identifier: BSD-3-Clause
// A controller on a bus: answers every sample of sensor data with joint commands of the same step.
#pragma once

#include <memory>
#include <vector>

#include "common/messages/convert.h"
#include "common/node/lockstep.h"
#include "common/node/node_base.h"
#include "common/node/view_writer.h"
#include "controller/client.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"

namespace hrp {

Robot make_robot(const RobotDescription& description, const Scenario& scenario);

class ControllerNode : public NodeBase {
 public:
  ControllerNode(const NodeContext& context, ControllerMaker make_controller);
  std::string find_missing() const override;

 protected:
  void handle_idle(Clock::time_point now) override;

 private:
  void take_description(const msg::RobotDescription& message);
  void take_sensors(const msg::SensorData& message);

  ControllerMaker make_controller_;
  std::unique_ptr<Controller> controller_;
  Robot robot_;
  QuestionFilter questions_;
  bool in_epoch_ = false;
  uint64_t epoch_ = 0;
  SensorData sensors_;
  msg::JointCommands answer_;
  Bytes last_answer_;
  TopicSpec commands_;  // of its robot
  Publisher<msg::JointCommands> publisher_;
  ViewWriter view_;
};

}  // namespace hrp
