// SPDX-License-Identifier: BSD-3-Clause
// Convex solids as SVG: parallel projection, far ones drawn first, faces shaded by one light.
#pragma once

#include <string>
#include <vector>

#include "common/robot/robot_description.h"

namespace hrp {

struct Colour {
  double red = 0.8, green = 0.8, blue = 0.8;  // 0 to 1
};

// World axes. Without faces only the outline is drawn.
struct Solid {
  std::vector<Vector3d> vertices;       // [m]
  std::vector<std::vector<int>> faces;  // indices of vertices, counter-clockwise seen from outside
  Colour colour;
};

// Where the picture is seen from.
struct Camera {
  double azimuth = -1.05;                 // [rad] direction in which the camera stands, from world x towards y
  double elevation = 0.2;                 // [rad] of the camera over the horizon
  double scale = 100.0;                   // pixels a metre
  Vector3d target_W = Vector3d::Zero();   // [m] is drawn at the middle of the picture
  double middle_x = 0.0, middle_y = 0.0;  // pixels

  Vector3d calc_direction() const;                     // unit vector from the target to the camera
  Eigen::Vector2d project(const Vector3d& p_W) const;  // pixels, y downward
};

// In the shape's own frame; meshes become the outermost of their vertices along many directions.
Solid make_solid(const CollisionShape& shape);
Solid move_solid(const Transform& X_WG, Solid solid);
Vector3d calc_middle(const Solid& solid);  // of its vertices

// The convex hull of points, counter-clockwise in a frame with y upward.
std::vector<Eigen::Vector2d> find_outline(std::vector<Eigen::Vector2d> points);
std::string make_points(const std::vector<Eigen::Vector2d>& outline);

// Solids in the order in which they must be drawn: those behind others first. Exact where a face's plane separates two
// solids; where they overlap, the face in which the other one sits least deep decides.
std::vector<size_t> find_drawing_order(const std::vector<Solid>& solids, const Camera& camera);

std::string draw_solids(const std::vector<Solid>& solids, const Camera& camera);

}  // namespace hrp
