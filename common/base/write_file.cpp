// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/write_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

}  // namespace

void write_file(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  errno = 0;
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (file && std::rename(part.c_str(), path.c_str()) == 0) return;
  const std::string reason = errno == 0 ? "the disk reports no reason" : std::strerror(errno);
  std::remove(part.c_str());
  throw std::runtime_error(path + ": cannot be written: " + reason);
}

void prepare_folder(const std::string& folder, size_t bytes) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) refuse_input(folder, "cannot be made: " + error.message() + "; expected a folder for results");
  const std::string trial = (fs::path(folder) / ".trial").string();
  try {
    write_file(trial, std::string(bytes, '\0'));
  } catch (const std::runtime_error& failure) {
    refuse_input(folder, std::string("nothing can be written in it: ") + failure.what());
  }
  std::remove(trial.c_str());
}

bool finish_output(const char* program) {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return true;
  std::fprintf(stderr, "%s: standard output cannot be written: %s\n", program,
               errno == 0 ? "an earlier write failed" : std::strerror(errno));
  return false;
}

}  // namespace hrp
