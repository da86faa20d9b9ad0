// SPDX-License-Identifier: BSD-3-Clause
// Files of surfaces: meshes, and heights as text or image.
#pragma once

#include <memory>
#include <string>

#include "common/robot/scenario.h"
#include "common/robot/surface.h"

namespace hrp {

// The surface of an obstacle whose is_surface() holds. Throws InputError naming the file and what is wrong with it.
std::shared_ptr<const Surface> load_surface(const ObstacleSpec& obstacle);

// Values of a grid as a file has them, row by row.
struct HeightTable {
  int columns = 0, rows = 0;
  std::vector<double> values;
  double white = 0.0;  // largest value that a pixel can have; 0 where the values are metres
};

// Lines of numbers, parted by commas, semicolons or blanks; lines with # are comments.
HeightTable parse_height_text(const std::string& text, const std::string& path);
// PGM, plain (P2) and binary (P5), 8 and 16 bits.
HeightTable parse_pgm(const std::string& text, const std::string& path);
// PNG, grey, up to 16 bits; an alpha channel is left out.
HeightTable read_png(const std::string& path);

// Vertices at the same place become one; triangles without area are left out.
Mesh weld(const Mesh& mesh);
// Welded, with all triangles turned round if they face inward, as those of a mirrored mesh do.
Mesh make_outward(const Mesh& mesh);

}  // namespace hrp
