// SPDX-License-Identifier: BSD-3-Clause
// Fixed surfaces of the world: triangles of a mesh file, or a grid of heights.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/spatial/transform.h"

namespace hrp {

struct Mesh {
  std::vector<Vector3d> vertices;             // [m]
  std::vector<std::array<int, 3>> triangles;  // indices of vertices; counter-clockwise seen from outside
};

// What the file of an obstacle holds, in the obstacle's frame. Either triangles or a grid.
struct Surface {
  std::string obstacle;       // name in the scenario
  Mesh mesh;                  // empty for a grid
  int columns = 0, rows = 0;  // of a grid, 0 for a mesh
  double spacing = 0.0;       // [m] of neighbours of a grid
  // [m] row by row; columns along x, the first row at the largest y; the middle is the origin
  std::vector<double> heights;

  bool is_grid() const { return columns > 0; }
};

// Larger ones are refused: with these a message is a few MB.
constexpr int kMostHeights = 250000, kMostTriangles = 200000;

// Empty when the surface can be used, else why not.
std::string find_surface_fault(const Surface& surface);

// Number of columns or rows -> coordinate of the first one [m]; the grid's middle is at 0.
inline double find_first_coordinate(int count, double spacing) { return -0.5 * spacing * (count - 1); }

// Triangles of the surface. Each square of a grid becomes two; triangles 2 k and 2 k + 1 are those of square k, squares
// row by row.
Mesh make_triangles(const Surface& surface);

}  // namespace hrp
