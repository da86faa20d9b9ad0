// SPDX-License-Identifier: BSD-3-Clause
// The robot's frames as a tree of names, as tf of ROS and Foxglove want them.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/multibody/tree_spec.h"
#include "common/robot/scenario.h"

namespace hrp {

// X_PC: pose of the child frame in the parent frame.
struct NamedTransform {
  std::string parent, child;
  Transform X_PC;
};

class FrameTree {
 public:
  explicit FrameTree(const TreeSpec& tree);
  // "world", or "simulation_world" for a robot that has a link of that name.
  const std::string& world() const { return world_; }
  // Throws std::out_of_range for a link that is not there.
  const std::string& get_link(int link) const { return tree_.links.at(static_cast<size_t>(link)).name; }
  // Frames that do not move against their parent: every other link of the URDF, those of cameras (optical) and of lidars.
  std::vector<NamedTransform> make_fixed(const SensorsSpec& sensors) const;
  // The base in the world and every other moving link in its parent. Overwrites `found`, whose memory is used again. Throws
  // std::invalid_argument for a state of another robot.
  void update_moving(const State& state, std::vector<NamedTransform>* found) const;

 private:
  TreeSpec tree_;
  std::string world_;
};

}  // namespace hrp
