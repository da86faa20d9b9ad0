// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/sole.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"
#include "common/robot/mesh.h"

namespace hrp {
namespace {

constexpr double kFlat = 1e-3;  // [m] vertices this near to the outermost one belong to its flat side

void add_once(const Vector3d& p, std::vector<Vector3d>* points) {
  for (const Vector3d& other : *points) {
    if ((other - p).squaredNorm() < 1e-12) return;  // the same corner of two triangles
  }
  points->push_back(p);
}

const Vector3d& find_outermost(const std::vector<Vector3d>& vertices, const Vector3d& direction) {
  return *std::max_element(vertices.begin(), vertices.end(),
                           [&](const Vector3d& a, const Vector3d& b) { return a.dot(direction) < b.dot(direction); });
}

// The corners of the flat side whose outward normal is +-axis: outermost along 16 directions in the side's plane.
void add_flat_side(const std::vector<Vector3d>& vertices, const Vector3d& normal, std::vector<Vector3d>* points) {
  const double top = find_outermost(vertices, normal).dot(normal);
  std::vector<Vector3d> side;
  for (const Vector3d& v : vertices) {
    if (v.dot(normal) > top - kFlat) side.push_back(v);
  }
  const Vector3d u(normal.y(), normal.z(), normal.x());
  const Vector3d w = normal.cross(u);
  for (int k = 0; k < 16; ++k) {
    const double angle = (k + 0.5) * M_PI / 8.0;
    add_once(find_outermost(side, std::cos(angle) * u + std::sin(angle) * w), points);
  }
}

std::vector<Vector3d> reduce_mesh(const std::vector<Vector3d>& vertices) {
  std::vector<Vector3d> points;
  for (int axis = 0; axis < 3; ++axis) {
    add_flat_side(vertices, Vector3d::Unit(axis), &points);
    add_flat_side(vertices, -Vector3d::Unit(axis), &points);
  }
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) add_once(find_outermost(vertices, Vector3d(x, y, z)), &points);
    }
  }
  return points;
}

void add_box(const CollisionShape& shape, Sole* sole) {
  for (int i = 0; i < 8; ++i) {
    const Vector3d corner(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    sole->points.push_back({shape.X_LG * corner.cwiseProduct(shape.size), 0.0});
  }
}

void add_cylinder(const CollisionShape& shape, Sole* sole) {
  for (double end : {-0.5, 0.5}) {
    sole->rims.push_back({shape.X_LG * Vector3d(0, 0, end * shape.size.y()), shape.X_LG.R.col(2), shape.size.x()});
  }
}

void add_mesh(const CollisionShape& shape, Sole* sole) {
  std::vector<Vector3d> vertices = load_mesh(shape.mesh, shape.scale).vertices;
  for (Vector3d& v : vertices) v = shape.X_LG * v;
  for (const Vector3d& p : reduce_mesh(vertices)) sole->points.push_back({p, 0.0});
}

void update_reference(Sole* sole) {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity());
  Vector3d high = -low;
  for (const SolePoint& point : sole->points) {
    low = low.cwiseMin((point.p_LQ.array() - point.radius).matrix());
    high = high.cwiseMax((point.p_LQ.array() + point.radius).matrix());
  }
  for (const SoleRim& rim : sole->rims) {
    // Extent of a disc along an axis e: radius sqrt(1 - (axis . e)^2).
    const Vector3d extent = rim.radius * (1.0 - rim.axis_L.array().square()).max(0.0).sqrt().matrix();
    low = low.cwiseMin(rim.p_LQ - extent);
    high = high.cwiseMax(rim.p_LQ + extent);
  }
  sole->p_LR = {0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), low.z()};
}

void add_shape(const CollisionShape& shape, Sole* sole) {
  if (shape.kind == ShapeKind::kBox) add_box(shape, sole);
  if (shape.kind == ShapeKind::kSphere) sole->points.push_back({shape.X_LG.p, shape.size.x()});
  if (shape.kind == ShapeKind::kCylinder) add_cylinder(shape, sole);
  if (shape.kind == ShapeKind::kMesh) add_mesh(shape, sole);
}

bool is_empty(const Sole& sole) { return sole.points.empty() && sole.rims.empty(); }

Sole make_sole(const RobotDescription& robot, int link) {
  Sole sole;
  sole.link = link;
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.sole && shape.link == link) add_shape(shape, &sole);
  }
  if (!is_empty(sole)) update_reference(&sole);
  return sole;
}

Sole make_others(const RobotDescription& robot, int link) {
  Sole others;
  others.link = link;
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.sole || shape.link != link) continue;
    try {
      add_shape(shape, &others);
    } catch (const InputError&) {
    }
  }
  if (!is_empty(others)) update_reference(&others);
  return others;
}

// A sphere around all points: not the smallest one, but around the middle of the box that holds them.
void update_sphere(FallingLink* link) {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const auto visit = [&](const auto& work) {
    for (const SolePoint& point : link->others.points) work(point.p_LQ, point.radius);
    for (const SoleRim& rim : link->others.rims) work(rim.p_LQ, rim.radius);
  };
  visit([&](const Vector3d& p, double radius) {
    low = low.cwiseMin((p.array() - radius).matrix());
    high = high.cwiseMax((p.array() + radius).matrix());
  });
  link->p_LC = 0.5 * (low + high);
  visit([&](const Vector3d& p, double radius) {
    link->radius = std::max(link->radius, (p - link->p_LC).norm() + radius);
  });
}

}  // namespace

double calc_clearance(const Sole& sole, const Transform& X_WL, const GroundPlane& ground) {
  double clearance = std::numeric_limits<double>::infinity();
  for (const SolePoint& point : sole.points) {
    clearance = std::min(clearance, ground.n_W.dot(X_WL * point.p_LQ) - point.radius - ground.offset);
  }
  for (const SoleRim& rim : sole.rims) {
    Vector3d p_WQ[4];
    calc_rim_points(rim, X_WL, ground.n_W, p_WQ);
    clearance = std::min(clearance, ground.n_W.dot(p_WQ[0]) - ground.offset);
  }
  return clearance;
}

namespace {

// Smallest distance of the soles above the plane [m]; nothing to stand on: infinite.
double calc_clearance(const std::vector<Sole>& soles, const Data& data, const GroundPlane& ground) {
  double clearance = std::numeric_limits<double>::infinity();
  for (const Sole& sole : soles)
    clearance = std::min(clearance, calc_clearance(sole, get_pose(data, sole.link), ground));
  return clearance;
}

// The lowest points of a sole that stands upright, world axes.
std::vector<Vector3d> find_lowest_points(const Sole& sole, const Transform& X_WL) {
  std::vector<Vector3d> points;
  for (const SolePoint& point : sole.points) points.push_back(X_WL * point.p_LQ - point.radius * Vector3d::UnitZ());
  for (const SoleRim& rim : sole.rims) {
    Vector3d p_WQ[4];
    calc_rim_points(rim, X_WL, Vector3d::UnitZ(), p_WQ);
    points.insert(points.end(), p_WQ, p_WQ + 4);
  }
  return points;
}

// Height of a point above a triangle that faces up and that it is above or below of [m]; infinite for others.
double calc_drop(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  const auto is_left = [&](const Vector3d& u, const Vector3d& v) {
    return (v.x() - u.x()) * (p.y() - u.y()) - (v.y() - u.y()) * (p.x() - u.x()) >= 0.0;
  };
  if (!(n.z() > 0.0) || !is_left(a, b) || !is_left(b, c) || !is_left(c, a))
    return std::numeric_limits<double>::infinity();
  return n.dot(p - a) / n.z();
}

// Smallest vertical distance of the soles' points above the surfaces [m]; infinite over none.
double calc_drop(const RobotDescription& robot, const Scenario& scenario, const std::vector<Sole>& soles,
                 const Data& data) {
  double drop = std::numeric_limits<double>::infinity();
  for (const auto& surface : robot.surfaces) {
    const auto spec = std::find_if(scenario.obstacles.begin(), scenario.obstacles.end(),
                                   [&](const ObstacleSpec& o) { return o.name == surface->obstacle; });
    if (spec == scenario.obstacles.end()) continue;
    Mesh mesh = make_triangles(*surface);
    for (Vector3d& v : mesh.vertices) v = spec->X_WG * v;
    for (const Sole& sole : soles) {
      for (const Vector3d& p : find_lowest_points(sole, get_pose(data, sole.link))) {
        for (const auto& t : mesh.triangles) {
          drop = std::min(drop, calc_drop(p, mesh.vertices[size_t(t[0])], mesh.vertices[size_t(t[1])],
                                          mesh.vertices[size_t(t[2])]));
        }
      }
    }
  }
  return drop;
}

}  // namespace

Sole make_shape_parts(const CollisionShape& shape) {
  Sole parts;
  parts.link = shape.link;
  add_shape(shape, &parts);
  return parts;
}

std::vector<Sole> make_soles(const RobotDescription& robot) {
  std::vector<Sole> soles;
  for (size_t link = 0; link < robot.tree.links.size(); ++link) {
    const Sole sole = make_sole(robot, static_cast<int>(link));
    if (!is_empty(sole)) soles.push_back(sole);
  }
  return soles;
}

std::vector<FallingLink> make_falling_links(const RobotDescription& robot) {
  std::vector<FallingLink> links;
  for (size_t i = 0; i < robot.tree.links.size(); ++i) {
    FallingLink link;
    link.others = make_others(robot, static_cast<int>(i));
    if (is_empty(link.others)) continue;
    update_sphere(&link);
    link.whole = make_sole(robot, static_cast<int>(i));
    if (is_empty(link.whole)) {
      link.whole = link.others;
    } else {
      link.whole.points.insert(link.whole.points.end(), link.others.points.begin(), link.others.points.end());
      link.whole.rims.insert(link.whole.rims.end(), link.others.rims.begin(), link.others.rims.end());
    }
    links.push_back(link);
  }
  return links;
}

void calc_rim_points(const SoleRim& rim, const Transform& X_WL, const Vector3d& n_W, Vector3d p_WQ[4]) {
  const Vector3d axis_W = X_WL.R * rim.axis_L;
  Vector3d down = axis_W * axis_W.dot(n_W) - n_W;  // steepest descent in the plane of the rim
  const double length = down.norm();
  // Flat on the ground no direction is lowest: any will do, fixed to the link so that it does not wander.
  down = length > 1e-9 ? Vector3d(down / length) : Vector3d(X_WL.R * rim.axis_L.unitOrthogonal());
  const Vector3d side = axis_W.cross(down);
  const Vector3d center = X_WL * rim.p_LQ;
  p_WQ[0] = center + rim.radius * down;
  p_WQ[1] = center + rim.radius * side;
  p_WQ[2] = center - rim.radius * down;
  p_WQ[3] = center - rim.radius * side;
}

State make_start_state(const RobotDescription& robot, const Scenario& scenario) {
  const Model model(robot.tree, scenario.gravity_W);
  State state = make_state(model);
  state.R_WB = Eigen::Quaterniond(make_rotation_from_rpy(scenario.initial_rpy)).normalized();
  state.p_WB = scenario.initial_position;
  for (const auto& [name, value] : scenario.initial_joints) {
    const int joint = robot.tree.find_joint(name);
    if (joint >= 0) state.q[joint] = value;
  }
  for (int i = 0; i < robot.tree.num_joints(); ++i) {
    const MimicSpec& mimic = robot.tree.joint(i).mimic;
    if (mimic.joint >= 0) state.q[i] = mimic.multiplier * state.q[mimic.joint] + mimic.offset;
  }
  if (!robot.tree.floating_base || scenario.initial_height_given) return state;
  if (!scenario.ground.present && robot.surfaces.empty()) return state;
  Data data(model);
  update_kinematics(model, state, &data);
  const std::vector<Sole> soles = make_soles(robot);
  double drop = calc_drop(robot, scenario, soles, data);
  if (scenario.ground.present) {
    const GroundPlane ground = make_ground_plane(scenario.ground);
    // Moving by dz along z moves every point by n_z dz along the normal.
    drop = std::min(drop, calc_clearance(soles, data, ground) / ground.n_W.z());
  }
  if (std::isfinite(drop)) state.p_WB.z() -= drop;
  return state;
}

}  // namespace hrp
