// SPDX-License-Identifier: BSD-3-Clause
#include "servers/logger/translate.h"

#include <cstring>

#include "common/messages/cdr.h"
#include "common/messages/reflection/schema.h"
#include "common/messages/ros_topics.h"
#include "hrp_idl/vision.h"

namespace hrp {
namespace {

// RobotState in plain CDR: 4 bytes of encapsulation, header (epoch, step, time), rotation w x y z, translation x y z.
struct StateStart {
  uint64_t epoch, step;
  double time;
  double w, x, y, z;
  double p[3];
};

// False for big-endian samples, which no server of ours writes: such logs have no events.
bool read_start(const std::vector<uint8_t>& state, StateStart* start) {
  if (state.size() < 4 + sizeof *start || state[0] != 0 || state[1] != 1) return false;
  std::memcpy(start, state.data() + 4, sizeof *start);
  return true;
}

}  // namespace

std::vector<LogWriter::Part> unpack_pictures(const std::vector<uint8_t>& sample) {
  msg::Pictures pictures;
  decode({sample.data(), sample.size()}, &pictures);
  std::vector<LogWriter::Part> parts;
  for (msg::ViewSample& each : pictures.samples()) {
    const TopicSpec* known = topics::find_any_topic(each.topic());
    if (known == nullptr) continue;
    LogTopic topic;
    topic.name = each.topic();
    topic.type_name = known->type_name;
    topic.schema_text = find_schema_text(known->type_name);
    parts.push_back({topic, std::move(each.bytes())});
  }
  return parts;
}

EventFinder::EventFinder(const RobotDescription& robot, const Scenario& scenario)
    : scenario_(scenario), robots_(make_robots(robot, scenario)) {
  for (const Mover& each : robots_) watches_.emplace_back(each.robot, each.scenario, each.name);
}

// False when the state cannot be read.
bool EventFinder::update_bases(const std::vector<uint8_t>& state) {
  StateStart start;
  if (!read_start(state, &start)) return false;
  bases_.resize(1);
  bases_[0] = {Eigen::Quaterniond(start.w, start.x, start.y, start.z), Vector3d(start.p[0], start.p[1], start.p[2])};
  if (robots_.size() == 1) return true;
  decode({state.data(), state.size()}, &state_message_);
  from_message(state_message_, &others_);
  for (size_t k = 1; k < robots_.size(); ++k) {
    const State& other = others_.at(scenario_.objects.size() + k - 1);
    bases_.push_back({other.R_WB, other.p_WB});
  }
  return true;
}

bool EventFinder::starts_epoch(const std::vector<uint8_t>& state) {
  StateStart start;
  if (!read_start(state, &start) || (any_epoch_ && start.epoch == epoch_)) return false;
  any_epoch_ = true;
  epoch_ = start.epoch;
  return true;
}

LogWriter::Part EventFinder::make_part(const FallEvent& event, const std::string& robot) const {
  const TopicSpec topic = topics::of_robot(topics::kEvents, robot);
  msg::RobotEvent message;
  message.header(forces_message_.header());
  to_message(event, &message);
  std::vector<char> buffer;
  const Bytes bytes = encode(message, &buffer);
  LogWriter::Part part;
  part.topic.name = topic.name;
  part.topic.type_name = topic.type_name;
  part.topic.schema_text = find_schema_text(topic.type_name);
  part.sample.assign(bytes.data, bytes.data + bytes.size);
  return part;
}

std::vector<LogWriter::Part> EventFinder::find(const std::vector<uint8_t>& state, const std::vector<uint8_t>& forces) {
  std::vector<LogWriter::Part> parts;
  if (!update_bases(state)) return parts;
  const bool starts = starts_epoch(state);
  bool decoded = false;
  ContactForces all;
  for (size_t k = 0; k < watches_.size(); ++k) {
    if (starts) watches_[k].reset(bases_[k].R_WB, bases_[k].p_WB);
    if (starts || !watches_[k].is_due(bases_[k].R_WB, bases_[k].p_WB)) continue;
    if (!decoded) {
      decode({forces.data(), forces.size()}, &forces_message_);
      from_message(forces_message_, &all);
      decoded = true;
    }
    const auto event = watches_[k].update(find_own_forces(all, robots_[k]));
    if (event) parts.push_back(make_part(*event, robots_[k].name));
  }
  return parts;
}

}  // namespace hrp
