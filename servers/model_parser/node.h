// SPDX-License-Identifier: BSD-3-Clause
// The model parser on a bus: one description, kept for late joiners, or one refusal.
#pragma once

#include <string>
#include <vector>

#include "common/node/node_base.h"
#include "common/robot/robot_description.h"
#include "hrp_idl/model.h"

namespace hrp {

class ModelParserNode : public NodeBase {
 public:
  // Loads scenario and robot at once; what is wrong with them becomes hrp/model_refused and a fault. Verbose: says
  // every warning; otherwise meshes that are missing and not needed are counted.
  ModelParserNode(const NodeContext& context, const std::string& scenario_path, bool verbose = false);

 private:
  void load(const std::string& scenario_path, bool verbose);
  void publish_other(const OtherRobot& other);

  Publisher<msg::RobotDescription> description_publisher_;
  Publisher<msg::ModelRefused> refused_publisher_;
  std::vector<Publisher<msg::RobotDescription>> other_publishers_;  // of the scenario's other robots
};

}  // namespace hrp
