// SPDX-License-Identifier: BSD-3-Clause
// What hrp-log can do with a log. Each returns an exit code and throws InputError or mcap::McapError for bad input.
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct CatOptions {
  std::string file, topic, field;
  bool json = false;
  double from = 0.0, to = -1.0;  // [s] to < 0: until the end
};

struct ImageOptions {
  std::string file, topic, out;
  double at = 0.0;  // [s] the first one at or after this simulated time
};

struct ConvertOptions {
  std::string file, out;
  double rate = 100.0;  // [Hz] samples a second of simulated time, 0: every one
  bool force = false;
};

int show_info(const std::string& file);
int show_messages(const CatOptions& options);
int write_image(const ImageOptions& options);
int write_csv(const std::string& file, const std::string& out);
int write_plot(const std::string& file, const std::vector<std::string>& signals, const std::string& out);
int show_hashes(const std::string& file);
// Pushes that people gave live, as the section `pushes` of a scenario.
int show_pushes(const std::string& file);
// 0 when every payload is the same, 1 with the first difference by topic, step and field.
int compare_logs(const std::string& one, const std::string& other);
// Writes what can be read of a damaged log into a whole one. Nothing readable is an error, and leaves no file.
int recover_log(const std::string& in, const std::string& out, bool force);

// For other people's viewers (docs/tutorials/foxglove.md, docs/tutorials/ros2.md).
int write_foxglove(const ConvertOptions& options);
int write_rosbag(const ConvertOptions& options);

// Throws InputError when writing `out` would destroy the input, or, without `force`, any log.
void check_output(const std::string& in, const std::string& out, bool force);

}  // namespace hrp
