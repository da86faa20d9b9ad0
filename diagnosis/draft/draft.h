// SPDX-License-Identifier: BSD-3-Clause
// A first experiment.yaml from a robot's model and its logs, to be looked at by a person: which column holds which
// signal is guessed from names and numbers, and what cannot be guessed is asked for in comments.
#pragma once

#include <string>
#include <vector>

namespace hrp::diagnosis {

struct Draft {
  std::string text;                // of experiment.yaml
  std::vector<std::string> found;  // for people: "7 of 7 joints have positions"
  std::vector<std::string> asked;  // what only they know
};

// robot: URDF, MJCF or SDF. logs: text recordings (docs/text_recordings.md), MCAP logs or ROS bags. folder: where the
// text is to be written; the files are named as seen from there. Throws InputError for what cannot be read.
Draft make_draft(const std::string& robot, const std::vector<std::string>& logs, const std::string& folder);

}  // namespace hrp::diagnosis
