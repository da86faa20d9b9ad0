// SPDX-License-Identifier: BSD-3-Clause
// Where pictures of cameras and scans of lidars come from: a live run, or a log.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hrp {

using PictureBytes = std::shared_ptr<const std::vector<uint8_t>>;

class PictureSource {
 public:
  virtual ~PictureSource() = default;
  // The type of a topic; empty when it holds no pictures.
  virtual std::string find_type(const std::string& topic) const = 0;
  // Number of the picture that a topic has at `time` [s]; another picture has another number. 0: there is none.
  virtual uint64_t find(const std::string& topic, double time) const = 0;
  // The encoded sample of a picture that was found; nullptr when it can no longer be had.
  virtual PictureBytes read(const std::string& topic, uint64_t number) = 0;
};

// By the name of a type, as DDS or as ROS 2 writes it.
bool is_image(const std::string& type);
// Images and scans: large, so never read before somebody looks.
bool is_picture(const std::string& type);
// Those and what belongs to them: what Foxglove is told of in the terms of ROS 2.
bool is_of_camera(const std::string& type);
// The same by the name of a topic of a live run: "rt/head/image_raw".
bool is_picture_topic(const std::string& topic);

}  // namespace hrp
