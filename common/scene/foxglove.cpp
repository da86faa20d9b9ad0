// SPDX-License-Identifier: BSD-3-Clause
#include "common/scene/foxglove.h"

#include <cmath>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"
#include "common/robot/mesh.h"
#include "common/scene/json_text.h"
#include "common/spatial/gravity.h"

namespace hrp::foxglove {
namespace {

struct Colour {
  double r, g, b, a;
};

constexpr Colour kBody{0.75, 0.78, 0.82, 1.0}, kSole{0.35, 0.38, 0.45, 1.0}, kFloor{0.55, 0.55, 0.52, 0.35},
    kStone{0.72, 0.70, 0.66, 1.0}, kForce{0.90, 0.30, 0.20, 1.0}, kPush{0.45, 0.35, 0.85, 1.0},
    kObject{0.50, 0.64, 0.42, 1.0}, kPolygon{0.20, 0.70, 0.35, 1.0}, kZmp{0.95, 0.80, 0.10, 1.0};
constexpr double kFloorSize = 20.0, kFloorThickness = 0.01;                         // [m]
constexpr double kShaft = 0.012, kHead = 0.03, kLine = 0.004, kZmpDiameter = 0.03;  // [m]
constexpr double kWeightLength = 0.5;                                               // [m]
constexpr size_t kMostTriangles = 20000;  // of one shape: more makes pages slow
enum LineType { kStrip, kLoop, kList };
enum DeletionType { kMatchingId, kAll };

void put_time(const char* name, double time, JsonText* json) {
  const long nanoseconds = std::lround(time * 1e9);
  json->key(name)
      .begin('{')
      .key("sec")
      .put(nanoseconds / 1000000000)
      .key("nsec")
      .put(nanoseconds % 1000000000)
      .end('}');
}

void put_vector(const Vector3d& v, JsonText* json) {
  json->begin('{').key("x").put(v.x()).key("y").put(v.y()).key("z").put(v.z()).end('}');
}

void put_rotation(const Matrix3d& R, JsonText* json) {
  const Eigen::Quaterniond q(R);
  json->begin('{').key("x").put(q.x()).key("y").put(q.y()).key("z").put(q.z()).key("w").put(q.w()).end('}');
}

void put_pose(const Transform& X, JsonText* json) {
  json->key("pose").begin('{').key("position");
  put_vector(X.p, json);
  put_rotation(X.R, &json->key("orientation"));
  json->end('}');
}

void put_colour(const Colour& colour, JsonText* json) {
  json->key("color")
      .begin('{')
      .key("r")
      .put(colour.r)
      .key("g")
      .put(colour.g)
      .key("b")
      .put(colour.b)
      .key("a")
      .put(colour.a)
      .end('}');
}

void put_points(const std::vector<Vector3d>& points, JsonText* json) {
  json->key("points").begin('[');
  for (const Vector3d& p : points) put_vector(p, json);
  json->end(']');
}

// One entity: primitives come to their lists, in any order.
class Entity {
 public:
  void add_arrow(const Vector3d& from, const Vector3d& along, const Colour& colour) {
    const double length = along.norm();
    JsonText json;
    put_pose({Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along).toRotationMatrix(), from}, &json.begin('{'));
    const double head = std::min(kHead, 0.5 * length);
    json.key("shaft_length").put(length - head).key("shaft_diameter").put(kShaft);
    json.key("head_length").put(head).key("head_diameter").put(2 * kShaft);
    put_colour(colour, &json);
    add(kArrows, json.end('}').text());
  }
  void add_solid(ShapeKind kind, const Transform& X, const Vector3d& size, const Colour& colour) {
    JsonText json;
    put_pose(X, &json.begin('{'));
    put_vector(size, &json.key("size"));
    if (kind == ShapeKind::kCylinder) json.key("bottom_scale").put(1.0).key("top_scale").put(1.0);
    put_colour(colour, &json);
    add(kind == ShapeKind::kBox ? kCubes : kind == ShapeKind::kSphere ? kSpheres : kCylinders, json.end('}').text());
  }
  void add_loop(const std::vector<Vector3d>& points, const Colour& colour) {
    JsonText json;
    json.begin('{').key("type").put(static_cast<long>(kLoop));
    put_pose({}, &json);
    json.key("thickness").put(kLine).key("scale_invariant").put(false);
    put_points(points, &json);
    put_colour(colour, &json);
    add(kLines, json.key("colors").begin('[').end(']').key("indices").begin('[').end(']').end('}').text());
  }
  void add_mesh(const Mesh& mesh, const Transform& X, const Colour& colour) {
    JsonText json;
    put_pose(X, &json.begin('{'));
    put_points(mesh.vertices, &json);
    put_colour(colour, &json);
    json.key("colors").begin('[').end(']').key("indices").begin('[');
    for (const auto& triangle : mesh.triangles) {
      for (const int index : triangle) json.put(static_cast<long>(index));
    }
    add(kTriangles, json.end(']').end('}').text());
  }
  void add_metadata(const char* key, const std::string& value) {
    add(kMetadata, JsonText().begin('{').key("key").put(key).key("value").put(value).end('}').text());
  }
  // Into the open list of entities.
  void put(const std::string& id, const std::string& frame, double time, JsonText* json) const {
    json->begin('{');
    put_time("timestamp", time, json);
    json->key("frame_id").put(frame).key("id").put(id);
    put_time("lifetime", 0.0, json);
    json->key("frame_locked").put(true);
    for (int i = 0; i < kKinds; ++i) json->key(kNames[i]).raw("[" + lists_[i] + "]");
    json->end('}');
  }

 private:
  enum Kind { kMetadata, kArrows, kCubes, kSpheres, kCylinders, kLines, kTriangles, kTexts, kModels, kKinds };
  static constexpr const char* kNames[kKinds] = {"metadata", "arrows",    "cubes", "spheres", "cylinders",
                                                 "lines",    "triangles", "texts", "models"};
  void add(Kind kind, const std::string& json) { lists_[kind] += (lists_[kind].empty() ? "" : ",") + json; }
  std::string lists_[kKinds];
};

void put_deletion(DeletionType type, const std::string& id, double time, JsonText* json) {
  put_time("timestamp", time, &json->begin('{'));
  json->key("type").put(static_cast<long>(type)).key("id").put(id).end('}');
}

// Begins the list of entities of a picture in which everything is new: an arrow of a foot that has left the ground must
// go.
void begin_picture(double time, JsonText* json) {
  put_deletion(kAll, "", time, &json->begin('{').key("deletions").begin('['));
  json->end(']').key("entities").begin('[');
}

// Foxglove's sizes are those along the axes of the solid.
Vector3d find_extent(ShapeKind kind, const Vector3d& size) {
  if (kind == ShapeKind::kSphere) return Vector3d::Constant(2 * size.x());
  if (kind == ShapeKind::kCylinder) return {2 * size.x(), 2 * size.x(), size.y()};
  return size;
}

void add_mesh_shape(const CollisionShape& shape, const Colour& colour, Entity* entity,
                    std::vector<std::string>* notes) {
  try {
    const Mesh mesh = load_mesh(shape.mesh, shape.scale);
    if (mesh.triangles.size() <= kMostTriangles) return entity->add_mesh(mesh, shape.X_LG, colour);
    notes->push_back(shape.mesh + ": " + std::to_string(mesh.triangles.size()) + " triangles are left out");
  } catch (const InputError& error) {
    notes->push_back(error.what());
  }
}

std::string format_newtons(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string format_vector(const Vector3d& v) {
  return format_newtons(v.x()) + " " + format_newtons(v.y()) + " " + format_newtons(v.z());
}

void put_force(const LinkForce& force, const FrameTree& frames, double metres_per_newton, double time, JsonText* json) {
  Entity entity;
  entity.add_arrow(force.p_WC, metres_per_newton * force.force, kForce);
  entity.add_metadata("force x [N]", format_newtons(force.force.x()));
  entity.add_metadata("force y [N]", format_newtons(force.force.y()));
  entity.add_metadata("force z [N]", format_newtons(force.force.z()));
  entity.put("force/" + frames.get_link(force.link), frames.world(), time, json);
}

std::string write_transforms(const std::vector<NamedTransform>& transforms, double time) {
  JsonText json;
  json.begin('{').key("transforms").begin('[');
  for (const NamedTransform& at : transforms) {
    put_time("timestamp", time, &json.begin('{'));
    json.key("parent_frame_id").put(at.parent).key("child_frame_id").put(at.child).key("translation");
    put_vector(at.X_PC.p, &json);
    put_rotation(at.X_PC.R, &json.key("rotation"));
    json.end('}');
  }
  return json.end(']').end('}').text();
}

void add_solid_shape(const CollisionShape& shape, const Colour& colour, Entity* entity) {
  entity->add_solid(shape.kind, shape.X_LG, find_extent(shape.kind, shape.size), colour);
}

void put_links(const RobotDescription& robot, const FrameTree& frames, double time, JsonText* json,
               std::vector<std::string>* notes) {
  std::vector<Entity> links(robot.tree.links.size());
  for (const CollisionShape& shape : robot.shapes) {
    Entity& entity = links[static_cast<size_t>(shape.link)];
    const Colour& colour = shape.sole ? kSole : kBody;
    if (shape.kind == ShapeKind::kMesh)
      add_mesh_shape(shape, colour, &entity, notes);
    else
      add_solid_shape(shape, colour, &entity);
  }
  for (size_t i = 0; i < links.size(); ++i) {
    const std::string& name = frames.get_link(static_cast<int>(i));
    links[i].put("link/" + name, name, time, json);
  }
}

void add_surface(const RobotDescription& robot, const ObstacleSpec& obstacle, Entity* world) {
  for (const auto& surface : robot.surfaces) {
    if (surface->obstacle == obstacle.name) world->add_mesh(make_triangles(*surface), obstacle.X_WG, kStone);
  }
}

void put_obstacle(const RobotDescription& robot, const ObstacleSpec& obstacle, Entity* world) {
  if (obstacle.is_surface()) return add_surface(robot, obstacle, world);
  const ShapeKind kind = obstacle.shape == "sphere"     ? ShapeKind::kSphere
                         : obstacle.shape == "cylinder" ? ShapeKind::kCylinder
                                                        : ShapeKind::kBox;
  world->add_solid(kind, obstacle.X_WG, find_extent(kind, obstacle.size), kStone);
}

// `forces` on this robot's links.
void put_contacts(const ContactForces& forces, const FrameTree& frames, const GroundPlane& ground,
                  double metres_per_newton, double time, JsonText* json) {
  for (const LinkForce& force : sum_link_forces(forces)) put_force(force, frames, metres_per_newton, time, json);
  if (const auto polygon = calc_support_polygon(forces, ground); !polygon.empty()) {
    Entity entity;
    entity.add_loop(polygon, kPolygon);
    entity.put(frames.find_frame("support_polygon"), frames.world(), time, json);
  }
  if (const auto zmp = calc_ground_zmp(forces, ground)) {
    Entity entity;
    entity.add_solid(ShapeKind::kSphere, {Matrix3d::Identity(), *zmp}, Vector3d::Constant(kZmpDiameter), kZmp);
    entity.put(frames.find_frame("zmp"), frames.world(), time, json);
  }
}

// Where the links of the first robot are, and those of movers. Throws std::exception for a link or a state that nobody
// has.
class BodyPoses {
 public:
  BodyPoses(const Model& model, const State& first, const std::vector<Mover>& movers, const ObjectStates& others)
      : model_(model), data_(model), movers_(movers), others_(others) {
    update_kinematics(model, first, &data_);
  }

  Transform find(const std::string& body) const {
    const int link = model_.spec().find_link(body);
    if (link >= 0) return get_pose(data_, link);
    for (size_t k = 0; k < movers_.size(); ++k) {
      const TreeSpec& tree = movers_[k].robot.tree;
      const std::string own = find_own_link(body, movers_[k].name, movers_[k].is_robot, tree);
      if (!own.empty()) return calc_pose(Model(tree), others_.at(k), tree.find_link(own));
    }
    throw std::invalid_argument("a push on a link that is not there: " + body);
  }

 private:
  static Transform calc_pose(const Model& model, const State& state, int link) {
    if (state.q.size() != model.num_joints()) throw std::invalid_argument("a state of another robot");
    Data data(model);
    update_kinematics(model, state, &data);
    return get_pose(data, link);
  }

  const Model& model_;
  Data data_;
  const std::vector<Mover>& movers_;
  const ObjectStates& others_;
};

// The robot's weight is kWeightLength long.
double calc_arrow_scale(double mass) { return kWeightLength / (kGravity * std::max(mass, 1e-3)); }

}  // namespace

Scene::Scene(const RobotDescription& robot, const Scenario& scenario)
    : Scene(robot, scenario, make_movers(robot, scenario)) {}

Scene::Scene(const RobotDescription& robot, const Scenario& scenario, const std::vector<Mover>& movers)
    : movers_(movers),
      robots_(hrp::make_robots(robot, scenario, movers)),
      frames_(make_frame_trees(robots_)),
      scenario_(scenario),
      ground_(make_ground_plane(scenario.ground)),
      model_(robot.tree),
      metres_per_newton_(calc_arrow_scale(model_.mass())) {}

std::string Scene::make_fixed_transforms(double time) const {
  return write_transforms(make_fixed_frames(frames_, robots_), time);
}

std::string Scene::make_transforms(const State& first, const ObjectStates& others, double time) const {
  std::vector<NamedTransform> all, moving;
  for (size_t k = 0; k < robots_.size(); ++k) {
    frames_[k].update_moving(find_robot_state(k, first, others, scenario_), &moving);
    all.insert(all.end(), moving.begin(), moving.end());
  }
  for (size_t k = 0; k < scenario_.objects.size(); ++k)
    all.push_back({frames_[0].world(), scenario_.objects[k].name, others.at(k).X_WB()});
  return write_transforms(all, time);
}

std::string Scene::make_robots(double time, std::vector<std::string>* notes) const {
  JsonText json;
  json.begin('{').key("deletions").begin('[').end(']').key("entities").begin('[');
  for (size_t k = 0; k < robots_.size(); ++k) put_links(robots_[k].robot, frames_[k], time, &json, notes);
  for (const Mover& mover : movers_) {
    if (mover.is_robot) continue;
    Entity object;
    add_solid_shape(mover.robot.shapes[0], kObject, &object);
    object.put("object/" + mover.name, mover.name, time, &json);
  }
  return json.end(']').end('}').text();
}

std::string Scene::make_world(double time) const {
  Entity world;
  if (scenario_.ground.present) {
    const Matrix3d R = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), ground_.n_W).toRotationMatrix();
    world.add_solid(ShapeKind::kBox, {R, ground_.n_W * (ground_.offset - 0.5 * kFloorThickness)},
                    {kFloorSize, kFloorSize, kFloorThickness}, kFloor);
  }
  for (const ObstacleSpec& obstacle : scenario_.obstacles) put_obstacle(robots_[0].robot, obstacle, &world);
  JsonText json;
  json.begin('{').key("deletions").begin('[').end(']').key("entities").begin('[');
  world.put("world", frames_[0].world(), time, &json);
  return json.end(']').end('}').text();
}

std::string Scene::make_contacts(const ContactForces& forces, double time) const {
  JsonText json;
  begin_picture(time, &json);
  for (size_t k = 0; k < robots_.size(); ++k) {
    put_contacts(find_own_forces(forces, robots_[k]), frames_[k], ground_, metres_per_newton_, time, &json);
  }
  return json.end(']').end('}').text();
}

std::string Scene::make_pushes(const State& first, const ObjectStates& others, const PushForces& pushes,
                               double time) const {
  if (first.q.size() != model_.num_joints()) throw std::invalid_argument("a state of another robot");
  JsonText json;
  begin_picture(time, &json);
  if (pushes.empty()) return json.end(']').end('}').text();
  const BodyPoses poses(model_, first, movers_, others);
  Entity all;
  for (const PushForce& push : pushes) {
    all.add_arrow(poses.find(push.link) * push.p_LQ, metres_per_newton_ * push.force_W, kPush);
    all.add_metadata((push.link + " [N]").c_str(), format_vector(push.force_W));
  }
  all.put("pushes", frames_[0].world(), time, &json);
  return json.end(']').end('}').text();
}

}  // namespace hrp::foxglove
