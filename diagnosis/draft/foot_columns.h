// SPDX-License-Identifier: BSD-3-Clause
// Which columns of other people's logs are forces under feet: "FR_Force", "left_foot_fz", "foot_force_RL". A side may
// be spelt in one and a letter in the other: "right_foot_fz" of the link R_FOOT.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

struct FootColumn {
  size_t column = 0;
  std::string link, axis;  // of the foot; "x", "y", "z"
  bool foot = false;       // the column or the link is called one: no finger of a gripper
};

// Columns of forces whose other words name one foot, or one link at the end of a chain. A force without an axis presses
// along z.
std::vector<FootColumn> find_foot_columns(const std::vector<std::string>& columns, const TreeSpec& tree);

}  // namespace hrp::diagnosis
