// SPDX-License-Identifier: BSD-3-Clause
// The messages of every step, encoded and decoded in pieces of memory: Fast CDR takes a call for each number. The bytes
// are the same. cdr.h includes this, so that no source encodes them in another way.
#pragma once

#include <vector>

#include "common/bus/bus.h"

namespace hrp {

namespace msg {
class RobotState;
class ContactForces;
class ContactSet;
class SensorData;
class JointCommands;
}  // namespace msg

// As the templates of cdr.h.
Bytes encode(const msg::RobotState& message, std::vector<char>* buffer);
Bytes encode(const msg::ContactForces& message, std::vector<char>* buffer);
Bytes encode(const msg::ContactSet& message, std::vector<char>* buffer);
Bytes encode(const msg::SensorData& message, std::vector<char>* buffer);
Bytes encode(const msg::JointCommands& message, std::vector<char>* buffer);

void decode(Bytes sample, msg::RobotState* message);
void decode(Bytes sample, msg::ContactForces* message);
void decode(Bytes sample, msg::ContactSet* message);
void decode(Bytes sample, msg::SensorData* message);
void decode(Bytes sample, msg::JointCommands* message);

}  // namespace hrp
