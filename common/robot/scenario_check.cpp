// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/scenario_check.h"

#include <algorithm>
#include <cmath>

#include "common/base/ends_with.h"
#include "common/base/format.h"
#include "common/base/has.h"
#include "common/base/suggest.h"
#include "common/robot/foot_bush.h"

namespace hrp {
namespace {

// Of the joints that foot_bush.cpp makes.
constexpr const char* kBushEndings[] = {"_bush_z", "_bush_roll", "_bush_pitch"};

class Checker {
 public:
  Checker(const Scenario& scenario, const TreeSpec& tree, Diagnostics* diagnostics)
      : scenario_(scenario), diagnostics_(diagnostics) {
    for (const FrameSpec& frame : tree.frames) links_.push_back(frame.name);
    for (int i = 0; i < tree.num_joints(); ++i) joints_.push_back(tree.joint(i).name);
  }
  // The joints that insert_foot_bush makes later.
  void add_bush_joints() {
    if (scenario_.contact.model == "wrench") return;
    for (const auto& bush : scenario_.foot_bush) {
      for (const char* suffix : kBushEndings) joints_.push_back(bush.first + suffix);
    }
  }
  void check_link(const std::string& key, const std::string& name) { check(key, name, links_, "link"); }
  // A link, an object, or a link of another robot.
  void check_body(const std::string& key, const std::string& name, const RobotDescription& robot) {
    std::vector<std::string> bodies = links_;
    for (const ObjectSpec& object : scenario_.objects) bodies.push_back(object.name);
    for (const OtherRobot& other : robot.robots) {
      for (const FrameSpec& frame : other.description.tree.frames) bodies.push_back(other.name + "/" + frame.name);
    }
    check(key, name, bodies,
          scenario_.objects.empty() && robot.robots.empty() ? "link" : "link, and the scenario no object,");
  }
  void check_joint(const std::string& key, const std::string& name) { check(key, name, joints_, "joint that moves"); }
  // One that may be fixed to the world, and has a frame of its own.
  void check_sensor(const std::string& key, const std::string& link, const std::string& frame) {
    if (!link.empty()) check_link(key + ".link", link);
    if (!has(links_, frame)) return;
    diagnostics_->add_error(
        scenario_.make_diagnostic(key, "its frame would be '" + frame + "', which is a link of the robot"));
  }
  // Names of whatever may touch: "all" stands for everything.
  void check_no_contact() {
    std::vector<std::string> bodies = links_;
    bodies.insert(bodies.end(), {"ground", "all"});
    for (const ObstacleSpec& obstacle : scenario_.obstacles) bodies.push_back(obstacle.name);
    for (const ObjectSpec& object : scenario_.objects) bodies.push_back(object.name);
    for (const RobotPlacement& robot : scenario_.robots) bodies.push_back(robot.name);
    for (const ObjectSpec& object : scenario_.objects) check_unique("objects." + object.name, object.name, bodies);
    for (const RobotPlacement& robot : scenario_.robots) check_unique("robots." + robot.name, robot.name, bodies);
    for (const auto& [name, others] : scenario_.no_contact) {
      const std::string key = "no_contact." + name;
      check(key, name, bodies, "link, and the scenario no obstacle");
      for (size_t i = 0; i < others.size(); ++i) {
        check(key + "[" + std::to_string(i) + "]", others[i], bodies, "link, and the scenario no obstacle");
      }
    }
  }
  template <typename Map>
  void check_joint_keys(const std::string& key, const Map& map) {
    for (const auto& item : map) check_joint(key + "." + item.first, item.first);
  }
  template <typename Map>
  void check_link_keys(const std::string& key, const Map& map) {
    for (const auto& item : map) check_link(key + "." + item.first, item.first);
  }

 private:
  void check_unique(const std::string& key, const std::string& name, const std::vector<std::string>& bodies) {
    if (std::count(bodies.begin(), bodies.end(), name) == 1) return;
    diagnostics_->add_error(
        scenario_.make_diagnostic(key, "a link, an obstacle, an object or the ground has this name, too"));
  }
  void check(const std::string& key, const std::string& name, const std::vector<std::string>& names,
             const std::string& kind) {
    if (has(names, name)) return;
    diagnostics_->add_error(
        scenario_.make_diagnostic(key, "the robot has no " + kind + " '" + name + "'" + suggest(name, names)));
  }

  const Scenario& scenario_;
  Diagnostics* diagnostics_;
  std::vector<std::string> links_, joints_;
};

void check_feet_have_soles(const Scenario& scenario, const RobotDescription& robot, Diagnostics* diagnostics) {
  for (size_t i = 0; i < scenario.feet.size(); ++i) {
    const int frame = robot.tree.find_frame(scenario.feet[i]);
    if (frame < 0) continue;
    const int link = robot.tree.frames[static_cast<size_t>(frame)].link;
    const bool has_sole = std::any_of(robot.shapes.begin(), robot.shapes.end(),
                                      [&](const CollisionShape& shape) { return shape.sole && shape.link == link; });
    if (has_sole) continue;
    const Diagnostic d = scenario.make_diagnostic(
        "feet[" + std::to_string(i) + "]",
        "link '" + scenario.feet[i] + "' has no collision geometry to stand on; give one in 'soles'");
    if (robot.tree.floating_base && scenario.drive != "motion") {
      diagnostics->add_error(d);
    } else {
      diagnostics->add_warning(d);
    }
  }
}

// Whatever falls, falls until one of its shapes touches the ground.
void check_feet_are_named(const Scenario& scenario, const RobotDescription& robot, Diagnostics* diagnostics) {
  const bool floats = robot.tree.floating_base && scenario.floating_base && scenario.ground.present;
  if (!floats || !scenario.feet.empty() || scenario.drive == "motion") return;
  diagnostics->add_warning(scenario.make_diagnostic(
      "feet",
      "is missing: nothing is known to stand on, so the robot falls on whatever shape of it touches the ground first; "
      "expected the links that it stands on, or 'ground: {type: none}'"));
}

// More than this beyond a limit is no rounding, and no pose that was ever seen on the robot.
constexpr double kFarBeyond = 1.0;   // [rad or m]
constexpr double kTurns = 4 * M_PI;  // [rad] of a joint without limits

void check_initial_joints(const Scenario& scenario, const TreeSpec& tree, Diagnostics* diagnostics) {
  for (const auto& [name, q] : scenario.initial_joints) {
    const int index = tree.find_joint(name);
    if (index < 0) continue;
    const JointSpec& joint = tree.joint(index);
    const bool turns = joint.kind == JointKind::kRevolute;
    const double beyond = std::max(joint.lower - q, q - joint.upper);
    const bool endless = turns && std::isinf(joint.lower) && std::isinf(joint.upper) && std::abs(q) > kTurns;
    if (!(beyond > 1e-6) && !endless) continue;
    const std::string unit = turns ? " rad" : " m";
    std::string text =
        "is " + format("%g", q) + unit + ", expected " +
        (endless ? "less than two turns either way"
                 : format("%g", joint.lower) + " to " + format("%g", joint.upper) + unit + ", the limits in the URDF");
    if (turns && std::abs(q) > kTurns) text += "; are these degrees?";
    const Diagnostic d = scenario.make_diagnostic("initial.joints." + name, text);
    beyond > kFarBeyond || endless ? diagnostics->add_error(d) : diagnostics->add_warning(d);
  }
}

// A robot whose drives do nothing collapses without a word; nearly always the section was forgotten.
void check_gains(const Scenario& scenario, const TreeSpec& tree, Diagnostics* diagnostics) {
  if (scenario.drive != "servo" || scenario.perfect_joints) return;
  std::string free;
  int count = 0, driven = 0;
  for (int i = 0; i < tree.num_joints(); ++i) {
    const JointSpec& joint = tree.joint(i);
    if (!joint.actuated || joint.mimic.joint >= 0) continue;
    ++driven;
    const auto own = scenario.servo_joints.find(joint.name);
    const ServoGains& gains = own == scenario.servo_joints.end() ? scenario.servo_default : own->second;
    if (gains.kp > 0.0) continue;
    if (++count <= 6) free += (free.empty() ? "" : ", ") + joint.name;
  }
  if (count == 0) return;
  const std::string which =
      count == driven ? "joints are free" : "these joints are free: " + free + (count > 6 ? ", ..." : "");
  diagnostics->add_warning(scenario.make_diagnostic(
      "servo", "no servo gains: " + which +
                   " (kp is 0); give 'servo: {default: {kp: ..., kd: ...}}', or name them in 'unactuated'"));
}

}  // namespace

void check_scenario(const Scenario& scenario, const RobotDescription& robot, Diagnostics* diagnostics) {
  Checker checker(scenario, robot.tree, diagnostics);
  for (size_t i = 0; i < scenario.feet.size(); ++i) {
    checker.check_link("feet[" + std::to_string(i) + "]", scenario.feet[i]);
  }
  for (size_t i = 0; i < scenario.unactuated.size(); ++i) {
    checker.check_joint("unactuated[" + std::to_string(i) + "]", scenario.unactuated[i]);
  }
  checker.check_joint_keys("servo.joints", scenario.servo_joints);
  checker.check_joint_keys("initial.joints", scenario.initial_joints);
  checker.check_joint_keys("rotor_inertia", scenario.rotor_inertia);
  checker.add_bush_joints();
  checker.check_joint_keys("joint_laws", scenario.joint_laws);
  checker.check_link_keys("soles", scenario.soles);
  checker.check_link_keys("link_laws", scenario.link_laws);
  for (const LoopSpec& loop : scenario.loops) {
    checker.check_link("loops." + loop.name + ".link_a", loop.link_a);
    if (!loop.link_b.empty()) checker.check_link("loops." + loop.name + ".link_b", loop.link_b);
  }
  checker.check_link_keys("foot_bush", scenario.foot_bush);
  checker.check_no_contact();
  for (const ImuSpec& imu : scenario.sensors.imus) checker.check_link("sensors.imu." + imu.name + ".link", imu.link);
  for (const WrenchSpec& w : scenario.sensors.wrenches)
    checker.check_link("sensors.wrench." + w.name + ".link", w.link);
  for (const CameraSpec& camera : scenario.sensors.cameras) {
    checker.check_sensor("sensors.camera." + camera.name, camera.link, find_optical_frame_name(camera));
  }
  for (const LidarSpec& lidar : scenario.sensors.lidars) {
    checker.check_sensor("sensors.lidar." + lidar.name, lidar.link, find_frame_name(lidar));
  }
  for (const HandSpec& hand : scenario.hands) checker.check_link("hands." + hand.name + ".link", hand.link);
  if (scenario.controller.type == "walk") {
    checker.check_link("controller.walk.left_foot", scenario.controller.walk.left_foot);
    checker.check_link("controller.walk.right_foot", scenario.controller.walk.right_foot);
  }
  for (size_t i = 0; i < scenario.controller.joint_order.size(); ++i) {
    checker.check_joint("controller.joint_order[" + std::to_string(i) + "]", scenario.controller.joint_order[i]);
  }
  check_feet_have_soles(scenario, robot, diagnostics);
  check_feet_are_named(scenario, robot, diagnostics);
  check_initial_joints(scenario, robot.tree, diagnostics);
  check_gains(scenario, robot.tree, diagnostics);
}

void check_pushes(const Scenario& scenario, const RobotDescription& robot, Diagnostics* diagnostics) {
  Checker checker(scenario, robot.tree, diagnostics);
  for (const PushSpec& push : scenario.pushes) checker.check_body("pushes." + push.name + ".link", push.link, robot);
}

// Here, as logs are read without the geometry of feet.
bool is_bush_joint(const std::string& joint) {
  for (const std::string end : kBushEndings) {
    if (joint != end && ends_with(joint, end)) return true;
  }
  return false;
}

}  // namespace hrp
