// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/bag_metadata.h"

#include <algorithm>
#include <cctype>

#include "common/robot/yaml_map.h"

namespace hrp {
namespace {

std::string read_word(const YAML::Node& node) {
  std::string word = node && node.IsScalar() ? node.as<std::string>() : "";
  // Older versions write "NONE" or "FILE".
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  return word == "none" ? "" : word;
}

}  // namespace

BagMetadata read_bag_metadata(const std::string& path) {
  BagMetadata out;
  try {
    const YAML::Node root = YAML::LoadFile(path);
    const YAML::Node info = root["rosbag2_bagfile_information"];
    if (!info || !info.IsMap())
      refuse_input(make_place(path, root.Mark(), "rosbag2_bagfile_information"),
                   "is missing: no metadata of a ROS 2 bag");
    out.storage = read_word(info["storage_identifier"]);
    out.compression_mode = read_word(info["compression_mode"]);
    out.compression_format = read_word(info["compression_format"]);
    const YAML::Node files = info["relative_file_paths"];
    if (!files || !files.IsSequence() || files.size() == 0)
      refuse_input(make_place(path, info.Mark(), "relative_file_paths"), "is missing: expected the bag's files");
    for (const YAML::Node& file : files) out.files.push_back(file.as<std::string>());
  } catch (const YAML::Exception& error) {
    refuse_input(make_place(path, error.mark), "not usable YAML: " + error.msg);
  }
  return out;
}

}  // namespace hrp
