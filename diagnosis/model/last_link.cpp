// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/last_link.h"

#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {
namespace {

constexpr double kLeastLever = 0.001;  // [m] of a centre of mass from its axis: nearer, no turn moves it

}  // namespace

std::optional<LastLink> find_last_link(const TreeSpec& tree, int joint) {
  const LinkSpec& link = tree.links[static_cast<size_t>(joint) + 1];
  const Vector3d axis = link.joint.axis_F.normalized(),
                 lever = link.inertia.p_LLcm_L - axis * axis.dot(link.inertia.p_LLcm_L);
  if (!is_last(tree, joint + 1) || link.joint.kind != JointKind::kRevolute || lever.norm() < kLeastLever)
    return std::nullopt;
  const Vector3d out = lever.normalized();
  return LastLink{out, axis.cross(out), lever.norm()};
}

}  // namespace hrp::diagnosis
