// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/column_map.h"

#include <cmath>
#include <set>

#include "common/base/suggest.h"
#include "common/robot/yaml_map.h"

namespace hrp {
namespace {

// "q_*" for joint "hip" is "q_hip". A header may have stars itself: without a joint they stay.
std::string put_joint(const std::string& text, const std::string& joint) {
  const size_t star = text.find('*');
  return joint.empty() || star == std::string::npos ? text : text.substr(0, star) + joint + text.substr(star + 1);
}

class ColumnReader {
 public:
  explicit ColumnReader(const std::string& path) : path_(path) {}

  // Adds the columns of one section.
  void read(const YAML::Node& node) {
    if (!node) return;
    if (!node.IsMap())
      fail(node, "columns",
           "expected signals and their columns, such as 'time: 1' or '/joint_states/hip/position: q_hip'");
    seen_.clear();
    if (node["joints"]) read_joints(node["joints"]);
    for (const auto& item : node) {
      if (item.first.as<std::string>() != "joints") read_signal(item.first, item.second);
    }
  }

  const std::vector<SignalColumn>& columns() const { return map_; }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& field, const std::string& text) const {
    refuse_input(make_place(path_, node, field), text);
  }

  void read_joints(const YAML::Node& node) {
    if (!node.IsSequence())
      fail(node, "columns.joints", "expected a list of joints: * stands for each of them in turn");
    joints_.clear();
    for (const YAML::Node& item : node) joints_.push_back(item.as<std::string>());
  }

  void check_signal(const YAML::Node& node, const std::string& signal) const {
    static const std::vector<std::string> known{"time", "/joint_states/*/position", "/joint_commands/*/position",
                                                "joints"};
    if (signal == "time" || signal.rfind('/', 0) == 0) return;
    fail(node, "columns." + signal,
         "is no signal; expected joints, time, or one as in /joint_states/hip/position" + suggest(signal, known));
  }

  // A column, {column: ..., scale: ..., offset: ...}; with * in the signal's name, one for each of `joints`.
  void read_signal(const YAML::Node& key, const YAML::Node& value) {
    const std::string signal = key.as<std::string>(), field = "columns." + signal;
    check_signal(key, signal);
    const bool each = signal.find('*') != std::string::npos;
    if (each && joints_.empty())
      fail(key, field, "has a *: expected 'joints', the list of joints that it stands for, under 'columns'");
    if (value.IsMap()) check_keys(value, field);
    const YAML::Node column = value.IsMap() ? value["column"] : value;
    if (!column) fail(value, field, "expected 'column': its number, from 1, or its name in the header");
    const std::vector<std::string> joints = each ? joints_ : std::vector<std::string>{""};
    for (size_t i = 0; i < joints.size(); ++i) {
      SignalColumn entry;
      entry.signal = put_joint(signal, joints[i]);
      read_place(pick(column, field + ".column", i, joints.size()), field, joints[i], &entry);
      if (value.IsMap() && value["scale"])
        entry.scale = read_number(pick(value["scale"], field + ".scale", i, joints.size()), field + ".scale");
      if (value.IsMap() && value["offset"])
        entry.offset = read_number(pick(value["offset"], field + ".offset", i, joints.size()), field + ".offset");
      if (!seen_.insert(entry.signal).second) fail(key, field, "'" + entry.signal + "' has a column already");
      add(entry);
    }
  }

  // In the place of one of an earlier section.
  void add(const SignalColumn& entry) {
    for (SignalColumn& other : map_) {
      if (other.signal != entry.signal) continue;
      other = entry;
      return;
    }
    map_.push_back(entry);
  }

  void check_keys(const YAML::Node& node, const std::string& field) const {
    for (const auto& item : node) {
      const std::string key = item.first.as<std::string>();
      if (key != "column" && key != "scale" && key != "offset")
        fail(item.first, field + "." + key, "unknown key; expected column, scale or offset");
    }
  }

  // The value for one of `count` joints: an item of a list, or the same for all.
  YAML::Node pick(const YAML::Node& node, const std::string& field, size_t i, size_t count) const {
    if (!node.IsSequence()) return node;
    if (node.size() != count)
      fail(
          node, field,
          "has " + std::to_string(node.size()) + " items; expected " +
              (count == 1 ? "one value, or a * in the signal's name" : std::to_string(count) + ", one for each joint"));
    return node[i];
  }

  void read_place(const YAML::Node& node, const std::string& field, const std::string& joint,
                  SignalColumn* entry) const {
    if (!node.IsScalar()) fail(node, field, "expected a column: its number, from 1, or its name in the header");
    const std::string text = node.as<std::string>();
    if (node.Tag() != "!" && YAML::convert<int>::decode(node, entry->number)) {  // quoted digits are a name
      if (entry->number < 1) fail(node, field, "is column " + text + "; expected a number from 1, or a name");
    } else {
      entry->name = put_joint(text, joint);
    }
  }

  double read_number(const YAML::Node& node, const std::string& field) const {
    double value = 0.0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !(std::abs(value) <= kLargestNumber))
      fail(node, field, "expected a number");
    return value;
  }

  std::string path_;
  std::vector<std::string> joints_;
  std::set<std::string> seen_;
  std::vector<SignalColumn> map_;
};

}  // namespace

std::vector<ColumnMap> parse_column_maps(const std::string& text, const std::string& path) {
  try {
    const YAML::Node root = YAML::Load(text), rate = root["sample_rate"];
    ColumnReader shared(path);
    shared.read(root["columns"]);
    std::vector<ColumnMap> maps;
    for (const YAML::Node& recording : root["recordings"]) {
      ColumnReader own = shared;
      own.read(recording["columns"]);
      // parse_experiment_keys() refuses what is no rate.
      maps.push_back({own.columns(), rate ? rate.as<double>() : 0.0});
    }
    return maps;
  } catch (const YAML::Exception& error) {
    refuse_input(make_place(path, error.mark), "not usable YAML: " + error.msg);
  }
}

}  // namespace hrp
