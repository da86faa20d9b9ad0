// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/turned_joints.h"

#include <algorithm>

#include "common/base/has.h"
#include "common/base/join_words.h"
#include "common/base/rounding.h"

namespace hrp::diagnosis::floating {

TurnedJoints turn_joints(const Experiment& e, const std::function<std::vector<int>(const Experiment&, double*)>& find,
                         const std::function<Experiment(Experiment, const TurnedJoints&)>& convert) {
  TurnedJoints out;
  if (!e.scenario.floating_base || e.num_joints() == 0) return out;
  for (std::vector<int> joints = find(e, &out.left); !joints.empty(); joints = find(convert(e, out), &out.left)) {
    if (std::any_of(joints.begin(), joints.end(), [&](int j) { return has(out.joints, j); })) break;
    out.joints.insert(out.joints.end(), joints.begin(), joints.end());
  }
  return out;
}

std::string describe(const Experiment& e, const TurnedJoints& turned, const std::string& fault,
                     const std::string& rest) {
  const std::string names = join_words(turned.joints, [&](int joint) { return e.robot.tree.joint(joint).name; });
  return names + ": " + fault + ". With the other sign, " + number(100.0 * turned.left, 2) + " % of " + rest +
         " is left (mean square). The recordings are judged with the other sign";
}

}  // namespace hrp::diagnosis::floating
