// SPDX-License-Identifier: BSD-3-Clause
// Pictures of the robots at moments of a recorded run, beside each other, as SVG.
#pragma once

#include <string>

namespace hrp {

struct PictureOptions {
  double from = 0.0, to = -1.0;  // [s] first and last moment; to < 0: the end of the log
  int count = 8;                 // pictures, evenly spaced in time
  double azimuth = -1.05;        // [rad] where the camera stands: from the front, towards the left
  double elevation = 0.2;        // [rad]
  std::string robot;             // that the camera follows; empty: the first one
};

// Only soles touch the ground in a run, so a robot that has fallen sinks into it: the pictures end where any other part
// of it reaches the ground. Throws mcap::McapError for a file that is no log, std::runtime_error for a log without what
// is needed or an output that cannot be written.
void write_robot_pictures(const std::string& log_path, const PictureOptions& options, const std::string& svg_path);

}  // namespace hrp
