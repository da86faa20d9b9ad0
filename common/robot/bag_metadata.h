// SPDX-License-Identifier: BSD-3-Clause
// metadata.yaml of a ROS 2 bag, as far as reading needs it.
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct BagMetadata {
  std::string storage;             // "mcap", "sqlite3"
  std::vector<std::string> files;  // relative to the folder
  std::string compression_mode;    // "", "file", "message"
  std::string compression_format;  // "", "zstd"
};

// Throws InputError with file, line, column.
BagMetadata read_bag_metadata(const std::string& path);

}  // namespace hrp
