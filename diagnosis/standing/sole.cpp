// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/sole.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include "common/robot/mesh.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kFlat = 0.015;  // [m] a shorter sole shows no tilt: it rolls
constexpr double kAbove = 0.01;  // [m] height of a bush above the sole, half that of a usual sole
constexpr int kRim = 8;          // points on a cylinder's rim

void add_box(const CollisionShape& shape, std::vector<Vector3d>* points) {
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    points->push_back(shape.X_LG * Vector3d(sign.cwiseProduct(shape.size)));
  }
}

void add_cylinder(const CollisionShape& shape, std::vector<Vector3d>* points) {
  for (int i = 0; i < kRim; ++i) {
    const double angle = 2 * M_PI * i / kRim, x = shape.size.x() * std::cos(angle),
                 y = shape.size.x() * std::sin(angle);
    for (const double z : {-0.5, 0.5}) points->push_back(shape.X_LG * Vector3d(x, y, z * shape.size.y()));
  }
}

// A missing mesh leaves the sole unknown; the model parser has reported it.
void add_mesh(const CollisionShape& shape, std::vector<Vector3d>* points) {
  try {
    for (const Vector3d& v : load_mesh(shape.mesh, shape.scale).vertices) points->push_back(shape.X_LG * v);
  } catch (const std::exception&) {
  }
}

std::vector<Vector3d> list_points(const std::vector<const CollisionShape*>& shapes) {
  std::vector<Vector3d> points;
  for (const CollisionShape* shape : shapes) {
    if (shape->kind == ShapeKind::kBox) add_box(*shape, &points);
    if (shape->kind == ShapeKind::kCylinder) add_cylinder(*shape, &points);
    if (shape->kind == ShapeKind::kMesh) add_mesh(*shape, &points);
    if (shape->kind == ShapeKind::kSphere) points.push_back(shape->X_LG.p - Vector3d(0, 0, shape->size.x()));
  }
  return points;
}

void set_ball(const Vector3d& center, double radius, StandFoot* foot) {
  foot->kind = SoleKind::kBall;
  foot->radius = radius;
  foot->bush = center;
}

}  // namespace

void read_sole(const RobotDescription& robot, StandFoot* foot) {
  std::vector<const CollisionShape*> shapes;
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.link == foot->link) shapes.push_back(&shape);
  }
  if (shapes.size() == 1 && shapes[0]->kind == ShapeKind::kSphere) {
    return set_ball(shapes[0]->X_LG.p, shapes[0]->size.x(), foot);
  }
  const std::vector<Vector3d> points = list_points(shapes);
  if (points.empty()) return;
  double lowest = points[0].z();
  for (const Vector3d& p : points) lowest = std::min(lowest, p.z());
  Vector3d low(1e9, 1e9, lowest), high(-1e9, -1e9, lowest);
  for (const Vector3d& p : points) {
    if (p.z() > lowest + kLevel) continue;
    low.head<2>() = low.head<2>().cwiseMin(p.head<2>()), high.head<2>() = high.head<2>().cwiseMax(p.head<2>());
  }
  const Vector3d size = high - low, center = 0.5 * (low + high);
  if (std::min(size.x(), size.y()) < kFlat) {
    // A round foot rolls about its centre.
    double width = 0;
    for (const Vector3d& p : points) width = std::max(width, (p - center).head<2>().norm());
    return set_ball(center + Vector3d(0, 0, width), width, foot);
  }
  foot->sole = center;
  foot->size = size;
  const bool one_box = shapes.size() == 1 && shapes[0]->kind == ShapeKind::kBox;
  foot->bush.z() = one_box ? shapes[0]->X_LG.p.z() : lowest + kAbove;
}

}  // namespace hrp::diagnosis::standing
