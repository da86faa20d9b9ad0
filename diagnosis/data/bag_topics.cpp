// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/bag_topics.h"

#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/base/join_words.h"
#include "common/base/suggest.h"

namespace hrp::diagnosis {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Chooses topics if the experiment has no section `topics`.
class Guess {
 public:
  Guess(const RosBag& bag, const BagRobot& robot, std::vector<std::string>* notes)
      : bag_(bag), robot_(robot), notes_(notes) {}

  TopicMap find() {
    add("joint_states", "", {"sensor_msgs/msg/JointState"}, false);
    add("joint_commands", "", {"sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory"}, true);
    for (const std::string& imu : robot_.imus) add("imu/" + imu, imu, {"sensor_msgs/msg/Imu"}, false);
    for (const std::string& wrench : robot_.wrenches)
      add("wrench/" + wrench, wrench, {"geometry_msgs/msg/WrenchStamped"}, false);
    if (robot_.floating) add("base", "", {"nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped"}, false);
    return map_;
  }

 private:
  // Adds the topic of a suitable type whose name contains the sensor's name; else the only topic of such a type.
  void add(const std::string& signal, const std::string& word, const std::vector<std::string>& types, bool command) {
    std::vector<std::string> fitting, named;
    for (const BagTopic& t : bag_.topics()) {
      if (!has(types, t.type) || is_command_name(t.name) != command) continue;
      fitting.push_back(t.name);
      if (t.name == "/" + signal || (!word.empty() && contains(t.name, word))) named.push_back(t.name);
    }
    const std::vector<std::string>& found = named.empty() ? fitting : named;
    if (found.size() > 1) {
      notes_->push_back("several topics may be " + signal + ": " + join_words(found) +
                        "; say which under 'topics:' of the experiment");
    }
    if (found.size() != 1) return;
    SignalTopic spec;
    spec.signal = signal;
    spec.topic = found[0];
    map_.topics.push_back(spec);
    notes_->push_back("topic " + found[0] + " was taken as " + signal);
  }

  const RosBag& bag_;
  const BagRobot& robot_;
  std::vector<std::string>* notes_;
  TopicMap map_;
};

class Binder {
 public:
  Binder(const RosBag& bag, const BagRobot& robot, const std::string& experiment)
      : bag_(bag), robot_(robot), experiment_(experiment) {}

  BoundTopic bind(const SignalTopic& spec) const {
    const size_t index = find_topic(spec);
    const BagTopic& topic = bag_.topics()[index];
    BoundTopic bound{spec, index, make_type(spec, topic), false, "", {}, {}};
    bound.by_joint = spec.signal.rfind("joint_", 0) == 0;
    if (bound.by_joint)
      bind_joints(topic, &bound);
    else
      bind_sensor(topic, &bound);
    return bound;
  }

 private:
  size_t find_topic(const SignalTopic& spec) const {
    std::vector<std::string> names;
    for (size_t i = 0; i < bag_.topics().size(); ++i) {
      if (bag_.topics()[i].name == spec.topic) return i;
      names.push_back(bag_.topics()[i].name);
    }
    refuse_input({experiment_, "topics." + spec.signal, spec.line, spec.column},
                 "the bag " + bag_.path() + " has no topic '" + spec.topic + "'; it has " + list_topics(bag_) +
                     suggest(spec.topic, names));
  }

  RosType make_type(const SignalTopic& spec, const BagTopic& topic) const {
    try {
      return RosType(topic.type, topic.encoding, topic.definition);
    } catch (const std::runtime_error& error) {
      refuse_input({bag_.path(), spec.topic},
                   std::string(error.what()) +
                       ": the bag says nothing of its fields (storage sqlite3 before ROS 2 Iron, or ros2idl); "
                       "convert the bag to mcap");
    }
  }

  void add(const BoundTopic& bound, const std::string& column, const std::string& path,
           std::vector<std::string>* columns, std::vector<std::string>* paths) const {
    if (!bound.type.has(path))
      refuse_input({bag_.path(), bound.spec.topic},
                   "type " + bound.type.name() + " has no field '" + path + "', expected for " + column);
    columns->push_back(column);
    paths->push_back(path);
  }

  // Uses the first layout that the message type has.
  void bind_joints(const BagTopic& topic, BoundTopic* bound) const {
    const SignalTopic& spec = bound->spec;
    if (!spec.fields.empty()) return bind_fields(bound);
    for (const char* names : {"name", "joint_names"}) {
      if (bound->type.has(names)) bound->names = names;
    }
    static const std::vector<std::vector<std::string>> layouts{
        {"position", "velocity", "effort"},
        {"points[].positions", "points[].velocities", "points[].effort"},
        {"positions", "velocities", "effort"},
        {"reference.positions", "reference.velocities", "reference.effort"},
        {"desired.positions", "desired.velocities", "desired.effort"}};
    static const char* const quantities[] = {"position", "velocity", "effort"};
    for (const auto& layout : layouts) {
      if (!bound->type.has(layout[0])) continue;
      for (size_t q = 0; q < 3; ++q) add(*bound, quantities[q], layout[q], &bound->columns, &bound->paths);
      return check_names(topic, bound);
    }
    if (!bound->type.has("data"))
      refuse_input({bag_.path(), spec.topic},
                   "type " + topic.type +
                       " holds no joints that the tool knows; expected sensor_msgs/msg/JointState, a trajectory "
                       "or std_msgs/msg/Float64MultiArray, or 'fields: {position: path, ...}' under topics." +
                       spec.signal);
    add(*bound, spec.quantity, "data", &bound->columns, &bound->paths);
    check_names(topic, bound);
  }

  void bind_fields(BoundTopic* bound) const {
    for (const auto& [quantity, path] : bound->spec.fields) {
      if (quantity == "name") {
        bound->names = path;
        continue;
      }
      if (quantity != "position" && quantity != "velocity" && quantity != "effort")
        refuse_input(
            {experiment_, "topics." + bound->spec.signal + ".fields." + quantity, bound->spec.line, bound->spec.column},
            "is no quantity; expected name, position, velocity or effort");
      add(*bound, quantity, path, &bound->columns, &bound->paths);
    }
    check_names(bag_.topics()[bound->index], bound);
  }

  void check_names(const BagTopic& topic, BoundTopic* bound) const {
    if (!bound->spec.joints.empty()) bound->names.clear();  // stated names hold
    if (!bound->names.empty() || !bound->spec.joints.empty()) return;
    refuse_input({experiment_, "topics." + bound->spec.signal + ".joints", bound->spec.line, bound->spec.column},
                 "is missing: messages of " + topic.name + " (" + topic.type +
                     ") have no names of joints; expected them in the order "
                     "of the message, such as {topic: " +
                     topic.name + ", joints: [" + (robot_.joints.empty() ? "" : robot_.joints[0]) + ", ...]}");
  }

  void add_axes(const BoundTopic& bound, const std::string& column, const std::string& path, const char* axes,
                BoundTopic* out) const {
    for (const char* axis = axes; *axis != '\0'; ++axis)
      add(bound, column + "/" + *axis, path + "." + *axis, &out->columns, &out->paths);
  }

  void bind_sensor(const BagTopic& topic, BoundTopic* bound) const {
    const std::string& signal = bound->spec.signal;
    const auto has = [&](const char* path) { return bound->type.has(path); };
    if (signal.rfind("imu/", 0) == 0 && has("angular_velocity.x")) {
      add_axes(*bound, "/" + signal + "/orientation", "orientation", "xyzw", bound);
      add_axes(*bound, "/" + signal + "/angular_velocity", "angular_velocity", "xyz", bound);
      add_axes(*bound, "/" + signal + "/linear_acceleration", "linear_acceleration", "xyz", bound);
    } else if (signal.rfind("wrench/", 0) == 0 && (has("wrench.force.x") || has("force.x"))) {
      const std::string begin = has("wrench.force.x") ? "wrench." : "";
      add_axes(*bound, "/" + signal + "/force", begin + "force", "xyz", bound);
      add_axes(*bound, "/" + signal + "/torque", begin + "torque", "xyz", bound);
    } else if (signal == "base" && (has("pose.position.x") || has("pose.pose.position.x"))) {
      const std::string begin = has("pose.position.x") ? "pose." : "pose.pose.";
      add_axes(*bound, "/base/pose/position", begin + "position", "xyz", bound);
      add_axes(*bound, "/base/pose/orientation", begin + "orientation", "xyzw", bound);
    } else {
      refuse_input({bag_.path(), topic.name},
                   "is of type " + topic.type + ", expected " +
                       (signal == "base"               ? "nav_msgs/msg/Odometry or geometry_msgs/msg/PoseStamped"
                        : signal.rfind("imu/", 0) == 0 ? "sensor_msgs/msg/Imu"
                                                       : "geometry_msgs/msg/WrenchStamped") +
                       " for topics." + signal);
    }
  }

  const RosBag& bag_;
  const BagRobot& robot_;
  const std::string experiment_;
};

}  // namespace

std::string list_topics(const RosBag& bag) {
  const std::string list = join_words(bag.topics(), [](const BagTopic& t) { return t.name + " (" + t.type + ")"; });
  return list.empty() ? "no topic" : list;
}

bool is_command_name(const std::string& name) {
  for (const char* word : {"command", "cmd", "desired", "target", "setpoint", "goal", "reference"}) {
    if (contains(name, word)) return true;
  }
  return false;
}

std::vector<BoundTopic> bind_topics(const RosBag& bag, const TopicMap& map, const BagRobot& robot,
                                    const std::string& experiment, std::vector<std::string>* notes) {
  const TopicMap topics = map.topics.empty() ? Guess(bag, robot, notes).find() : map;
  if (topics.topics.empty())
    refuse_input({bag.path(), "topics"},
                 "no topic was recognised; name them under 'topics:' of the experiment, such as "
                 "'joint_states: /joint_states'; the bag has " +
                     list_topics(bag));
  std::vector<BoundTopic> bound;
  const Binder binder(bag, robot, experiment);
  for (const SignalTopic& spec : topics.topics) bound.push_back(binder.bind(spec));
  return bound;
}

}  // namespace hrp::diagnosis
