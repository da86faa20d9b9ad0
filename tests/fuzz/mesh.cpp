// SPDX-License-Identifier: BSD-3-Clause
// Meshes of obstacles, soles and links: the first byte chooses .obj, .stl or .dae, and who reads it. Assimp itself is
// built without sanitizers.
#include <cstdlib>
#include <new>
#include <utility>

#include "common/base/diagnostics.h"
#include "common/robot/mesh.h"
#include "common/robot/surface_file.h"
#include "tests/fuzz/fuzz.h"

namespace {

constexpr const char* kEndings[] = {".obj", ".stl", ".dae"};

// Assimp fills a buffer of this size for each .obj, however short. A block that is new each time costs 4096 faults of
// pages, 50 times what the rest of an execution takes. So the buffer gets the same block each time.
constexpr size_t kObjBuffer = 4096 * 4096;
alignas(64) char obj_buffer[kObjBuffer];
bool obj_buffer_taken = false;

void release(void* block) {
  if (block == obj_buffer) {
    obj_buffer_taken = false;
  } else {
    std::free(block);
  }
}

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

// Memory of `new` is from malloc, so the address sanitizer still sees what is used beyond it or after its end.
void* operator new(size_t size, const std::nothrow_t&) noexcept {
  if (size == kObjBuffer && !std::exchange(obj_buffer_taken, true)) return obj_buffer;
  return std::malloc(size);
}
void* operator new(size_t size) {
  if (void* block = operator new(size, std::nothrow)) return block;
  throw std::bad_alloc();
}
void operator delete(void* block) noexcept { release(block); }
void operator delete(void* block, size_t) noexcept { release(block); }
void operator delete(void* block, const std::nothrow_t&) noexcept { release(block); }

// Assimp forgets the mesh (1400 bytes) of an .obj that it refuses for an index of no vertex. Leaks of ours are
// reported.
extern "C" const char* __lsan_default_suppressions() { return "leak:libassimp"; }

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  const hrp::test::MemoryFile file(data + 1, size - 1, kEndings[data[0] % 3]);
  hrp::ObstacleSpec obstacle;
  obstacle.shape = "mesh";
  obstacle.file = file.path();
  if (data[0] / 3 % 2 == 0) {
    try_reader([&] { check_indices(hrp::load_surface(obstacle)->mesh); });
  } else {
    try_reader([&] { check_indices(hrp::make_outward(hrp::load_mesh(file.path(), {-1e-3, 1e-3, 1e-3}))); });
  }
  return 0;
}
