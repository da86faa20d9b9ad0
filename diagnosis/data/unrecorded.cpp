// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/unrecorded.h"

#include <algorithm>

#include "diagnosis/data/urdf_text.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::diagnosis {
namespace {

bool is_recorded(const Experiment& e, int joint) {
  return std::any_of(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) {
    const JointColumns& c = r.joints[static_cast<size_t>(joint)];
    return c.has(Quantity::kPosition) || c.has(Quantity::kVelocity) || c.has(Quantity::kEffort) || !c.command.empty();
  });
}

// Joints that are not recorded and have no recorded joint beyond them.
std::vector<std::string> list_unrecorded(const Experiment& e) {
  const TreeSpec& tree = e.robot.tree;
  std::vector<char> needed(tree.links.size(), 0);
  for (int j = tree.num_joints() - 1; j >= 0; --j) {  // parents come first
    const auto link = static_cast<size_t>(j) + 1;
    needed[link] = needed[link] || is_recorded(e, j);
    if (needed[link]) needed[static_cast<size_t>(tree.links[link].parent)] = 1;
  }
  std::vector<std::string> names;
  for (int j = 0; j < tree.num_joints(); ++j) {
    if (!needed[static_cast<size_t>(j) + 1]) names.push_back(tree.joint(j).name);
  }
  return names;
}

}  // namespace

bool fix_unrecorded(Experiment* e) {
  if (e->scenario.floating_base) return false;
  const std::vector<std::string> names = list_unrecorded(*e);
  if (names.empty() || static_cast<int>(names.size()) == e->num_joints()) return false;
  std::string urdf = e->robot.urdf;
  bool mentioned = false;
  for (const std::string& name : names) {
    urdf = set_joint_attribute(urdf, name, "", "type", "fixed");
    mentioned = e->scenario.servo_joints.erase(name) + e->scenario.initial_joints.erase(name) +
                        e->scenario.rotor_inertia.erase(name) + e->scenario.joint_laws.erase(name) >
                    0 ||
                mentioned;
    const int leader = e->robot.tree.joint(e->robot.tree.find_joint(name)).mimic.joint;
    e->warnings.push_back("joint " + name + " is in no recording: taken as fixed at its zero" +
                          (leader < 0 ? "" : ", although it follows " + e->robot.tree.joint(leader).name));
  }
  const std::string own = e->robot.urdf;
  e->robot = parse_robot(urdf, e->robot.urdf_path, e->scenario);
  if (mentioned) e->robot.urdf = own;  // the updated scenario refers to it
  e->recordings.clear();
  return true;
}

}  // namespace hrp::diagnosis
