// SPDX-License-Identifier: BSD-3-Clause
// Meshes of obstacles, soles and links: the first byte chooses .obj, .stl or .dae. Assimp itself is built without
// sanitizers.
#include <cstdlib>

#include "common/base/diagnostics.h"
#include "common/robot/mesh.h"
#include "common/robot/surface_file.h"
#include "tests/fuzz/fuzz.h"

namespace {

constexpr const char* kEndings[] = {".obj", ".stl", ".dae"};

void check_indices(const hrp::Mesh& mesh) {
  const int count = static_cast<int>(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (const int index : triangle) {
      if (index < 0 || index >= count) std::abort();
    }
  }
}

template <typename Read>
void try_reader(Read read) {
  try {
    read();
  } catch (const hrp::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  const hrp::test::MemoryFile file(data + 1, size - 1, kEndings[data[0] % 3]);
  hrp::ObstacleSpec obstacle;
  obstacle.shape = "mesh", obstacle.file = file.path();
  try_reader([&] { check_indices(hrp::load_surface(obstacle)->mesh); });
  try_reader([&] { check_indices(hrp::make_outward(hrp::load_mesh(file.path(), {-1e-3, 1e-3, 1e-3}))); });
  return 0;
}
