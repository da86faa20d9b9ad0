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

const std::vector<uint8_t>* EventFinder::find(const std::vector<uint8_t>& state, const std::vector<uint8_t>& forces) {
  StateStart start;
  if (!read_start(state, &start)) return nullptr;
  const Eigen::Quaterniond R_WB(start.w, start.x, start.y, start.z);
  const Vector3d p_WB(start.p[0], start.p[1], start.p[2]);
  if (!any_epoch_ || start.epoch != epoch_) {
    any_epoch_ = true;
    epoch_ = start.epoch;
    watch_.reset(R_WB, p_WB);
    return nullptr;
  }
  if (!watch_.is_due(R_WB, p_WB)) return nullptr;
  decode({forces.data(), forces.size()}, &forces_message_);
  from_message(forces_message_, &forces_);
  const auto event = watch_.update(forces_);
  if (!event) return nullptr;
  msg::RobotEvent message;
  message.header(forces_message_.header());
  to_message(*event, &message);
  std::vector<char> buffer;
  const Bytes bytes = encode(message, &buffer);
  event_.assign(bytes.data, bytes.data + bytes.size);
  return &event_;
}

}  // namespace hrp
