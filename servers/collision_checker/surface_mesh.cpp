// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace hrp {
namespace {

// Bends below this are flat [rad]: 0.1 mm on a metre. Vertices of mesh files are single precision.
constexpr double kFlatBend = 1e-4;
// [m] A step of 1 ms at 10 m/s is a tenth of it; a thinner wall than twice this still turns bodies away.
constexpr double kDeepestInMesh = 0.1;

Face make_face(const std::vector<Vector3d>& vertices, const std::array<int, 3>& triangle) {
  Face face;
  face.corners = triangle;
  const Vector3d &a = vertices[size_t(triangle[0])], &b = vertices[size_t(triangle[1])],
                 &c = vertices[size_t(triangle[2])];
  face.n = (b - a).cross(c - a).normalized();
  face.m = {(b - a).cross(face.n).normalized(), (c - b).cross(face.n).normalized(), (a - c).cross(face.n).normalized()};
  return face;
}

}  // namespace

SurfaceMesh::SurfaceMesh(const Surface& surface)
    : columns_(surface.columns),
      rows_(surface.rows),
      spacing_(surface.spacing),
      deepest_(surface.is_grid() ? std::numeric_limits<double>::infinity() : kDeepestInMesh) {
  Mesh mesh = make_triangles(surface);
  if (!surface.is_grid()) tree_ = narrow_.add_mesh(mesh);
  vertices_ = std::move(mesh.vertices);
  low_ = high_ = vertices_.front();
  for (const Vector3d& v : vertices_) {
    low_ = low_.cwiseMin(v);
    high_ = high_.cwiseMax(v);
  }
  faces_.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) faces_.push_back(make_face(vertices_, triangle));
  link_neighbours();
  classify_edges();
}

// Two triangles are neighbours when one has an edge from u to v and the other from v to u. A third one has a border
// there.
void SurfaceMesh::link_neighbours() {
  std::unordered_map<unsigned long long, int> open;  // 3 face + edge, by the edge's vertices
  open.reserve(faces_.size() * 3);
  const auto key = [](int u, int v) {
    return static_cast<unsigned long long>(u) << 32 | static_cast<unsigned long long>(v);
  };
  for (size_t i = 0; i < faces_.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int u = faces_[i].corners[size_t(k)], v = faces_[i].corners[size_t((k + 1) % 3)];
      const auto other = open.find(key(v, u));
      if (other == open.end()) {
        open.emplace(key(u, v), static_cast<int>(3 * i) + k);
        continue;
      }
      faces_[i].neighbours[size_t(k)] = other->second / 3;
      faces_[size_t(other->second / 3)].neighbours[size_t(other->second % 3)] = static_cast<int>(i);
      open.erase(other);
    }
  }
}

void SurfaceMesh::classify_edges() {
  for (Face& face : faces_) {
    for (size_t k = 0; k < 3; ++k) {
      if (face.neighbours[k] < 0) continue;
      // Seen along the edge, the neighbour's normal leans away over a ridge.
      const Vector3d& n = faces_[size_t(face.neighbours[k])].n;
      const double bend = std::atan2(n.dot(face.m[k]), n.dot(face.n));
      face.edges[k] = bend > kFlatBend ? EdgeKind::kRidge : bend < -kFlatBend ? EdgeKind::kValley : EdgeKind::kFlat;
    }
  }
}

int SurfaceMesh::add_query(const Vector3d& size) {
  if (tree_ < 0) return 0;
  CollisionShape box;
  box.size = size;
  return narrow_.add_shape(box);
}

void SurfaceMesh::find_in_grid(const Vector3d& low, const Vector3d& high, std::vector<int>* found) const {
  const auto cell = [&](double from_first, int count) {
    return static_cast<int>(std::floor(std::clamp(from_first / spacing_, 0.0, static_cast<double>(count - 2))));
  };
  const int left = cell(low.x() - low_.x(), columns_), right = cell(high.x() - low_.x(), columns_);
  const int top = cell(high_.y() - high.y(), rows_), bottom = cell(high_.y() - low.y(), rows_);
  for (int i = top; i <= bottom; ++i) {
    for (int j = left; j <= right; ++j) {
      const int first = 2 * (i * (columns_ - 1) + j);
      for (int f = first; f < first + 2; ++f) {
        const Face& face = faces_[size_t(f)];
        const double peak = std::max({get_corner(face, 0).z(), get_corner(face, 1).z(), get_corner(face, 2).z()});
        if (peak >= low.z()) found->push_back(f);
      }
    }
  }
}

void SurfaceMesh::find_faces(const QueryBox& box, std::vector<int>* found) {
  found->clear();
  const Vector3d reach = box.X_GB.R.cwiseAbs() * box.half;
  const Vector3d low = box.X_GB.p - reach, high = box.X_GB.p + reach;
  if (low.x() > high_.x() || low.y() > high_.y() || low.z() > high_.z() || high.x() < low_.x() || high.y() < low_.y())
    return;
  if (tree_ < 0) return find_in_grid(low, high, found);
  if (high.z() >= low_.z()) narrow_.find_triangles(tree_, box.shape, box.X_GB, found);
}

}  // namespace hrp
