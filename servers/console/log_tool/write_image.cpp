// SPDX-License-Identifier: BSD-3-Clause
// A camera's picture in a log as a PNG image.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "common/messages/picture.h"
#include "common/robot/image_file.h"
#include "servers/console/log_tool/commands.h"
#include "servers/console/log_tool/log_file.h"

namespace hrp {
namespace {

constexpr double kSameTime = 1e-6;  // [s]

// Millimetres, as 16UC1 of ROS has them: 0 where nothing is seen, at most 65.535 m.
std::vector<uint16_t> make_millimetres(const std::string& depths) {
  std::vector<uint16_t> values;
  for (size_t at = 0; at + sizeof(float) <= depths.size(); at += sizeof(float)) {
    float depth = 0.0f;
    std::memcpy(&depth, &depths[at], sizeof depth);
    values.push_back(
        std::isfinite(depth) ? static_cast<uint16_t>(std::lround(std::clamp(1000.0f * depth, 0.0f, 65535.0f))) : 0);
  }
  return values;
}

void write(const Picture& picture, const std::string& out) {
  const int width = static_cast<int>(picture.width), height = static_cast<int>(picture.height);
  if (picture.kind == Picture::Kind::kDepth)
    return write_grey_png(out, width, height, make_millimetres(picture.pixels));
  write_color_png(out, width, height, {picture.pixels.begin(), picture.pixels.end()});
}

}  // namespace

int write_image(const ImageOptions& options) {
  LogFile log(options.file);
  const LogTopicType& topic = log.find_topic(options.topic);
  if (topic.type == nullptr || topic.type->name != "sensor_msgs::msg::dds_::Image_")
    throw std::runtime_error(topic.topic + " has no images");
  bool found = false;
  log.reader().read_messages(
      [&](const mcap::Message& message) {
        const double time = static_cast<double>(message.log_time) * 1e-9;
        if (time < options.at - kSameTime) return true;
        const Picture picture = read_picture(get_bytes(message));
        write(picture, options.out);
        std::printf("%s: %s at %.9g s, %u x %u\n", options.out.c_str(), topic.topic.c_str(), time, picture.width,
                    picture.height);
        found = true;
        return false;
      },
      {topic.topic});
  if (found) return 0;
  throw std::runtime_error(options.file + ": " + topic.topic + " has no image at or after " +
                           std::to_string(options.at) + " s");
}

}  // namespace hrp
