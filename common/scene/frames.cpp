// SPDX-License-Identifier: BSD-3-Clause
#include "common/scene/frames.h"

#include <stdexcept>

#include "common/multibody/joint_motion.h"

namespace hrp {
FrameTree::FrameTree(const TreeSpec& tree) : tree_(tree), world_("world") {
  if (tree.find_frame(world_) >= 0 || tree.find_link(world_) >= 0) world_ = "simulation_world";
}

FrameTree::FrameTree(const TreeSpec& tree, const std::string& robot, const std::string& world)
    : tree_(tree), prefix_(robot.empty() ? "" : robot + "/"), world_(world) {
  for (LinkSpec& link : tree_.links) link.name = find_frame(link.name);
  for (FrameSpec& frame : tree_.frames) frame.name = find_frame(frame.name);
}

std::vector<FrameTree> make_frame_trees(const std::vector<Mover>& robots) {
  std::vector<FrameTree> trees;
  for (const Mover& robot : robots) {
    if (trees.empty())
      trees.emplace_back(robot.robot.tree);
    else
      trees.emplace_back(robot.robot.tree, robot.name, trees[0].world());
  }
  return trees;
}

std::vector<NamedTransform> FrameTree::make_fixed(const SensorsSpec& sensors) const {
  std::vector<NamedTransform> found;
  for (const FrameSpec& frame : tree_.frames) {
    if (frame.name != get_link(frame.link)) found.push_back({get_link(frame.link), frame.name, frame.X_LF});
  }
  const auto find_parent = [this](const std::string& link) { return link.empty() ? world_ : find_frame(link); };
  for (const CameraSpec& camera : sensors.cameras) {
    found.push_back(
        {find_parent(camera.link), find_frame(find_optical_frame_name(camera)), camera.X_LC * make_optical_frame()});
  }
  for (const LidarSpec& lidar : sensors.lidars)
    found.push_back({find_parent(lidar.link), find_frame(find_frame_name(lidar)), lidar.X_LC});
  return found;
}

void FrameTree::update_moving(const State& state, std::vector<NamedTransform>* found) const {
  if (state.q.size() != tree_.num_joints()) throw std::invalid_argument("a state of another robot");
  found->resize(tree_.links.size());
  for (size_t i = 0; i < tree_.links.size(); ++i) {
    const LinkSpec& link = tree_.links[i];
    NamedTransform& at = (*found)[i];
    at.parent = i == 0 ? world_ : get_link(link.parent);
    at.child = link.name;
    at.X_PC = i == 0 ? state.X_WB()
                     : link.joint.X_PF * calc_joint_motion(link.joint, state.q[static_cast<Eigen::Index>(i) - 1]);
  }
}

std::vector<NamedTransform> make_fixed_frames(const std::vector<FrameTree>& trees, const std::vector<Mover>& robots) {
  std::vector<NamedTransform> all;
  for (size_t k = 0; k < robots.size(); ++k) {
    const std::vector<NamedTransform> fixed = trees[k].make_fixed(robots[k].scenario.sensors);
    all.insert(all.end(), fixed.begin(), fixed.end());
  }
  return all;
}

}  // namespace hrp
