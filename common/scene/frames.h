// SPDX-License-Identifier: BSD-3-Clause
// The robots' frames as trees of names, as tf of ROS and Foxglove want them.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/multibody/tree_spec.h"
#include "common/robot/movers.h"
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
  // Of another robot in the world of a first one: frames are "partner/L_FOOT" for robot "partner", "L_FOOT" for "".
  FrameTree(const TreeSpec& tree, const std::string& robot, const std::string& world);
  // "world", or "simulation_world" for a first robot that has a link of that name.
  const std::string& world() const { return world_; }
  // The frame of a link or a sensor that the URDF or the scenario calls `name`.
  std::string find_frame(const std::string& name) const { return prefix_ + name; }
  // The frame of a link. Throws std::out_of_range for one that is not there.
  const std::string& get_link(int link) const { return tree_.links.at(static_cast<size_t>(link)).name; }
  // Frames that do not move against their parent: every other link of the URDF, those of cameras (optical) and of
  // lidars.
  std::vector<NamedTransform> make_fixed(const SensorsSpec& sensors) const;
  // The base in the world and every other moving link in its parent. Overwrites `found`, whose memory is used again.
  // Throws std::invalid_argument for a state of another robot.
  void update_moving(const State& state, std::vector<NamedTransform>* found) const;

 private:
  TreeSpec tree_;       // with the names of frames
  std::string prefix_;  // "partner/"
  std::string world_;
};

// One for each robot of a run (movers.h), all in one world.
std::vector<FrameTree> make_frame_trees(const std::vector<Mover>& robots);

// make_fixed() of all of them.
std::vector<NamedTransform> make_fixed_frames(const std::vector<FrameTree>& trees, const std::vector<Mover>& robots);

}  // namespace hrp
