// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/scenario_check.h"

#include <algorithm>

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
    for (const auto& bush : scenario_.foot_bush) {
      for (const char* suffix : kBushEndings) joints_.push_back(bush.first + suffix);
    }
  }
  void check_link(const std::string& key, const std::string& name) { check(key, name, links_, "link"); }
  void check_joint(const std::string& key, const std::string& name) { check(key, name, joints_, "joint that moves"); }
  template <typename Map>
  void check_joint_keys(const std::string& key, const Map& map) {
    for (const auto& item : map) check_joint(key + "." + item.first, item.first);
  }
  template <typename Map>
  void check_link_keys(const std::string& key, const Map& map) {
    for (const auto& item : map) check_link(key + "." + item.first, item.first);
  }

 private:
  void check(const std::string& key, const std::string& name, const std::vector<std::string>& names,
             const std::string& kind) {
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    const std::string nearest = find_nearest(name, names);
    diagnostics_->add_error(scenario_.make_diagnostic(
        key, "the robot has no " + kind + " '" + name + "'" + (nearest.empty() ? "" : "; did you mean '" + nearest + "'?")));
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
    const Diagnostic d = scenario.make_diagnostic("feet[" + std::to_string(i) + "]",
        "link '" + scenario.feet[i] + "' has no collision geometry to stand on; give one in 'soles'");
    if (robot.tree.floating_base && scenario.drive != "motion") {
      diagnostics->add_error(d);
    } else {
      diagnostics->add_warning(d);
    }
  }
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
  for (const ImuSpec& imu : scenario.sensors.imus) checker.check_link("sensors.imu." + imu.name + ".link", imu.link);
  for (const WrenchSpec& w : scenario.sensors.wrenches) checker.check_link("sensors.wrench." + w.name + ".link", w.link);
  for (const PushSpec& push : scenario.pushes) checker.check_link("pushes." + push.name + ".link", push.link);
  for (const HandSpec& hand : scenario.hands) checker.check_link("hands." + hand.name + ".link", hand.link);
  if (scenario.controller.type == "walk") {
    checker.check_link("controller.walk.left_foot", scenario.controller.walk.left_foot);
    checker.check_link("controller.walk.right_foot", scenario.controller.walk.right_foot);
  }
  for (size_t i = 0; i < scenario.controller.joint_order.size(); ++i) {
    checker.check_joint("controller.joint_order[" + std::to_string(i) + "]", scenario.controller.joint_order[i]);
  }
  check_feet_have_soles(scenario, robot, diagnostics);
}

// Here, as logs are read without the geometry of feet.
bool is_bush_joint(const std::string& joint) {
  for (const std::string end : kBushEndings) {
    if (joint.size() > end.size() && joint.compare(joint.size() - end.size(), end.size(), end) == 0) return true;
  }
  return false;
}

}  // namespace hrp
