// SPDX-License-Identifier: BSD-3-Clause
// Every URDF that tests run on: robots of other people beside this repository (where present) and our own models.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "common/multibody/tree_spec.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/shared_files.h"
#include "tests/test_places.h"

namespace hrp::engines {

inline std::vector<std::string> find_urdfs() {
  const std::filesystem::path source = source_dir();
  std::vector<std::string> paths;
  for (const std::filesystem::path& folder : {source / ".." / "shared" / "robots", source / "models"}) {
    if (!std::filesystem::is_directory(folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.path().extension() == ".urdf") paths.push_back(entry.path().lexically_normal().string());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

inline std::string find_shared_robot(const std::string& relative) { return find_shared("robots/" + relative); }

inline TreeSpec load_tree(const std::string& urdf, bool floating, bool repair_inertias = true) {
  Scenario scenario;
  scenario.robot = urdf;
  scenario.floating_base = floating;
  scenario.repair_inertias = repair_inertias;
  return load_robot(scenario).tree;
}

}  // namespace hrp::engines
