// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/shared_files.h"

#include <filesystem>

namespace hrp {
namespace {

namespace fs = std::filesystem;

// .../bin/program -> .../share
fs::path find_share() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path().parent_path() / "share";
}

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

}  // namespace

std::string find_shared_file(const std::string& name) {
  const fs::path installed = find_share() / "openhrp_dds" / name, built = find_share() / name;
  return (!is_there(installed) && is_there(built) ? built : installed).string();
}

std::string find_scenario_file(const std::string& word) {
  if (is_there(word) || fs::path(word).is_absolute()) return word;
  for (const char* ending : {"", ".yaml"}) {
    std::string installed = find_shared_file("models/scenarios/" + word + ending);
    std::error_code error;
    if (fs::is_regular_file(installed, error)) return installed;
  }
  return word;
}

}  // namespace hrp
