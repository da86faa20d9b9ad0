// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/visible_world.h"

#include <map>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"
#include "common/robot/ground_plane.h"
#include "common/robot/mesh.h"

namespace hrp {
namespace {

const Vector3d kFloorColor(0.62, 0.62, 0.58);

VisibleKind find_kind(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kBox: return VisibleKind::kBox;
    case ShapeKind::kSphere: return VisibleKind::kSphere;
    case ShapeKind::kCylinder: return VisibleKind::kCylinder;
    case ShapeKind::kMesh: return VisibleKind::kMesh;
  }
  return VisibleKind::kBox;
}

VisibleKind find_kind(const std::string& shape) {
  return shape == "sphere" ? VisibleKind::kSphere : shape == "cylinder" ? VisibleKind::kCylinder : VisibleKind::kBox;
}

// Links on both sides of a robot often share a file.
class MeshStore {
 public:
  // nullptr after a note.
  std::shared_ptr<const Mesh> load(const CollisionShape& shape, std::vector<std::string>* notes) {
    std::string key = shape.mesh;
    for (const double factor : shape.scale) key += " " + std::to_string(factor);
    const auto found = meshes_.find(key);
    if (found != meshes_.end()) return found->second;
    std::shared_ptr<const Mesh>& mesh = meshes_[key];
    try {
      mesh = std::make_shared<Mesh>(load_mesh(shape.mesh, shape.scale));
    } catch (const InputError& error) {
      notes->push_back(error.what());
    }
    return mesh;
  }

 private:
  std::map<std::string, std::shared_ptr<const Mesh>> meshes_;
};

}  // namespace

VisibleWorld::VisibleWorld(const RobotDescription& robot, const Scenario& scenario)
    : model_(robot.tree, scenario.gravity_W), data_(model_), movers_(make_movers(robot, scenario)) {
  add_visuals(robot, 0);
  if (scenario.ground.present) add_ground(scenario.ground);
  for (const ObstacleSpec& obstacle : scenario.obstacles) add_obstacle(robot, obstacle);
  for (const Mover& mover : movers_) {
    add_visuals(mover.robot, mover.first_body);
    const Model model(mover.robot.tree, scenario.gravity_W);
    moving_.push_back({model, Data(model)});
    mover_poses_.resize(mover_poses_.size() + mover.robot.tree.links.size());
  }
  poses_.resize(shapes_.size());
}

void VisibleWorld::add_visuals(const RobotDescription& robot, int first_body) {
  MeshStore meshes;
  for (const VisualShape& visual : robot.visuals) {
    VisibleShape shape;
    shape.body = first_body + visual.shape.link;
    shape.kind = find_kind(visual.shape.kind);
    shape.X_BG = visual.shape.X_LG;
    shape.size = visual.shape.size;
    shape.color = visual.color;
    if (shape.kind == VisibleKind::kMesh) shape.mesh = meshes.load(visual.shape, &notes_);
    if (shape.kind != VisibleKind::kMesh || shape.mesh) shapes_.push_back(shape);
  }
}

void VisibleWorld::add_ground(const GroundSpec& ground) {
  const GroundPlane plane = make_ground_plane(ground);
  VisibleShape shape;
  shape.kind = VisibleKind::kPlane;
  shape.X_BG = {Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), plane.n_W).toRotationMatrix(),
                plane.offset * plane.n_W};
  shape.color = kFloorColor;
  shape.chequered = true;
  shapes_.push_back(shape);
}

void VisibleWorld::add_obstacle(const RobotDescription& robot, const ObstacleSpec& obstacle) {
  VisibleShape shape;
  shape.X_BG = obstacle.X_WG;
  shape.size = obstacle.size;
  shape.color = obstacle.color;
  shape.kind = find_kind(obstacle.shape);
  if (!obstacle.is_surface()) return shapes_.push_back(shape);
  shape.kind = VisibleKind::kMesh;
  for (const auto& surface : robot.surfaces) {
    if (surface->obstacle != obstacle.name) continue;
    shape.mesh = std::make_shared<Mesh>(make_triangles(*surface));
    shapes_.push_back(shape);
  }
}

Transform VisibleWorld::find_body_pose(int body) const {
  if (body == kGround) return {};
  return is_object(body) ? mover_poses_[static_cast<size_t>(body - kFirstObject)] : get_pose(data_, body);
}

void VisibleWorld::update_mover_poses(const ObjectStates& states) {
  for (size_t k = 0; k < movers_.size(); ++k) {
    auto& [model, data] = moving_[k];
    update_kinematics(model, states[k], &data);
    const auto first = static_cast<size_t>(movers_[k].first_body - kFirstObject);
    for (int link = 0; link < movers_[k].num_bodies(); ++link)
      mover_poses_[first + static_cast<size_t>(link)] = get_pose(data, link);
  }
}

void VisibleWorld::update(const State& state, const ObjectStates& objects) {
  if (state.q.size() != model_.num_joints()) {
    throw std::invalid_argument("a state of " + std::to_string(state.q.size()) + " joints, the robot has " +
                                std::to_string(model_.num_joints()));
  }
  const std::string wrong = find_wrong_states(movers_, objects);
  if (!wrong.empty()) throw std::invalid_argument("a state with " + wrong);
  update_kinematics(model_, state, &data_);
  update_mover_poses(objects);
  for (size_t i = 0; i < shapes_.size(); ++i) poses_[i] = find_body_pose(shapes_[i].body) * shapes_[i].X_BG;
}

Transform VisibleWorld::find_mount_pose(const std::string& link, const Transform& X_LC) const {
  if (link.empty()) return X_LC;
  const int frame = model_.spec().find_frame(link);
  if (frame < 0) throw std::invalid_argument("the robot has no link '" + link + "'");
  return calc_frame_pose(model_, data_, frame) * X_LC;
}

}  // namespace hrp
