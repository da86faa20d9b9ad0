// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/joint_turns.h"

namespace hrp::diagnosis::floating {

bool may_bend(const LeggedLog& log, int joint) {
  bool carries = false;
  for (const Foot& foot : log.feet) {
    if (!is_above(log.tree, joint + 1, foot.link)) continue;
    if (foot.sensor < 0 || !log.sensors[static_cast<size_t>(foot.sensor)].has_wrench()) return false;
    carries = true;
  }
  return carries && log.tree.joint(joint).kind == JointKind::kRevolute;
}

std::vector<JointTurn> list_turns(const LeggedLog& log, const ColumnLayout& layout,
                                  const std::vector<JointSides>& sides) {
  std::vector<JointTurn> out;
  for (int j = 0; j < layout.joints; ++j) {
    if (!log.has_position[static_cast<size_t>(j)]) continue;
    const JointSides& s = sides[static_cast<size_t>(j)];
    out.push_back({j,
                   0,
                   {{layout.joint(j, kOffsetColumn), 1.0},
                    {layout.joint(j, kPlayColumn), s.play},
                    {layout.joint(j, kGiveColumn), s.give}}});
    for (int a = 0; a < 2 && may_bend(log, j); ++a)
      out.push_back({j, 1 + a, {{layout.joint(j, kBendColumn + a), s.bend[a]}}});
  }
  return out;
}

std::vector<int> list_turn_columns(const LeggedLog& log, const ColumnLayout& layout) {
  std::vector<int> out;
  for (const JointTurn& turn : list_turns(log, layout, std::vector<JointSides>(static_cast<size_t>(layout.joints)))) {
    for (const auto& [column, factor] : turn.columns) out.push_back(column);
  }
  return out;
}

Vector3d get_cross_axis(const JointSpec& joint, int axis) {
  const Vector3d own = joint.axis_F.normalized();
  int least = 0;
  own.cwiseAbs().minCoeff(&least);
  const Vector3d first = (Vector3d::Unit(least) - own(least) * own).normalized();
  return axis == 1 ? first : Vector3d(own.cross(first));
}

}  // namespace hrp::diagnosis::floating
