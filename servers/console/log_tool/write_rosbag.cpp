// SPDX-License-Identifier: BSD-3-Clause
// A log as a bag of ROS 2: a folder with metadata.yaml and one MCAP file.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "servers/console/log_tool/commands.h"
#include "servers/console/log_tool/log_file.h"
#include "servers/console/log_tool/ros_topics.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

constexpr size_t kChunkSize = size_t{1} << 20;

// Ends chunks, and remembers the times of the bag.
class BagFileListener final : public RunListener {
 public:
  explicit BagFileListener(mcap::Writer* writer) : writer_(*writer), ros_(writer, RosTopics::Frames::kTf) {}
  void on_robot(const RobotDescription& robot, const Scenario& scenario, const LogPlace& place) override {
    begin_ = place.log_time;
    ros_.on_robot(robot, scenario, place);
    take(place);
  }
  void on_step(const RunStep& step, const LogPlace& place) override {
    ros_.on_step(step, place);
    take(place);
  }
  void on_sensors(size_t robot, const msg::SensorData& sensors, const LogPlace& place) override {
    ros_.on_sensors(robot, sensors, place);
    take(place);
  }
  void on_commands(size_t robot, const msg::JointCommands& commands, const LogPlace& place) override {
    ros_.on_commands(robot, commands, place);
    take(place);
  }
  void on_picture(const std::string& topic, const std::string& type, Bytes sample, const LogPlace& place) override {
    ros_.on_picture(topic, type, sample, place);
    take(place);
  }
  const std::vector<RosTopic>& topics() const { return ros_.topics(); }
  uint64_t begin() const { return begin_; }
  uint64_t duration() const { return end_ - begin_; }

 private:
  void take(const LogPlace& place) {
    begin_ = std::min(begin_, place.log_time);
    end_ = std::max(end_, place.log_time);
    if (writer_.open_chunk_size() > kChunkSize) writer_.write_chunk();
  }
  mcap::Writer& writer_;
  RosTopics ros_;
  uint64_t begin_ = 0, end_ = 0;  // [ns]
};

// A text of several lines as one of YAML, in double quotes.
std::string quote(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '\n' ? "\\n" : std::string(1, c);
  return out + "\"";
}

// Version 5, Humble's, which all later distributions read.
std::string make_metadata(const BagFileListener& bag, const std::string& file) {
  std::ostringstream topics;
  uint64_t count = 0;
  for (const RosTopic& topic : bag.topics()) {
    count += topic.count;
    topics << "    - topic_metadata:\n        name: " << topic.name << "\n        type: " << topic.type
           << "\n        serialization_format: cdr\n        offered_qos_profiles: "
           << quote(make_qos_text(topic.latched)) << "\n      message_count: " << topic.count << "\n";
  }
  std::ostringstream span, yaml;
  yaml << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    nanoseconds: "
       << bag.duration() << "\n  starting_time:\n    nanoseconds_since_epoch: " << bag.begin()
       << "\n  message_count: " << count << "\n  topics_with_message_count:\n"
       << topics.str() << "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - " << file
       << "\n  files:\n    - path: " << file
       << "\n      starting_time:\n        nanoseconds_since_epoch: " << bag.begin()
       << "\n      duration:\n        nanoseconds: " << bag.duration() << "\n      message_count: " << count << "\n";
  return yaml.str();
}

}  // namespace

int write_rosbag(const ConvertOptions& options) {
  mcap::Reader log(options.file);
  const fs::path folder = fs::path(options.out).lexically_normal();
  const std::string name =
      (folder.has_filename() ? folder.filename() : folder.parent_path().filename()).string() + "_0.mcap";
  const std::string path = (folder / name).string();
  fs::create_directories(folder);
  check_output(options.file, path, options.force);
  const auto existing = options.force ? mcap::Existing::kReplace : mcap::Existing::kRefuse;
  mcap::Writer writer(mcap::ClaimedFile(path, existing), mcap::Compression::kZstd, "ros2");
  BagFileListener bag(&writer);
  const int status = read_run(&log, options.rate, &bag);
  writer.close();
  std::ofstream metadata(folder / "metadata.yaml", std::ios::binary);
  metadata << make_metadata(bag, name);
  metadata.close();
  if (!metadata) throw std::runtime_error((folder / "metadata.yaml").string() + ": cannot be written");
  std::printf("%s: %zu topics, %.1f MB; ros2 bag play %s --clock\n", options.out.c_str(), bag.topics().size(),
              static_cast<double>(writer.file_size()) * 1e-6, options.out.c_str());
  return status;
}

}  // namespace hrp
