// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/limits.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "common/base/diagnostics.h"
#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

// [rad or m] Largest distance from the start pose, if none is stated. Within the description's limits, motions are as
// large as they can be: intervals of dry friction hold what the unseen part of a turn may have. Beyond half a turn
// either way, nothing is unseen.
constexpr double kReach = M_PI;
// Factor on the largest effort of the recordings if nothing states a limit: the next step
constexpr double kGrow = 2.0;
constexpr double kUnknownSpeed = 2.0;  // [rad/s] if no speed is stated: that of a slow industrial arm

const JointColumns* find_columns(const Experiment& e, size_t joint) {
  for (const Recording& r : e.recordings) {
    if (!r.joints[joint].command.empty()) return &r.joints[joint];
  }
  return nullptr;
}

// Start of a motion: the stated pose, else the first command, else the first position.
double find_start(const Experiment& e, size_t joint) {
  const auto stated = e.scenario.initial_joints.find(e.robot.tree.joint(static_cast<int>(joint)).name);
  if (stated != e.scenario.initial_joints.end()) return stated->second;
  if (const JointColumns* columns = find_columns(e, joint)) return columns->command.front();
  for (double q : e.recordings[0].joints[joint].signal[0]) {
    if (std::isfinite(q)) return q;
  }
  return 0.0;
}

// Range of the recorded commands, or of positions without commands, for joints without limits.
void take_seen_range(const Experiment& e, size_t joint, JointLimits* limits) {
  limits->lower = limits->upper = limits->start;
  for (const Recording& r : e.recordings) {
    const JointColumns& columns = r.joints[joint];
    for (double q : columns.command.empty() ? columns.signal[0] : columns.command) {
      if (std::isfinite(q)) {
        limits->lower = std::min(limits->lower, q);
        limits->upper = std::max(limits->upper, q);
      }
    }
  }
}

// Largest effort of the servo's stiffness, for logs without efforts.
double find_servo_effort(const Experiment& e, size_t joint) {
  const ServoGains& gains = get_servo_gains(e.scenario, e.robot.tree.joint(static_cast<int>(joint)).name);
  double most = 0.0;
  for (const Recording& r : e.recordings) {
    const JointColumns& c = r.joints[joint];
    for (size_t k = 0; k < std::min(c.command.size(), c.signal[0].size()); ++k) {
      if (std::isfinite(c.signal[0][k])) most = std::max(most, gains.kp * std::abs(c.command[k] - c.signal[0][k]));
    }
  }
  return std::min(most, gains.effort_limit);
}

double find_seen_effort(const Experiment& e, size_t joint) {
  const bool recorded = std::any_of(e.recordings.begin(), e.recordings.end(),
                                    [&](const Recording& r) { return r.joints[joint].has(Quantity::kEffort); });
  if (!recorded) return e.scenario.drive == "servo" ? find_servo_effort(e, joint) : 0.0;
  double most = 0.0;
  for (const Recording& r : e.recordings) {
    for (double effort : r.joints[joint].signal[static_cast<size_t>(Quantity::kEffort)]) {
      if (std::isfinite(effort)) most = std::max(most, std::abs(effort));
    }
  }
  return most;
}

double find_effort(const Experiment& e, const JointSpec& joint) {
  return kUsedShare * std::min(joint.effort_limit, get_servo_gains(e.scenario, joint.name).effort_limit);
}

// Without a stated limit: a step beyond what the drive has given.
double find_unstated_effort(const Experiment& e, size_t j, std::vector<std::string>* remarks) {
  const std::string& name = e.robot.tree.joint(static_cast<int>(j)).name;
  const double seen = kGrow * find_seen_effort(e, j);
  if (seen > 0.0) {
    remarks->push_back(name + " has no effort limit: twice the largest recorded effort is taken, " + number(seen, 3));
    return seen;
  }
  remarks->push_back(name + " has no effort limit: efforts are not checked");
  return std::numeric_limits<double>::infinity();
}

JointLimits make_joint_limits(const Experiment& e, size_t j, std::vector<std::string>* remarks) {
  const JointSpec& joint = e.robot.tree.joint(static_cast<int>(j));
  JointLimits limits;
  limits.mimic = joint.mimic;
  limits.start =
      joint.mimic.joint < 0
          ? find_start(e, j)
          : joint.mimic.multiplier * find_start(e, static_cast<size_t>(joint.mimic.joint)) + joint.mimic.offset;
  if (std::isfinite(joint.lower) && std::isfinite(joint.upper)) {
    const double margin = kMinor * (joint.upper - joint.lower);
    limits.widest_lower = joint.lower + margin;
    limits.widest_upper = joint.upper - margin;
    limits.lower = std::max(limits.widest_lower, limits.start - kReach);
    limits.upper = std::min(limits.widest_upper, limits.start + kReach);
    limits.hard_lower = joint.lower;
    limits.hard_upper = joint.upper;
  } else {
    take_seen_range(e, j, &limits);
    limits.widest_lower = limits.lower;
    limits.widest_upper = limits.upper;
    limits.hard_lower = limits.lower - kHardlyMoved;
    limits.hard_upper = limits.upper + kHardlyMoved;
    remarks->push_back(joint.name +
                       " has no position limits in its URDF: motions stay within what the recordings show, " +
                       number(limits.lower, 3) + " to " + number(limits.upper, 3));
  }
  limits.lower = std::min(limits.lower, limits.start);
  limits.upper = std::max(limits.upper, limits.start);
  limits.speed = kUsedShare * joint.velocity_limit;
  if (!std::isfinite(limits.speed) || limits.speed <= 0.0) {
    limits.speed = kUnknownSpeed;
    remarks->push_back(joint.name + " has no speed limit in its URDF: " + number(kUnknownSpeed, 3) + " " +
                       get_joint_unit(joint, "rad/s") + " is taken");
  }
  limits.effort = find_effort(e, joint);
  if (!std::isfinite(limits.effort)) limits.effort = find_unstated_effort(e, j, remarks);
  return limits;
}

// A joint that others follow goes no further and no faster than their limits allow. A range that only recordings show
// counts not here: a follower may be in none.
void bind_leaders(const Experiment& e, Limits* limits) {
  for (size_t j = 0; j < limits->joints.size(); ++j) {
    const JointLimits& own = limits->joints[j];
    if (own.mimic.joint < 0 || own.mimic.multiplier == 0.0) continue;
    JointLimits& leader = limits->joints[static_cast<size_t>(own.mimic.joint)];
    leader.speed = std::min(leader.speed, own.speed / std::abs(own.mimic.multiplier));
    const JointSpec& joint = e.robot.tree.joint(static_cast<int>(j));
    if (!std::isfinite(joint.lower) || !std::isfinite(joint.upper)) continue;
    const double a = (own.lower - own.mimic.offset) / own.mimic.multiplier;
    const double b = (own.upper - own.mimic.offset) / own.mimic.multiplier;
    leader.lower = std::min(std::max(leader.lower, std::min(a, b)), leader.start);
    leader.upper = std::max(std::min(leader.upper, std::max(a, b)), leader.start);
  }
}

[[noreturn]] void fail(const std::string& field, const std::string& message) {
  refuse_input({"", "--limit " + field}, message);
}

[[noreturn]] void refuse(const std::string& what) {
  fail(what,
       "expected speed, effort, reach, lower, upper, ground or load = a number, such as speed=0.5, elbow.speed=0.3, or "
       "a YAML file");
}

void tighten(const std::string& what, const std::string& key, double value, JointLimits* joint) {
  const double before_lower = joint->lower, before_upper = joint->upper;
  if (key == "speed" && value > 0.0) {
    joint->speed = std::min(joint->speed, value);
  } else if (key == "effort" && value > 0.0) {
    joint->effort = std::min(joint->effort, value);
  } else if (key == "reach" && value >= 0.0) {
    joint->lower = std::max(joint->widest_lower, joint->start - value);
    joint->upper = std::min(joint->widest_upper, joint->start + value);
  } else if (key == "lower") {
    joint->lower = std::max(joint->lower, value);
  } else if (key == "upper") {
    joint->upper = std::min(joint->upper, value);
  } else {
    refuse(what);
  }
  // Commands keep a distance from the limits that a joint needs to follow them.
  if (joint->lower > before_lower) {
    joint->hard_lower = joint->lower;
    joint->lower += kMinor * (joint->upper - joint->lower);
  }
  if (joint->upper < before_upper) {
    joint->hard_upper = joint->upper;
    joint->upper -= kMinor * (joint->upper - joint->lower);
  }
  // What is stated later, for all joints, widens none of these.
  if (joint->lower > before_lower) joint->widest_lower = joint->lower;
  if (joint->upper < before_upper) joint->widest_upper = joint->upper;
  joint->lower = std::min(joint->lower, std::max(joint->start, joint->hard_lower));
  joint->upper = std::max(joint->upper, std::min(joint->start, joint->hard_upper));
}

void apply(const Experiment& e, const std::string& what, const std::string& joint, const std::string& key, double value,
           Limits* limits) {
  if (!std::isfinite(value)) refuse(what);
  if (key == "ground" && joint.empty()) {
    limits->ground = std::max(limits->ground, value);
    return;
  }
  if (key == "load" && joint.empty() && value >= 0.0) {
    limits->load = std::min(limits->load, value);
    return;
  }
  const int index = joint.empty() ? -1 : e.robot.tree.find_joint(joint);
  if (!joint.empty() && index < 0) fail(what, "the robot has no joint " + joint);
  for (size_t j = 0; j < limits->joints.size(); ++j) {
    if (index < 0 || static_cast<size_t>(index) == j) tighten(what, key, value, &limits->joints[j]);
  }
}

void apply_file(const Experiment& e, const std::string& path, Limits* limits) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
    if (!root.IsMap()) fail(path, "expected lines KEY: NUMBER");
    const auto take = [&](const std::string& joint, const YAML::Node& name, const YAML::Node& value) {
      const std::string key = name.as<std::string>();
      apply(e, path + ":" + std::to_string(name.Mark().line + 1) + ": " + key, joint, key, value.as<double>(), limits);
    };
    for (const auto& item : root) {
      if (item.first.as<std::string>() != "joints") {
        take("", item.first, item.second);
        continue;
      }
      for (const auto& joint : item.second) {
        for (const auto& one : joint.second) take(joint.first.as<std::string>(), one.first, one.second);
      }
    }
  } catch (const YAML::Exception& error) {
    fail(path + ":" + std::to_string(error.mark.line + 1), error.msg);
  }
}

void apply_word(const Experiment& e, const std::string& word, Limits* limits) {
  const size_t equals = word.find('=');
  if (equals == std::string::npos) refuse(word);
  const std::string name = word.substr(0, equals);
  const size_t dot = name.rfind('.');
  const std::string text = word.substr(equals + 1);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0') refuse(word);
  const std::string joint = dot == std::string::npos ? "" : name.substr(0, dot);
  apply(e, word, joint, dot == std::string::npos ? name : name.substr(dot + 1), value, limits);
}

bool is_file(const std::string& word) {
  return word.size() > 5 && (word.substr(word.size() - 5) == ".yaml" || word.substr(word.size() - 4) == ".yml");
}

}  // namespace

double calc_travel(const Experiment& experiment, int joint) {
  JointLimits seen;
  seen.start = find_start(experiment, static_cast<size_t>(joint));
  take_seen_range(experiment, static_cast<size_t>(joint), &seen);
  return seen.upper - seen.lower;
}

Limits make_limits(const Experiment& experiment, const std::vector<std::string>& stated) {
  Limits limits;
  for (int j = 0; j < experiment.num_joints(); ++j)
    limits.joints.push_back(make_joint_limits(experiment, static_cast<size_t>(j), &limits.remarks));
  for (const std::string& word : stated) {
    is_file(word) ? apply_file(experiment, word, &limits) : apply_word(experiment, word, &limits);
  }
  bind_leaders(experiment, &limits);
  for (size_t j = 0; j < limits.joints.size(); ++j) {
    const JointLimits& joint = limits.joints[j];
    if (joint.hard_lower > joint.start || joint.hard_upper < joint.start)
      fail(experiment.robot.tree.joint(static_cast<int>(j)).name, "motions start at " + number(joint.start, 4) +
                                                                      ", outside of " + number(joint.hard_lower, 4) +
                                                                      " to " + number(joint.hard_upper, 4));
  }
  return limits;
}

}  // namespace hrp::diagnosis
