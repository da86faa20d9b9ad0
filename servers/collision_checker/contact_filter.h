// SPDX-License-Identifier: BSD-3-Clause
// Which bodies never touch each other because the scenario says so in `no_contact`.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/multibody/tree_spec.h"
#include "common/robot/movers.h"
#include "common/robot/scenario.h"

namespace hrp {

class ContactFilter {
 public:
  // Names that are no link, obstacle, "ground" or "all" are left out: check_scenario() has refused them.
  ContactFilter(const TreeSpec& tree, const Scenario& scenario, const std::vector<Mover>& movers);
  // Bodies as in ContactPair. The name of another robot stands for all its links.
  bool may_touch(int body_a, int body_b) const;

 private:
  std::set<std::pair<int, int>> never_;  // the smaller index first
};

}  // namespace hrp
