// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "tests/test_places.h"

namespace hrp {

// A file or folder of other people beside this repository, such as "robots/sr1/SR1.urdf"; empty when it is not there.
inline std::string find_shared(const std::string& relative) {
  const std::filesystem::path path = std::filesystem::path(source_dir()) / ".." / "shared" / relative;
  return std::filesystem::exists(path) ? path.lexically_normal().string() : "";
}

}  // namespace hrp
