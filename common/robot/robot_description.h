// SPDX-License-Identifier: BSD-3-Clause
// The robot as every server knows it: tree, geometry, and the scenario it is run in.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/multibody/tree_spec.h"
#include "common/robot/surface.h"

namespace hrp {

enum class ShapeKind { kBox, kSphere, kCylinder, kMesh };

struct CollisionShape {
  int link = 0;
  std::string name;
  ShapeKind kind = ShapeKind::kBox;
  Transform X_LG;                    // geometry frame G in the link
  Vector3d size = Vector3d::Zero();  // [m] box: edges; sphere: x = radius; cylinder: x = radius, y = length along z
  std::string mesh;                  // absolute path, empty for primitives
  Vector3d scale = Vector3d::Ones();
  bool sole = false;  // belongs to a foot: may touch the ground
};

// A shape as eyes see it. Of its fields all but `sole` mean something.
struct VisualShape {
  CollisionShape shape;
  Vector3d color{0.75, 0.78, 0.82};  // red, green, blue, 0 to 1
};

struct OtherRobot;

struct RobotDescription {
  TreeSpec tree;
  std::vector<CollisionShape> shapes;
  std::vector<std::shared_ptr<const Surface>> surfaces;  // of the scenario's obstacles that files give
  std::vector<VisualShape> visuals;                      // of a scenario with cameras or lidars; else nobody looks
  std::string urdf_path;
  std::string urdf;
  std::string scenario_path;
  std::string scenario;               // YAML text, parsed by parse_scenario() wherever it is needed
  std::vector<std::string> warnings;  // "file:line: warning: ..."
  std::vector<OtherRobot> robots;     // the scenario's other robots, in its order
};

// Another robot of the scenario. It has no others of its own.
struct OtherRobot {
  std::string name;
  RobotDescription description;
};

}  // namespace hrp
