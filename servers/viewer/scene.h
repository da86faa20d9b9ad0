// SPDX-License-Identifier: BSD-3-Clause
// What a page must know of a robot and its world besides messages.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hrp_idl/model.h"
#include "servers/viewer/connection.h"

namespace hrp {

struct Scene {
  std::string json;                 // for pages: servers/viewer/page/src/scene.js reads it
  std::vector<std::string> joints;  // order of all arrays with a number per joint
  std::string urdf_path;
  std::string urdf;
  double ground_height = 0.0;  // [m]; NaN where there is no plane
  std::string name;            // of another robot; empty for the first one
  std::vector<Scene> robots;   // other robots of the scenario: their models, without a world
};

Scene make_scene(const msg::RobotDescription& description);

// The robot of that name, or the first one (""); nullptr: there is none.
const Scene* find_robot_scene(const Scene& scene, const std::string& name);

// The mesh that a URDF names, read from the URDF's own folders: its folder and the package that it names. Nothing for
// files that the URDF does not name, that are no meshes, or that lie elsewhere.
std::optional<WebFile> read_mesh(const Scene& scene, const std::string& name);

}  // namespace hrp
