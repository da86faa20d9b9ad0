// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/narrow_phase.h"

#include <algorithm>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include "common/robot/mesh.h"

namespace hrp {
namespace {

using MeshModel = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<fcl::CollisionGeometryd> make_mesh(const Mesh& mesh) {
  auto model = std::make_shared<MeshModel>();
  model->beginModel(static_cast<int>(mesh.triangles.size()), static_cast<int>(mesh.vertices.size()));
  for (const auto& t : mesh.triangles) {
    model->addTriangle(mesh.vertices[size_t(t[0])], mesh.vertices[size_t(t[1])], mesh.vertices[size_t(t[2])]);
  }
  model->endModel();
  return model;
}

std::shared_ptr<fcl::CollisionGeometryd> make_geometry(const CollisionShape& shape) {
  if (shape.kind == ShapeKind::kBox) return std::make_shared<fcl::Boxd>(shape.size);
  if (shape.kind == ShapeKind::kSphere) return std::make_shared<fcl::Sphered>(std::max(shape.size.x(), 1e-4));
  if (shape.kind == ShapeKind::kCylinder) return std::make_shared<fcl::Cylinderd>(shape.size.x(), shape.size.y());
  return make_mesh(load_mesh(shape.mesh, shape.scale));
}

fcl::Transform3d make_fcl(const Transform& X) {
  fcl::Transform3d T = fcl::Transform3d::Identity();
  T.linear() = X.R;
  T.translation() = X.p;
  return T;
}

}  // namespace

struct NarrowPhase::Impl {
  std::vector<std::shared_ptr<fcl::CollisionGeometryd>> shapes;
  std::vector<char> is_mesh;
  std::vector<Vector3d> centers;
  std::vector<double> radii;
  fcl::CollisionResultd result;
  std::vector<fcl::Contactd> contacts;

  int add(std::shared_ptr<fcl::CollisionGeometryd> geometry, bool mesh) {
    geometry->computeLocalAABB();
    centers.push_back(geometry->aabb_center);
    radii.push_back(geometry->aabb_radius);
    is_mesh.push_back(mesh ? 1 : 0);
    shapes.push_back(std::move(geometry));
    return static_cast<int>(shapes.size()) - 1;
  }
};

NarrowPhase::NarrowPhase() : impl_(std::make_unique<Impl>()) {}
NarrowPhase::~NarrowPhase() = default;

int NarrowPhase::add_shape(const CollisionShape& shape) {
  return impl_->add(make_geometry(shape), shape.kind == ShapeKind::kMesh);
}

int NarrowPhase::add_mesh(const Mesh& mesh) { return impl_->add(make_mesh(mesh), true); }

const Vector3d& NarrowPhase::get_center(int shape) const { return impl_->centers[size_t(shape)]; }
double NarrowPhase::get_radius(int shape) const { return impl_->radii[size_t(shape)]; }

void NarrowPhase::calc_contacts(int a, const Transform& X_WA, int b, const Transform& X_WB, int max_points,
                                std::vector<ContactPoint>* points) {
  const bool mesh = impl_->is_mesh[size_t(a)] || impl_->is_mesh[size_t(b)];
  fcl::CollisionRequestd request(mesh ? size_t(1) : size_t(std::max(max_points, 8)), true);
  impl_->result.clear();
  fcl::collide(impl_->shapes[size_t(a)].get(), make_fcl(X_WA), impl_->shapes[size_t(b)].get(), make_fcl(X_WB), request,
               impl_->result);
  impl_->contacts.clear();
  impl_->result.getContacts(impl_->contacts);
  for (const fcl::Contactd& contact : impl_->contacts) {
    // FCL's normal points from its first body to its second: from A to B. A few degenerate poses give none or NaN.
    const double length = contact.normal.norm();
    if (!(length > 0.5) || !contact.pos.allFinite() || !(contact.penetration_depth > 0.0)) continue;
    points->push_back({contact.pos, -contact.normal / length, contact.penetration_depth});
  }
}

void NarrowPhase::find_triangles(int a, int b, const Transform& X_AB, std::vector<int>* found) {
  const fcl::CollisionRequestd request(size_t(kMostTriangles), false);
  impl_->result.clear();
  fcl::collide(impl_->shapes[size_t(a)].get(), fcl::Transform3d::Identity(), impl_->shapes[size_t(b)].get(),
               make_fcl(X_AB), request, impl_->result);
  for (size_t i = 0; i < impl_->result.numContacts(); ++i)
    found->push_back(static_cast<int>(impl_->result.getContact(i).b1));
}

bool NarrowPhase::overlaps(int a, const Transform& X_WA, int b, const Transform& X_WB) {
  fcl::CollisionRequestd request(1, false);
  impl_->result.clear();
  return fcl::collide(impl_->shapes[size_t(a)].get(), make_fcl(X_WA), impl_->shapes[size_t(b)].get(), make_fcl(X_WB),
                      request, impl_->result) > 0;
}

}  // namespace hrp
