// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/mesh.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <filesystem>
#include <fstream>

#include "common/base/diagnostics.h"
#include "common/base/file_ending.h"
#include "common/base/read_file.h"
#include "common/robot/collada_nodes.h"

namespace hrp {
namespace {

void append_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent, const Vector3d& scale,
                 Mesh* mesh) {
  const aiMatrix4x4 X = parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[i]];
    const int first = static_cast<int>(mesh->vertices.size());
    for (unsigned k = 0; k < part.mNumVertices; ++k) {
      const aiVector3D v = X * part.mVertices[k];
      mesh->vertices.push_back(Vector3d(v.x, v.y, v.z).cwiseProduct(scale));
    }
    for (unsigned k = 0; k < part.mNumFaces; ++k) {
      const aiFace& face = part.mFaces[k];
      if (face.mNumIndices != 3) continue;  // points and lines
      mesh->triangles.push_back({first + static_cast<int>(face.mIndices[0]), first + static_cast<int>(face.mIndices[1]),
                                 first + static_cast<int>(face.mIndices[2])});
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) append_node(scene, *node.mChildren[i], X, scale, mesh);
}

// Assimp reads COLLADA under every ending but those of its other formats, and in an archive.
void check_collada(const std::string& path) {
  const std::string ending = find_ending(path);
  if (ending == ".zae") refuse_input(path, "is packed: expected the .dae that it contains");
  std::error_code error;
  if (ending == ".obj" || ending == ".stl" || !std::filesystem::is_regular_file(path, error))
    return;  // Assimp says what is wrong
  std::ifstream file = open_input(path);
  const std::string text = read_rest(file, path);
  if (text.find("<COLLADA") == std::string::npos) return;
  for (const std::string& fault : {find_node_fault(text), find_number_fault(text)}) {
    if (!fault.empty()) refuse_input(path, fault);
  }
}

}  // namespace

Mesh load_mesh(const std::string& path, const Vector3d& scale) {
  check_collada(path);
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr)
    refuse_input(path, std::string("is no mesh: ") + importer.GetErrorString());
  Mesh mesh;
  append_node(*scene, *scene->mRootNode, aiMatrix4x4(), scale, &mesh);
  for (const Vector3d& vertex : mesh.vertices) {
    if (!vertex.allFinite()) refuse_input(path, "has a vertex that is not finite");
  }
  if (mesh.triangles.empty()) refuse_input(path, "has no triangles");
  return mesh;
}

}  // namespace hrp
