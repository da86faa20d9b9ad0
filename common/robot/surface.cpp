// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/surface.h"

#include <algorithm>
#include <cmath>

namespace hrp {
namespace {

std::string find_grid_fault(const Surface& surface) {
  const auto count = static_cast<long>(surface.columns) * surface.rows;
  if (surface.columns < 2 || surface.rows < 2) return "a height field needs two rows and two columns at least";
  if (count > kMostHeights) {
    return "has " + std::to_string(count) + " heights, expected " + std::to_string(kMostHeights) + " at most";
  }
  if (static_cast<long>(surface.heights.size()) != count)
    return "has another number of heights than rows times columns";
  if (!(surface.spacing > 0.0) || !std::isfinite(surface.spacing)) return "its spacing is no positive number";
  const bool finite =
      std::all_of(surface.heights.begin(), surface.heights.end(), [](double h) { return std::isfinite(h); });
  return finite ? "" : "has a height that is not finite";
}

std::string find_mesh_fault(const Mesh& mesh) {
  if (mesh.triangles.empty()) return "has no triangles";
  if (mesh.triangles.size() > static_cast<size_t>(kMostTriangles)) {
    return "has " + std::to_string(mesh.triangles.size()) + " triangles, expected " + std::to_string(kMostTriangles) +
           " at most";
  }
  for (const Vector3d& v : mesh.vertices) {
    if (!v.allFinite()) return "has a vertex that is not finite";
  }
  const auto count = static_cast<int>(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (const int index : triangle) {
      if (index < 0 || index >= count) return "has a triangle without a vertex";
    }
  }
  return "";
}

}  // namespace

std::string find_surface_fault(const Surface& surface) {
  return surface.is_grid() || surface.rows != 0 ? find_grid_fault(surface) : find_mesh_fault(surface.mesh);
}

Mesh make_triangles(const Surface& surface) {
  if (!surface.is_grid()) return surface.mesh;
  Mesh mesh;
  const double x = find_first_coordinate(surface.columns, surface.spacing);
  const double y = -find_first_coordinate(surface.rows, surface.spacing);
  const auto at = [&](int row, int column) { return row * surface.columns + column; };
  for (int i = 0; i < surface.rows; ++i) {
    for (int j = 0; j < surface.columns; ++j) {
      mesh.vertices.emplace_back(x + j * surface.spacing, y - i * surface.spacing, surface.heights[size_t(at(i, j))]);
    }
  }
  for (int i = 0; i + 1 < surface.rows; ++i) {
    for (int j = 0; j + 1 < surface.columns; ++j) {
      mesh.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j)});
      mesh.triangles.push_back({at(i + 1, j + 1), at(i, j + 1), at(i, j)});
    }
  }
  return mesh;
}

}  // namespace hrp
