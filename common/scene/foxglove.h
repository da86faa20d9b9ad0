// SPDX-License-Identifier: BSD-3-Clause
// A run as the 3D panel of Foxglove draws it: JSON messages of the types foxglove.FrameTransforms and
// foxglove.SceneUpdate. Field by field as in the JSON schemas of github.com/foxglove/foxglove-sdk.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "common/robot/movers.h"
#include "common/robot/signals.h"
#include "common/scene/frames.h"
#include "common/scene/ground_contact.h"

namespace hrp::foxglove {

inline constexpr const char* kFrameTransforms = "foxglove.FrameTransforms";
inline constexpr const char* kSceneUpdate = "foxglove.SceneUpdate";

// JSON schema of one of the two types above, self-contained.
std::string find_schema(const std::string& type);

// All robots of a run in their world. Frames and entities of robot "partner" have "partner/" before their names.
// `time` [s]: simulated.
class Scene {
 public:
  // Throws as make_movers() does.
  Scene(const RobotDescription& robot, const Scenario& scenario);
  const std::vector<Mover>& robots() const { return robots_; }
  const std::vector<FrameTree>& frames() const { return frames_; }

  // Frames that do not move against their parent, and those that do. Throws std::exception for states of other robots.
  std::string make_fixed_transforms(double time) const;
  std::string make_transforms(const State& first, const ObjectStates& others, double time) const;
  // The robots' collision shapes, one entity a link ("link/<link>"), and the objects ("object/<name>"), each fixed to
  // its own frame. Meshes that cannot be read are named in `notes`.
  std::string make_robots(double time, std::vector<std::string>* notes) const;
  // Ground and obstacles.
  std::string make_world(double time) const;
  // What presses on the robots, in world axes: an arrow for each link (entity "force/<link>"; its metadata has the
  // numbers; the first robot's weight is 0.5 m long), of each robot the support polygon ("support_polygon") and the
  // zero-moment point ("zmp"). What is not there is deleted.
  std::string make_contacts(const ContactForces& forces, double time) const;
  // What pushes robots and objects from outside, in this state: an arrow for each, of the same scale, in one entity
  // "pushes", whose metadata has the numbers. Throws std::exception for a link or a state that nobody has.
  std::string make_pushes(const State& first, const ObjectStates& others, const PushForces& pushes, double time) const;

 private:
  Scene(const RobotDescription& robot, const Scenario& scenario, const std::vector<Mover>& movers);

  std::vector<Mover> movers_;  // objects, then other robots
  std::vector<Mover> robots_;
  std::vector<FrameTree> frames_;
  Scenario scenario_;
  GroundPlane ground_;
  Model model_;  // of the first robot
  double metres_per_newton_;
};

}  // namespace hrp::foxglove
