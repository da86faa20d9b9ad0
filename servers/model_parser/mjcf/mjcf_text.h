// SPDX-License-Identifier: BSD-3-Clause
// What MuJoCo's compiled model does not tell and the text does: lines of elements, files of meshes.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "common/spatial/transform.h"

namespace hrp {

struct MjcfMesh {
  std::string file;  // as find_mesh() takes it
  Vector3d scale = Vector3d::Ones();
};

struct MjcfText {
  // Line of the first element of this kind and name ("joint", "knee"); 0 when there is none in the file itself.
  int find_line(const std::string& kind, const std::string& name) const;

  std::map<std::pair<std::string, std::string>, int> lines;
  std::map<std::string, MjcfMesh> meshes;  // by name; those whose place in the file cannot be told are left out
  // The same text with a small sphere in the place of each mesh. The compiler moves meshes to their centres of mass and
  // turns them to their principal axes; spheres stay where the file has them.
  std::string with_spheres;
};

MjcfText read_mjcf_text(const std::string& text);

}  // namespace hrp
