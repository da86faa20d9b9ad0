// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/read_file.h"

#include <array>
#include <filesystem>

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

constexpr uintmax_t kLargestFile = 64u << 20;  // [bytes]

[[noreturn]] void refuse_file(const std::string& path) {
  refuse_input(path, "cannot be read: there is no such file, or no permission");
}

}  // namespace

std::ifstream open_input(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse_file(path);
  return file;
}

std::string read_input(const std::string& path) {
  std::error_code error;
  std::ifstream file = open_input(path);
  if (!std::filesystem::is_regular_file(path, error)) refuse_file(path);
  if (std::filesystem::file_size(path, error) > kLargestFile) refuse_input(path, "is larger than 64 MB");
  return read_rest(file, path);
}

std::string read_rest(std::istream& file, const std::string& path) {
  std::string text;
  std::array<char, 65536> part;
  while (file.read(part.data(), part.size()) || file.gcount() > 0)
    text.append(part.data(), static_cast<size_t>(file.gcount()));
  check_end(file, path);
  return text;
}

void check_end(const std::istream& file, const std::string& path) {
  if (file.bad()) refuse_input(path, "cannot be read to its end: the disk reports an error");
}

}  // namespace hrp
