// SPDX-License-Identifier: BSD-3-Clause
// Many findings at many joints in one table: a row a joint, a column an effect.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/page/text.h"

namespace hrp::diagnosis::html {

struct JointTable {
  // Of an effect with one parameter the value; else the effect's name and all of its values. Several where a joint has
  // several effects of the last column.
  struct Entry {
    std::string text;
    bool ambiguous = false;
  };
  using Cell = std::vector<Entry>;
  std::vector<std::string> head;         // "joint", "Coulomb friction [N m]", ..., "other"
  std::vector<std::string> joints;       // in the order of the checks, then as they are found
  std::vector<std::vector<Cell>> cells;  // of each joint, one of each column but the first
  std::vector<const json*> findings;     // of the report, that the table has
};

// Empty if findings are so few that a list shows them as well. What all joints share (one late bus) is no part of it.
JointTable make_joint_table(const json& report);

}  // namespace hrp::diagnosis::html
