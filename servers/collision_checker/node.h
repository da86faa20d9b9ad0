// SPDX-License-Identifier: BSD-3-Clause
// The collision checker on a bus: answers every robot state with the contact set of the same step.
#pragma once

#include <memory>
#include <string>

#include "common/messages/convert.h"
#include "common/node/lockstep.h"
#include "common/node/node_base.h"
#include "common/node/view_writer.h"
#include "hrp_idl/collision.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"
#include "servers/collision_checker/collision_world.h"

namespace hrp {

class CollisionCheckerNode : public NodeBase {
 public:
  explicit CollisionCheckerNode(const NodeContext& context);
  std::string find_missing() const override;

 protected:
  void handle_idle(Clock::time_point now) override;

 private:
  void take_description(const msg::RobotDescription& message);
  void take_state(const msg::RobotState& message);

  RobotDescription robot_;
  BodyNames names_;
  std::unique_ptr<CollisionWorld> world_;
  QuestionFilter questions_;
  State state_;
  ObjectStates objects_;
  msg::ContactSet answer_;
  Bytes last_answer_;
  Publisher<msg::ContactSet> publisher_;
  ViewWriter view_;
};

}  // namespace hrp
