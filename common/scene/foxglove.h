// SPDX-License-Identifier: BSD-3-Clause
// A run as the 3D panel of Foxglove draws it: JSON messages of the types foxglove.FrameTransforms and
// foxglove.SceneUpdate. Field by field as in the JSON schemas of github.com/foxglove/foxglove-sdk.
#pragma once

#include <string>
#include <vector>

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/scene/frames.h"
#include "common/scene/ground_contact.h"

namespace hrp::foxglove {

inline constexpr const char* kFrameTransforms = "foxglove.FrameTransforms";
inline constexpr const char* kSceneUpdate = "foxglove.SceneUpdate";

// JSON schema of one of the two types above, self-contained.
std::string find_schema(const std::string& type);

// `time` [s]: simulated.
std::string make_transforms(const std::vector<NamedTransform>& transforms, double time);

// The robot's collision shapes, one entity a link, each fixed to its link's frame. Meshes that cannot be read are named
// in `notes`.
std::string make_robot(const RobotDescription& robot, const FrameTree& frames, double time, std::vector<std::string>* notes);

// Ground and obstacles. `robot` has the surfaces of those that files give.
std::string make_world(const RobotDescription& robot, const Scenario& scenario, const FrameTree& frames, double time);

// Length of a force's arrow [m/N]: the robot's weight is as long as 0.5 m.
double calc_arrow_scale(double mass);

// What presses on the robot, in world axes: an arrow for each link (entity "force/<link>"; its metadata has the numbers),
// the support polygon ("support_polygon") and the zero-moment point ("zmp"). What is not there is deleted.
std::string make_contacts(const ContactForces& forces, const FrameTree& frames, const GroundPlane& ground,
                          double metres_per_newton, double time);

}  // namespace hrp::foxglove
