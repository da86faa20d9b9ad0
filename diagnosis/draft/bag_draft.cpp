// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/bag_draft.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <optional>
#include <set>

#include "common/base/join_words.h"
#include "common/base/printable.h"
#include "common/log/ros_bag.h"
#include "common/log/ros_types.h"
#include "diagnosis/data/bag_topics.h"
#include "diagnosis/draft/quote.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kJointState = "sensor_msgs/msg/JointState";
constexpr const char* kTrajectory = "trajectory_msgs/msg/JointTrajectory";
constexpr const char* kNumbers = "std_msgs/msg/Float64MultiArray";
constexpr const char* kImu = "sensor_msgs/msg/Imu";
constexpr const char* kWrench = "geometry_msgs/msg/WrenchStamped";

// What the messages of one topic say.
struct TopicContent {
  const BagTopic* topic = nullptr;
  std::optional<RosType> type;
  size_t count = 0;
  int64_t first = 0, last = 0;                                  // [ns] received
  std::string frame;                                            // of the last message
  std::vector<std::string> joints;                              // of the first message
  bool positions = false, velocities = false, efforts = false;  // for all joints
  size_t known = 0;                                             // of the joints: those of the model

  double rate() const {
    return last > first ? static_cast<double>(count - 1) * 1e9 / static_cast<double>(last - first) : 0.0;
  }
};

class BagDrafter {
 public:
  BagDrafter(const std::string& path, const TreeSpec& robot) : bag_(path), robot_(robot) {}

  BagDraft draft() {
    read();
    out_.text = "topics:             # docs/rosbag.md\n";
    write_states();
    write_commands();
    write_sensors(kImu, "imu");
    write_sensors(kWrench, "wrench");
    if (!sensors_.empty()) out_.text += "sensors:            # (?) the links that carry them\n" + sensors_;
    return out_;
  }

 private:
  void read() {
    std::set<std::string> wanted;
    for (const BagTopic& topic : bag_.topics()) {
      TopicContent content;
      content.topic = &topic;
      for (const char* type : {kJointState, kTrajectory, kImu, kWrench}) {
        if (topic.type == type) content.type.emplace(topic.type, topic.encoding, topic.definition);
      }
      if (content.type) wanted.insert(topic.name);
      contents_.push_back(std::move(content));
    }
    RosValues values({"header.frame_id", "name", "joint_names", "position", "velocity", "effort"});
    const auto visit = [&](const BagMessage& message) {
      TopicContent& content = contents_[message.topic];
      if (content.count++ == 0) content.first = message.received;
      content.last = message.received;
      if (content.count > 1 && content.topic->type != kJointState) return;
      values.read(*content.type, message.data);
      take(values, &content);
    };
    if (!wanted.empty()) bag_.read(wanted, visit);
  }

  void take(const RosValues& values, TopicContent* content) const {
    if (!values.texts("header.frame_id").empty()) content->frame = values.texts("header.frame_id")[0];
    const std::vector<std::string>& names = values.texts(content->topic->type == kTrajectory ? "joint_names" : "name");
    if (content->joints.empty()) {
      content->joints = names;
      for (const std::string& name : names) content->known += robot_.find_joint(name) >= 0 ? 1 : 0;
    }
    const auto has = [&](const char* quantity) {
      return !names.empty() && values.numbers(quantity).size() == names.size();
    };
    content->positions |= has("position");
    content->velocities |= has("velocity");
    content->efforts |= has("effort");
  }

  // The topic of this kind with most joints of the model; nullptr: none.
  const TopicContent* find_best(const std::vector<std::string>& types, bool command) const {
    const TopicContent* best = nullptr;
    for (const TopicContent& content : contents_) {
      const bool fits = std::find(types.begin(), types.end(), content.topic->type) != types.end();
      if (fits && is_command_name(content.topic->name) == command && (best == nullptr || content.known > best->known))
        best = &content;
    }
    return best;
  }

  void write_states() {
    const TopicContent* states = find_best({kJointState}, false);
    if (states == nullptr) {
      out_.asked.push_back("which topic has the joints' states: the bag has " + list_topics(bag_));
      return;
    }
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.3g Hz", states->rate());
    out_.text += "  joint_states: " + quote_name(states->topic->name) + "   # " + rate + "\n";
    out_.efforts = states->efforts;
    const std::string of = std::to_string(states->known) + " of " + std::to_string(robot_.num_joints()) + " joints";
    out_.found.push_back("topic " + states->topic->name + ": " + of + "; positions: " + say(states->positions) +
                         ", velocities: " + say(states->velocities) + ", efforts: " + say(states->efforts));
    if (states->known == 0)
      out_.asked.push_back("which joint of the bag (" + join_words(states->joints) +
                           ") is which of the model: joint_states: {topic: " + states->topic->name +
                           ", joints: {NAME IN THE BAG: NAME IN THE MODEL}}");
  }
  static const char* say(bool there) { return there ? "yes" : "no"; }

  void write_commands() {
    const TopicContent* commands = find_best({kJointState, kTrajectory, kNumbers}, true);
    if (commands == nullptr) return;
    out_.commands = true;
    const std::string& name = commands->topic->name;
    if (commands->topic->type != kNumbers) {
      out_.text += "  joint_commands: " + quote_name(name) + "\n";
      out_.found.push_back("topic " + name + ": commands");
      return;
    }
    out_.text += "  joint_commands: {topic: " + quote_name(name) + ", quantity: position, joints: [";
    for (int i = 0; i < robot_.num_joints(); ++i) out_.text += (i > 0 ? ", " : "") + quote_name(robot_.joint(i).name);
    out_.text += "]}   # (?)\n";
    out_.asked.push_back("which joints, in which order, the numbers of " + name +
                         " are, and whether they are positions, velocities or efforts");
  }

  // One for each topic of the type, on the link that its messages name.
  void write_sensors(const char* type, const std::string& kind) {
    std::string text;
    std::set<std::string> names;
    for (const TopicContent& content : contents_) {
      if (content.topic->type != type) continue;
      std::string name = make_name(content.topic->name);
      // "/imu/data" and "/imu_data" are two sensors.
      for (int i = 2; !names.insert(name).second; ++i) name = make_name(content.topic->name) + "_" + std::to_string(i);
      const bool known = robot_.find_link(content.frame) >= 0 || robot_.find_frame(content.frame) >= 0;
      out_.text += "  " + kind + "/" + name + ": " + quote_name(content.topic->name) + "\n";
      text += "    " + name + ": {link: " +
              (known ? quote_name(content.frame)
                     : quote_name(robot_.links[0].name) + "}   # (?) the messages say '" +
                           make_printable_line(content.frame) + "'");
      text += known ? "}\n" : "\n";
      out_.found.push_back("topic " + content.topic->name + ": sensor '" + name + "'");
      if (!known)
        out_.asked.push_back("the link of the sensor '" + name + "': the model has no '" + content.frame + "'");
    }
    if (!text.empty() && kind == "imu") out_.imu = true;
    if (!text.empty()) sensors_ += "  " + kind + ":\n" + text;
  }

  // "/imu/data" -> "imu_data"
  static std::string make_name(const std::string& topic) {
    std::string name;
    for (const char c : topic) {
      if (std::isalnum(static_cast<unsigned char>(c)))
        name += c;
      else if (!name.empty())
        name += '_';
    }
    return name;
  }

  const RosBag bag_;
  const TreeSpec& robot_;
  std::vector<TopicContent> contents_;
  std::string sensors_;
  BagDraft out_;
};

}  // namespace

BagDraft draft_bag(const std::string& path, const TreeSpec& robot) { return BagDrafter(path, robot).draft(); }

}  // namespace hrp::diagnosis
