// SPDX-License-Identifier: BSD-3-Clause
// Messages <-> the plain structs that cores exchange (common/robot/signals.h). Targets are overwritten and keep their
// memory, so that a loop that converts into the same objects does not allocate.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/robot/fall_watch.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"
#include "hrp_idl/collision.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"

namespace hrp {

// Names of bodies by the index that contacts use: links, the ground (-1), obstacles (-2 - k), objects, links of other
// robots.
class BodyNames {
 public:
  BodyNames() = default;
  BodyNames(const RobotDescription& robot, const Scenario& scenario);
  bool contains(int body) const;
  const std::string& get(int body) const;

 private:
  std::vector<std::string> links_;
  std::vector<std::string> others_;   // ground, then obstacles
  std::vector<std::string> objects_;  // and links of other robots
};

msg::Vector3 to_message(const Vector3d& v);
msg::Quaternion to_message(const Eigen::Quaterniond& q);
msg::Pose to_message(const Transform& X);
Vector3d from_message(const msg::Vector3& v);
Eigen::Quaterniond from_message(const msg::Quaternion& q);
Transform from_message(const msg::Pose& pose);

// Header apart, which belongs to the loop and not to the content.
void to_message(const State& state, const Eigen::VectorXd& efforts, unsigned long long hash, msg::RobotState* message);
void from_message(const msg::RobotState& message, State* state);

// The scenario names them: first its objects, then its other robots. `efforts`: of each of these robots.
void to_message(const ObjectStates& states, const std::vector<Eigen::VectorXd>& efforts, const Scenario& scenario,
                msg::RobotState* message);
void from_message(const msg::RobotState& message, ObjectStates* states);

void to_message(const PushForces& pushes, msg::RobotState* message);
void from_message(const msg::RobotState& message, PushForces* pushes);

void to_message(const ContactSet& contacts, const BodyNames& names, msg::ContactSet* message);
void from_message(const msg::ContactSet& message, ContactSet* contacts);

void to_message(const ContactForces& forces, const BodyNames& names, msg::ContactForces* message);
void from_message(const msg::ContactForces& message, ContactForces* forces);

// Names of sensors come from the scenario, in its order.
void to_message(const SensorSample& sample, const SensorsSpec& sensors, msg::SensorData* message);
void from_message(const msg::SensorData& message, SensorSample* sample);

void to_message(const FallEvent& event, msg::RobotEvent* message);

void to_message(const JointCommand& command, msg::JointCommands* message);
void from_message(const msg::JointCommands& message, JointCommand* command);

}  // namespace hrp
