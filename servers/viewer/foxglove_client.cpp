// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/foxglove_client.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "common/base/ros_definitions.h"
#include "common/messages/topics.h"
#include "common/scene/foxglove.h"
#include "servers/viewer/dump_json.h"
#include "servers/viewer/foxglove_scene.h"

namespace hrp {
namespace {

using Json = nlohmann::json;

constexpr size_t kMostSubscriptions = 256;
constexpr char kMessageData = 1;
enum StatusLevel { kInfo, kWarning, kError };

template <typename Number>
void append(std::string* out, Number value) {
  // Little endian, as this machine is (common/mcap/format.cpp checks).
  out->append(reinterpret_cast<const char*>(&value), sizeof value);
}

const Json& get_list(const Json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end() || !found->is_array()) throw ProtocolError(std::string("expected a list '") + key + "'");
  return *found;
}

uint32_t get_id(const Json& value) {
  if (!value.is_number_unsigned() || value.get<uint64_t>() > UINT32_MAX) throw ProtocolError("expected an id");
  return value.get<uint32_t>();
}

// Pictures by the names of ROS 2, or the Image panel and the 3D panel would not know them.
Json describe(const std::string& topic, const std::string& type, const std::string& schema) {
  if (!is_of_camera(type))
    return {
        {"topic", topic}, {"encoding", "cdr"}, {"schemaName", type}, {"schema", schema}, {"schemaEncoding", "omgidl"}};
  const std::string name = find_ros_name(type), ros_topic = topics::find_ros_topic(topic);
  return {{"topic", ros_topic.empty() ? topic : ros_topic},
          {"encoding", "cdr"},
          {"schemaName", name},
          {"schema", make_ros_schema(name)},
          {"schemaEncoding", "ros2msg"}};
}

// [s] -> [ns]. A page may ask for any time: what no clock can show is the first or the last moment of one.
uint64_t make_nanoseconds(double time) {
  constexpr double kLast = 9.2e9;  // [s], nearly 2^63 ns
  return std::isfinite(time) ? static_cast<uint64_t>(std::llround(std::clamp(time, 0.0, kLast) * 1e9)) : 0;
}

// A sample for a subscription, as the protocol has it.
Payload make_data(uint32_t subscription, Bytes sample, double time) {
  std::string message(1, kMessageData);
  append(&message, subscription);
  append(&message, make_nanoseconds(time));
  message.append(reinterpret_cast<const char*>(sample.data), sample.size);
  return make_payload(std::move(message));
}

}  // namespace

FoxgloveClient::FoxgloveClient(Connection& connection, Viewer& viewer) : connection_(connection), viewer_(viewer) {
  viewer_.join(this);
  const Json info{{"op", "serverInfo"},
                  {"name", "openhrp-dds viewer"},
                  {"capabilities", Json::array()},
                  {"supportedEncodings", Json::array()},
                  {"metadata", Json::object()}};
  connection_.send(make_payload(dump_json(info)), false, Urgency::kNeeded);
  advertise();
}

FoxgloveClient::~FoxgloveClient() { viewer_.leave(this); }

void FoxgloveClient::advertise() {
  Json added = Json::array();
  const auto add = [&](const std::string& topic, Json described) {
    if (channels_.count(topic)) return;
    Channel& channel = channels_[topic];
    channel.id = next_id_++;
    channel.picture = is_picture(described["schemaName"]);
    described["id"] = channel.id;
    added.push_back(std::move(described));
  };
  const auto topics = viewer_.find_topics();
  for (const auto& [topic, type] : topics) add(topic, describe(topic, type, viewer_.find_schema(topic)));
  for (const FoxgloveScene::Channel& channel : FoxgloveScene::channels()) {
    if (!topics.count(channel.source)) continue;
    add(channel.topic, {{"topic", channel.topic},
                        {"encoding", "json"},
                        {"schemaName", channel.type},
                        {"schema", foxglove::find_schema(channel.type)},
                        {"schemaEncoding", "jsonschema"}});
  }
  if (added.empty()) return;
  connection_.send(make_payload(dump_json({{"op", "advertise"}, {"channels", added}})), false, Urgency::kNeeded);
}

void FoxgloveClient::on_message(const std::string& message, bool binary) {
  // The binary messages of clients (publishing, services) are for capabilities that we do not offer.
  if (binary) return send_status(kError, "this server only reads: binary messages of clients are not taken");
  const Json request = Json::parse(message, nullptr, false);
  if (!request.is_object() || !request.contains("op") || !request["op"].is_string()) {
    throw ProtocolError("expected a JSON object with an op");
  }
  const std::string op = request["op"];
  if (op == "subscribe") return subscribe(request);
  if (op == "unsubscribe") return unsubscribe(request);
  send_status(kWarning, "'" + op + "' is not offered by this server");
}

void FoxgloveClient::subscribe(const Json& request) {
  for (const Json& subscription : get_list(request, "subscriptions")) {
    if (!subscription.is_object()) throw ProtocolError("expected subscriptions of id and channelId");
    const uint32_t id = get_id(subscription.value("id", Json())),
                   channel_id = get_id(subscription.value("channelId", Json()));
    bool found = false;
    for (auto& [topic, channel] : channels_) {
      if (channel.id != channel_id || channel.subscriptions.size() >= kMostSubscriptions) continue;
      channel.subscriptions.emplace(id, false);
      found = true;
    }
    if (!found) send_status(kError, "there is no channel " + std::to_string(channel_id));
  }
  update_pictures();
  viewer_.show_time(viewer_.shown_time());
}

void FoxgloveClient::unsubscribe(const Json& request) {
  for (const Json& id : get_list(request, "subscriptionIds")) {
    size_t removed = 0;
    for (auto& [topic, channel] : channels_) removed += channel.subscriptions.erase(get_id(id));
    if (removed == 0) send_status(kWarning, "there is no subscription " + std::to_string(get_id(id)));
  }
  update_pictures();
}

void FoxgloveClient::update_pictures() {
  std::set<PictureKey> keys;
  for (const auto& [topic, channel] : channels_) {
    if (channel.picture && !channel.subscriptions.empty()) keys.insert({0, topic});
  }
  pictures_.show(keys);
  pictures_.forget();  // a subscription that is new has none yet
}

void FoxgloveClient::send_status(int level, const std::string& text) {
  connection_.send(make_payload(dump_json({{"op", "status"}, {"level", level}, {"message", text}})), false,
                   Urgency::kNeeded);
}

bool FoxgloveClient::reads(const std::string& topic) const {
  const auto found = channels_.find(topic);
  return found != channels_.end() && !found->second.subscriptions.empty();
}

void FoxgloveClient::send(const std::string& topic, Bytes sample, double time, bool again) {
  const auto found = channels_.find(topic);
  if (found == channels_.end()) return;
  for (auto& [id, sent] : found->second.subscriptions) {
    if (sent && !again) continue;
    connection_.send(make_data(id, sample, time), true, Urgency::kStream);
    sent = true;
  }
}

bool FoxgloveClient::send_picture(const std::string& topic, Bytes sample) {
  bool any = false;
  for (auto& [id, sent] : channels_.at(topic).subscriptions) {
    sent = connection_.send(make_data(id, sample, read_stamp(sample)), true, Urgency::kPicture);
    any = any || sent;
  }
  return any;
}

}  // namespace hrp
