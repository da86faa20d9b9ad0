// SPDX-License-Identifier: BSD-3-Clause
// What there is to see in a run: robots as they are drawn, ground, obstacles, movable objects.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "common/robot/movers.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

enum class VisibleKind { kBox, kSphere, kCylinder, kMesh, kPlane };

struct VisibleShape {
  int body = kGround;  // as in ContactPair; kGround: all that is fixed to the world
  VisibleKind kind = VisibleKind::kBox;
  Transform X_BG;                     // geometry frame G in the body
  Vector3d size = Vector3d::Zero();   // [m] as CollisionShape::size
  std::shared_ptr<const Mesh> mesh;   // of kMesh, in G
  Vector3d color = Vector3d::Ones();  // red, green, blue, 0 to 1
  bool chequered = false;             // every second square of half a metre is darker, so that a motion over it is seen
};

class VisibleWorld {
 public:
  // A mesh that cannot be read is left out and said in notes().
  VisibleWorld(const RobotDescription& robot, const Scenario& scenario);
  const std::vector<VisibleShape>& shapes() const { return shapes_; }
  const std::vector<std::string>& notes() const { return notes_; }

  // Moves everything to where it is in this state. Throws std::invalid_argument for a state of another robot.
  void update(const State& state, const ObjectStates& objects);
  // X_WG of each shape after the last update.
  const std::vector<Transform>& poses() const { return poses_; }
  // X_WC of a mount in a URDF link, or in the world where `link` is empty.
  Transform find_mount_pose(const std::string& link, const Transform& X_LC) const;

 private:
  void add_visuals(const RobotDescription& robot, int first_body);
  void add_ground(const GroundSpec& ground);
  void add_obstacle(const RobotDescription& robot, const ObstacleSpec& obstacle);
  void update_mover_poses(const ObjectStates& states);
  Transform find_body_pose(int body) const;

  std::vector<VisibleShape> shapes_;
  std::vector<std::string> notes_;
  Model model_;
  Data data_;
  std::vector<Mover> movers_;
  struct Moving {
    Model model;
    Data data;
  };
  std::vector<Moving> moving_;          // each mover
  std::vector<Transform> mover_poses_;  // of their bodies
  std::vector<Transform> poses_;
};

}  // namespace hrp
