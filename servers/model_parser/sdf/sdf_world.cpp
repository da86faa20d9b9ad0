// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/sdf/sdf_world.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "servers/model_parser/mesh_path.h"
#include "servers/model_parser/sdf/load_sdf.h"

namespace hrp {
namespace {

class Reader {
 public:
  Reader(const Scenario& scenario, Diagnostics* diagnostics) : scenario_(scenario), diagnostics_(diagnostics) {
    for (const ObstacleSpec& obstacle : scenario.obstacles) names_.insert(obstacle.name);
    spec_.ground.present = false;
  }

  WorldSpec read(const sdf::World& world) {
    for (uint64_t i = 0; i < world.ModelCount(); ++i) read_model(*world.ModelByIndex(i));
    return std::move(spec_);
  }

 private:
  void error(int line, const std::string& field, const std::string& message) {
    diagnostics_->add_error({scenario_.world, field, line}, message);
  }
  Transform resolve(const sdf::SemanticPose& pose, const std::string& to, int line, const std::string& field) {
    ignition::math::Pose3d X;
    for (const sdf::Error& e : pose.Resolve(X, to)) error(line, field, e.Message());
    return make_transform(X);
  }

  void read_model(const sdf::Model& model) {
    const std::string field = "model '" + model.Name() + "'";
    const int line = find_line(model);
    if (!model.Static()) {
      return error(line, field,
                   "is not <static>: movable objects are not simulated, and the robot is the scenario's 'robot'");
    }
    if (model.ModelCount() > 0) return error(line, field, "holds nested models, which are not supported");
    const Transform X_WM = resolve(model.SemanticPose(), "", line, field);
    for (uint64_t i = 0; i < model.LinkCount(); ++i) {
      const sdf::Link& link = *model.LinkByIndex(i);
      const Transform X_WL = X_WM * resolve(link.SemanticPose(), "__model__", find_line(link), field);
      for (uint64_t k = 0; k < link.CollisionCount(); ++k) {
        const sdf::Collision& collision = *link.CollisionByIndex(k);
        const std::string where = field + " <collision name=\"" + collision.Name() + "\">";
        read_collision(model.Name(), collision,
                       X_WL * resolve(collision.SemanticPose(), link.Name(), find_line(collision), where), where);
      }
    }
  }

  // <surface><friction><ode><mu>, where it is stated.
  static double find_friction(const sdf::Collision& collision) {
    sdf::ElementPtr at = collision.Element();
    for (const char* name : {"surface", "friction", "ode", "mu"}) {
      if (!at || !at->HasElement(name)) return ObstacleSpec().friction;
      at = at->GetElement(name);
    }
    return at->Get<double>();
  }

  void read_collision(const std::string& model, const sdf::Collision& collision, const Transform& X_WG,
                      const std::string& where) {
    ObstacleSpec obstacle;
    obstacle.X_WG = X_WG;
    obstacle.friction = find_friction(collision);
    const int line = find_line(collision);
    const auto add = [&](const std::string& shape, const Vector3d& size) {
      obstacle.shape = shape;
      obstacle.size = size;
      add_obstacle(model, obstacle);
    };
    const sdf::Geometry& geometry = *collision.Geom();
    if (const sdf::Box* box = geometry.BoxShape()) return add("box", make_vector(box->Size()));
    if (const sdf::Sphere* sphere = geometry.SphereShape()) return add("sphere", {sphere->Radius(), 0, 0});
    if (const sdf::Cylinder* cylinder = geometry.CylinderShape())
      return add("cylinder", {cylinder->Radius(), cylinder->Length(), 0});
    if (const sdf::Capsule* capsule = geometry.CapsuleShape()) {
      add("cylinder", {capsule->Radius(), capsule->Length(), 0});
      for (const double z : {-0.5 * capsule->Length(), 0.5 * capsule->Length()}) {
        obstacle.X_WG.p = X_WG * Vector3d(0, 0, z);
        add("sphere", {capsule->Radius(), 0, 0});
      }
      return;
    }
    if (const sdf::Plane* plane = geometry.PlaneShape())
      return set_ground(make_vector(plane->Normal()), obstacle, line, where);
    if (const sdf::Mesh* mesh = geometry.MeshShape()) return add_mesh(model, *mesh, obstacle, line, where);
    if (geometry.Type() == sdf::GeometryType::EMPTY) return;
    error(line, where,
          "is of a shape that is not supported, expected box, sphere, cylinder, capsule, mesh or plane; images of "
          "heights "
          "are obstacles of shape 'height_field'");
  }

  void add_mesh(const std::string& model, const sdf::Mesh& mesh, ObstacleSpec obstacle, int line,
                const std::string& where) {
    obstacle.shape = "mesh";
    obstacle.scale = make_vector(mesh.Scale());
    obstacle.file = find_mesh(make_mesh_name(mesh.Uri()), mesh.FilePath().empty() ? scenario_.world : mesh.FilePath());
    if (obstacle.file.empty()) obstacle.file = find_mesh(make_mesh_name(mesh.Uri()), scenario_.world);
    if (obstacle.file.empty()) return error(line, where, "there is no file '" + mesh.Uri() + "'");
    if (!mesh.Submesh().empty()) return error(line, where, "takes a part of a mesh, which is not supported: <submesh>");
    add_obstacle(model, obstacle);
  }

  void set_ground(const Vector3d& n_G, const ObstacleSpec& at, int line, const std::string& where) {
    const Vector3d n = at.X_WG.R * n_G;
    if (spec_.ground.present) return error(line, where, "is a second plane: a scenario has one ground");
    if (!(n.z() > 0.5)) return error(line, where, "is a plane that is steeper than 60 degrees, expected a ground");
    spec_.ground.present = true;
    spec_.ground.friction = at.friction;
    spec_.ground.height = n.dot(at.X_WG.p) / n.z();
    set_ground_normal(n, &spec_.ground);
  }

  // The model's name; with a number from the second shape on. Dots and brackets are for paths of keys.
  void add_obstacle(const std::string& model, ObstacleSpec obstacle) {
    std::string name = model;
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '.' || c == '[' || c == ':'; }, '_');
    obstacle.name = name;
    for (int i = 2; !names_.insert(obstacle.name).second; ++i) obstacle.name = name + "_" + std::to_string(i);
    spec_.obstacles.push_back(obstacle);
  }

  const Scenario& scenario_;
  Diagnostics* diagnostics_;
  std::set<std::string> names_;
  WorldSpec spec_;
};

}  // namespace

void set_ground_normal(const Vector3d& n, GroundSpec* ground) {
  ground->roll = std::asin(-n.y());
  ground->pitch = std::atan2(n.x(), n.z());
}

WorldSpec read_sdf_world(const std::string& text, const Scenario& scenario, Diagnostics* diagnostics) {
  sdf::Root root;
  if (!load_sdf(text, scenario.world, &root, diagnostics)) return {};
  if (root.WorldCount() == 1) return Reader(scenario, diagnostics).read(*root.WorldByIndex(0));
  diagnostics->add_error(
      scenario.world, "has " + std::to_string(root.WorldCount()) + " <world> elements, expected one right below <sdf>");
  return {};
}

}  // namespace hrp
