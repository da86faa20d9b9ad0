// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/mesh_path.h"

#include <filesystem>

namespace hrp {
namespace {

namespace fs = std::filesystem;

std::string accept_file(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return "";
  const fs::path absolute = fs::absolute(path, error);
  return (error ? path : absolute).lexically_normal().string();
}

// First of the folders from `folder` upward that has `name`.
std::string search_upward(fs::path folder, const fs::path& name) {
  for (int depth = 0; depth < 64; ++depth) {
    std::string found = accept_file(folder / name);
    if (!found.empty()) return found;
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return "";
}

std::string remove_prefix(const std::string& name, const std::string& prefix) {
  return name.rfind(prefix, 0) == 0 ? name.substr(prefix.size()) : name;
}

}  // namespace

std::string find_mesh(const std::string& name, const std::string& urdf_path) {
  std::error_code error;
  const fs::path folder = fs::absolute(urdf_path, error).parent_path();
  const std::string in_package = remove_prefix(name, "package://");
  if (in_package == name) return accept_file(folder / fs::path(remove_prefix(name, "file://")));
  std::string found = search_upward(folder, in_package);
  if (!found.empty()) return found;
  const size_t slash = in_package.find('/');
  return slash == std::string::npos ? "" : search_upward(folder, in_package.substr(slash + 1));
}

}  // namespace hrp
