// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/picture.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/messages/cdr.h"
#include "hrp_idl/ros_views.h"

namespace hrp {
namespace {

using Image = ::sensor_msgs::msg::dds_::Image_;
using PointCloud = ::sensor_msgs::msg::dds_::PointCloud2_;

constexpr uint8_t kFloat32 = 7;  // PointField's constant

struct Encoding {
  const char* name;
  uint32_t pixel_size;  // [bytes]
  Picture::Kind kind;
  std::array<size_t, 3> rgb;  // where red, green and blue stand in a pixel
};

constexpr Encoding kEncodings[] = {
    {"rgb8", 3, Picture::Kind::kColor, {0, 1, 2}},  {"bgr8", 3, Picture::Kind::kColor, {2, 1, 0}},
    {"rgba8", 4, Picture::Kind::kColor, {0, 1, 2}}, {"bgra8", 4, Picture::Kind::kColor, {2, 1, 0}},
    {"mono8", 1, Picture::Kind::kColor, {0, 0, 0}}, {"32FC1", 4, Picture::Kind::kDepth, {}},
    {"16UC1", 2, Picture::Kind::kDepth, {}}};

[[noreturn]] void refuse(const std::string& field, const std::string& value, const std::string& expected) {
  throw PictureError("the picture's " + field + " is " + value + ", expected " + expected);
}

const Encoding& find_encoding(const std::string& name) {
  std::string known;
  for (const Encoding& encoding : kEncodings) {
    if (name == encoding.name) return encoding;
    known += (known.empty() ? "" : ", ") + std::string(encoding.name);
  }
  refuse("encoding", "'" + name.substr(0, 40) + "'", "one of " + known);
}

void check_sizes(const Image& image, const Encoding& encoding) {
  if (image.width() == 0) refuse("width", "0", "at least 1 pixel");
  if (image.height() == 0) refuse("height", "0", "at least 1 pixel");
  const uint64_t row = uint64_t{encoding.pixel_size} * image.width();
  if (image.step() < row) {
    refuse("step", std::to_string(image.step()) + " bytes",
           "at least " + std::to_string(row) + ": " + std::to_string(image.width()) + " pixels of " + encoding.name);
  }
  const uint64_t size = uint64_t{image.step()} * image.height();
  if (image.data().size() != size) {
    refuse("data", std::to_string(image.data().size()) + " bytes", std::to_string(size) + ": height times step");
  }
  if (image.is_bigendian() && encoding.kind == Picture::Kind::kDepth) refuse("is_bigendian", "1", "0");
}

// The least n that leaves no more than `most` pixels.
uint32_t find_stride(const Image& image, uint64_t most) {
  const auto count = [](uint64_t size, uint64_t n) { return (size + n - 1) / n; };
  uint32_t stride = 1;
  while (count(image.width(), stride) * count(image.height(), stride) > most) ++stride;
  return stride;
}

// [m] of a pixel; 16UC1 has millimetres, and 0 where nothing is seen.
float read_depth(const uint8_t* pixel, uint32_t size) {
  float depth = 0.0f;
  if (size == sizeof depth) {
    std::memcpy(&depth, pixel, sizeof depth);
    return depth;
  }
  uint16_t millimetres = 0;
  std::memcpy(&millimetres, pixel, sizeof millimetres);
  return millimetres > 0 ? 1e-3f * static_cast<float>(millimetres) : std::numeric_limits<float>::infinity();
}

void add_pixel(const uint8_t* pixel, const Encoding& encoding, std::string* out) {
  if (encoding.kind == Picture::Kind::kColor) {
    for (const size_t at : encoding.rgb) out->push_back(static_cast<char>(pixel[at]));
    return;
  }
  const float depth = read_depth(pixel, encoding.pixel_size);
  out->append(reinterpret_cast<const char*>(&depth), sizeof depth);
}

template <typename Message>
Message decode_sample(Bytes sample) {
  Message message;
  try {
    decode(sample, &message);
  } catch (const DecodeError& error) {
    throw PictureError(error.what());
  }
  return message;
}

template <typename Message>
double find_time(const Message& message) {
  return message.header().stamp().sec() + 1e-9 * message.header().stamp().nanosec();
}

// [bytes] from the begin of a point.
size_t find_offset(const PointCloud& scan, const std::string& name) {
  for (const auto& field : scan.fields()) {
    if (field.name() != name) continue;
    if (field.datatype() != kFloat32) refuse("datatype of " + name, std::to_string(field.datatype()), "7: FLOAT32");
    if (uint64_t{field.offset()} + sizeof(float) > scan.point_step()) {
      refuse("point_step", std::to_string(scan.point_step()) + " bytes",
             "at least " + std::to_string(uint64_t{field.offset()} + sizeof(float)) + ": the end of " + name);
    }
    return field.offset();
  }
  refuse("list of fields", "without " + name, "x, y and z");
}

void check_sizes(const PointCloud& scan) {
  const uint64_t row = uint64_t{scan.point_step()} * scan.width();
  if (scan.row_step() < row)
    refuse("row_step", std::to_string(scan.row_step()) + " bytes",
           "at least " + std::to_string(row) + ": width times point_step");
  const uint64_t size = uint64_t{scan.row_step()} * scan.height();
  if (scan.data().size() != size)
    refuse("data", std::to_string(scan.data().size()) + " bytes", std::to_string(size) + ": height times row_step");
  if (scan.is_bigendian()) refuse("is_bigendian", "true", "false");
}

}  // namespace

Picture read_picture(Bytes sample, uint64_t most_pixels) {
  const auto image = decode_sample<Image>(sample);
  const Encoding& encoding = find_encoding(image.encoding());
  check_sizes(image, encoding);
  Picture picture;
  picture.kind = encoding.kind;
  picture.time = find_time(image);
  picture.stride = find_stride(image, most_pixels);
  picture.width = (image.width() + picture.stride - 1) / picture.stride;
  picture.height = (image.height() + picture.stride - 1) / picture.stride;
  picture.pixels.reserve(size_t{4} * picture.width * picture.height);
  for (size_t y = 0; y < image.height(); y += picture.stride) {
    const uint8_t* row = image.data().data() + y * image.step();
    for (size_t x = 0; x < image.width(); x += picture.stride)
      add_pixel(row + x * encoding.pixel_size, encoding, &picture.pixels);
  }
  return picture;
}

Picture read_scan(Bytes sample, uint64_t most_points) {
  const auto scan = decode_sample<PointCloud>(sample);
  check_sizes(scan);
  const size_t offsets[] = {find_offset(scan, "x"), find_offset(scan, "y"), find_offset(scan, "z")};
  const uint64_t count = uint64_t{scan.width()} * scan.height();
  Picture picture;
  picture.kind = Picture::Kind::kPoints;
  picture.time = find_time(scan);
  picture.height = 1;
  picture.stride = static_cast<uint32_t>(count / most_points + (count % most_points > 0 ? 1 : 0));
  for (uint64_t i = 0; i < count; i += picture.stride) {
    const uint8_t* point =
        scan.data().data() + i / scan.width() * scan.row_step() + i % scan.width() * scan.point_step();
    float xyz[3];
    for (int k = 0; k < 3; ++k) std::memcpy(&xyz[k], point + offsets[k], sizeof(float));
    if (!std::isfinite(xyz[0]) || !std::isfinite(xyz[1]) || !std::isfinite(xyz[2])) continue;
    picture.pixels.append(reinterpret_cast<const char*>(xyz), sizeof xyz);
    ++picture.width;
  }
  return picture;
}

}  // namespace hrp
