// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/topic_map.h"

#include "common/base/has.h"
#include "common/base/join_words.h"
#include "common/base/suggest.h"
#include "common/robot/yaml_map.h"

namespace hrp {
namespace {

class TopicReader {
 public:
  explicit TopicReader(const std::string& path) : path_(path) {}

  TopicMap read(const YAML::Node& node) {
    TopicMap map;
    if (!node) return map;
    if (!node.IsMap()) fail(node, "topics", "expected signals and their topics, such as 'joint_states: /joint_states'");
    for (const auto& item : node) read_signal(item.first, item.second, &map);
    return map;
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& field, const std::string& text) const {
    refuse_input(make_place(path_, node, field), text);
  }

  void check_signal(const YAML::Node& node, const std::string& signal) const {
    static const std::vector<std::string> whole{"joint_states", "joint_commands", "joint_states_link", "base"};
    if (has(whole, signal)) return;
    for (const char* begin : {"imu/", "wrench/"}) {
      if (signal.rfind(begin, 0) == 0 && signal.size() > std::string(begin).size()) return;
    }
    fail(node, "topics." + signal,
         "is no signal; expected joint_states, joint_commands, joint_states_link, imu/<name>, wrench/<name> or base" +
             suggest(signal, whole));
  }

  // A topic, a mapping, or a list of these.
  void read_signal(const YAML::Node& key, const YAML::Node& value, TopicMap* map) const {
    const std::string signal = key.as<std::string>();
    check_signal(key, signal);
    if (!value.IsSequence()) {
      map->topics.push_back(read_topic(signal, value));
      return;
    }
    for (const YAML::Node& item : value) map->topics.push_back(read_topic(signal, item));
  }

  SignalTopic read_topic(const std::string& signal, const YAML::Node& node) const {
    const std::string field = "topics." + signal;
    SignalTopic spec;
    spec.signal = signal;
    spec.line = node.Mark().line + 1;
    spec.column = node.Mark().column + 1;
    if (node.IsScalar()) {
      spec.topic = node.as<std::string>();
    } else if (node.IsMap()) {
      read_options(node, field, &spec);
    } else {
      fail(node, field, "expected a topic, or {topic: ..., joints: [...], stamps: header or receive}");
    }
    if (spec.topic.empty()) fail(node, field + ".topic", "is missing: the name of the topic");
    if (spec.topic[0] != '/') spec.topic = "/" + spec.topic;
    return spec;
  }

  void read_options(const YAML::Node& node, const std::string& field, SignalTopic* spec) const {
    for (const auto& item : node) {
      const std::string key = item.first.as<std::string>();
      const YAML::Node& value = item.second;
      if (key == "topic" && value.IsScalar()) {
        spec->topic = value.as<std::string>();
      } else if (key == "joints") {
        read_joints(value, field, spec);
      } else if (key == "fields" && value.IsMap()) {
        for (const auto& each : value) spec->fields[each.first.as<std::string>()] = each.second.as<std::string>();
      } else if (key == "quantity") {
        spec->quantity = read_word(value, field + ".quantity", {"position", "velocity", "effort"});
      } else if (key == "stamps") {
        spec->stamps = read_word(value, field + ".stamps", {"header", "receive"}) == "header" ? StampSource::kHeader
                                                                                              : StampSource::kReceive;
      } else {
        fail(item.first, field + "." + key, "unknown key; expected topic, joints, fields, quantity or stamps");
      }
    }
  }

  // Names in order, or a mapping from names in the bag to names in the model.
  void read_joints(const YAML::Node& node, const std::string& field, SignalTopic* spec) const {
    if (node.IsSequence()) {
      for (const YAML::Node& item : node) spec->joints.push_back(item.as<std::string>());
    } else if (node.IsMap()) {
      for (const auto& item : node) spec->rename[item.first.as<std::string>()] = item.second.as<std::string>();
    } else {
      fail(node, field + ".joints",
           "expected names in the order of the message, or {name in the bag: name in the model}");
    }
  }

  std::string read_word(const YAML::Node& node, const std::string& field, const std::vector<std::string>& words) const {
    std::string word = node.IsScalar() ? node.as<std::string>() : "";
    if (has(words, word)) return word;
    fail(node, field, "is '" + word + "', expected one of " + join_words(words));
  }

  std::string path_;
};

}  // namespace

TopicMap parse_topic_map(const std::string& text, const std::string& path) {
  try {
    return TopicReader(path).read(YAML::Load(text)["topics"]);
  } catch (const YAML::Exception& error) {
    refuse_input(make_place(path, error.mark), "not usable YAML: " + error.msg);
  }
}

}  // namespace hrp
