// SPDX-License-Identifier: BSD-3-Clause
// What a first experiment says of a bag: which topic holds which signal, and which sensors the robot has.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

struct BagDraft {
  std::string text;                        // the sections `topics` and `sensors`
  bool commands = false, efforts = false;  // it has some
  bool imu = false;                        // and an inertial sensor
  std::vector<std::string> found, asked;   // as of Draft
};

// Reads the whole bag. Throws InputError for what cannot be read.
BagDraft draft_bag(const std::string& path, const TreeSpec& robot);

}  // namespace hrp::diagnosis
