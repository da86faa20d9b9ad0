// SPDX-License-Identifier: BSD-3-Clause
// A log for Foxglove: all that the log holds, and what its 3D panel draws.
#include <cstdio>

#include "common/base/shared_files.h"
#include "common/messages/topics.h"
#include "common/scene/foxglove.h"
#include "servers/console/log_tool/commands.h"
#include "servers/console/log_tool/log_file.h"
#include "servers/console/log_tool/ros_topics.h"

namespace hrp {
namespace {

constexpr size_t kChunkSize = size_t{1} << 20;

class FoxgloveFile final : public RunListener {
 public:
  FoxgloveFile(const mcap::Reader& log, mcap::Writer* writer)
      : writer_(*writer), ros_(writer, RosTopics::Frames::kNone) {
    copy_channels(log);
    const uint16_t transforms = add_schema(foxglove::kFrameTransforms), scene = add_schema(foxglove::kSceneUpdate);
    fixed_ = writer_.add_channel("/transforms/fixed", transforms, "json");
    moving_ = writer_.add_channel("/transforms", transforms, "json");
    robot_ = writer_.add_channel("/scene/robot", scene, "json");
    world_ = writer_.add_channel("/scene/world", scene, "json");
    contacts_ = writer_.add_channel("/scene/contacts", scene, "json");
    pushes_ = writer_.add_channel("/scene/pushes", scene, "json");
  }

  void on_robot(const RobotDescription& robot, const Scenario& scenario, const LogPlace& place) override {
    scene_ = std::make_unique<foxglove::Scene>(robot, scenario);
    scenario_ = robot.scenario;
    ros_.on_robot(robot, scenario, place);
    write(fixed_, scene_->make_fixed_transforms(place.time), place);
    write(robot_, scene_->make_robots(place.time, &notes_), place);
    write(world_, scene_->make_world(place.time), place);
  }
  void on_step(const RunStep& step, const LogPlace& place) override {
    write(moving_, scene_->make_transforms(step.state, step.others, place.time), place);
    write(contacts_, scene_->make_contacts(step.forces, place.time), place);
    write(pushes_, scene_->make_pushes(step.state, step.others, step.pushes, place.time), place);
    ros_.on_step(step, place);
  }
  void on_sensors(size_t robot, const msg::SensorData& sensors, const LogPlace& place) override {
    ros_.on_sensors(robot, sensors, place);
  }
  void on_commands(size_t robot, const msg::JointCommands& commands, const LogPlace& place) override {
    ros_.on_commands(robot, commands, place);
  }
  void on_picture(const std::string& topic, const std::string& type, Bytes sample, const LogPlace& place) override {
    ros_.on_picture(topic, type, sample, place);
    has_pictures_ = true;
  }
  void on_message(const mcap::Message& message) override {
    const auto channel = channels_.find(message.channel_id);
    if (channel == channels_.end()) return;  // a picture: on_picture() writes it
    mcap::Message copy = message;
    copy.channel_id = channel->second;
    writer_.add_message(copy);
    if (writer_.open_chunk_size() > kChunkSize) writer_.write_chunk();
  }
  void add_attachments() {
    for (const Mover& robot : scene_->robots()) {
      writer_.add_attachment(robot.name.empty() ? "robot.urdf" : robot.name + ".urdf", "application/xml",
                             robot.robot.urdf);
    }
    writer_.add_attachment("scenario.yaml", "application/yaml", scenario_);
  }
  const std::vector<std::string>& notes() const { return notes_; }
  const char* find_layout() const { return has_pictures_ ? "foxglove/cameras.json" : "foxglove/robot.json"; }

 private:
  void copy_channels(const mcap::Reader& log) {
    std::map<uint16_t, uint16_t> schemas;
    for (const auto& [id, schema] : log.schemas())
      schemas[id] = writer_.add_schema(schema.name, schema.encoding, schema.text);
    for (const auto& [id, channel] : log.channels()) {
      if (!topics::find_ros_topic(channel.topic).empty()) continue;
      channels_[id] = writer_.add_channel(channel.topic, schemas.at(channel.schema_id), channel.message_encoding);
    }
  }
  uint16_t add_schema(const char* type) { return writer_.add_schema(type, "jsonschema", foxglove::find_schema(type)); }
  void write(uint16_t channel, const std::string& json, const LogPlace& place) {
    mcap::Message out;
    out.channel_id = channel;
    out.sequence = place.sequence;
    out.log_time = out.publish_time = place.log_time;
    out.data = reinterpret_cast<const uint8_t*>(json.data());
    out.size = json.size();
    writer_.add_message(out);
  }

  mcap::Writer& writer_;
  RosTopics ros_;
  std::map<uint16_t, uint16_t> channels_;  // of the log -> of the file
  uint16_t fixed_, moving_, robot_, world_, contacts_, pushes_;
  std::unique_ptr<foxglove::Scene> scene_;
  bool has_pictures_ = false;
  std::string scenario_;
  std::vector<std::string> notes_;
};

}  // namespace

int write_foxglove(const ConvertOptions& options) {
  mcap::Reader log(options.file);
  check_output(options.file, options.out, options.force);
  const auto existing = options.force ? mcap::Existing::kReplace : mcap::Existing::kRefuse;
  mcap::Writer writer(mcap::ClaimedFile(options.out, existing), mcap::Compression::kZstd);
  FoxgloveFile file(log, &writer);
  const int status = read_run(&log, options.rate, &file);
  file.add_attachments();
  writer.close();
  for (const std::string& note : file.notes()) std::fprintf(stderr, "%s\n", note.c_str());
  std::printf("%s: %.1f MB; open it in Foxglove with the layout %s\n", options.out.c_str(),
              static_cast<double>(writer.file_size()) * 1e-6, find_shared_file(file.find_layout()).c_str());
  return status;
}

}  // namespace hrp
