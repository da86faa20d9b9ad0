// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/read_file.h"

#include <array>

#include "common/base/diagnostics.h"

namespace hrp {

std::string read_rest(std::istream& file, const std::string& path) {
  std::string text;
  std::array<char, 65536> part;
  while (file.read(part.data(), part.size()) || file.gcount() > 0) text.append(part.data(), static_cast<size_t>(file.gcount()));
  check_end(file, path);
  return text;
}

void check_end(const std::istream& file, const std::string& path) {
  if (file.bad()) refuse_input(path, "cannot be read to its end: the disk reports an error");
}

}  // namespace hrp
