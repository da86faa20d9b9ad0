// SPDX-License-Identifier: BSD-3-Clause
#include "tests/physics/rigs.h"

#include "common/multibody/kinematics.h"

namespace hrp::rigs {

ContactSet CornerFinder::find(const Model& model, const State& state) const {
  Data data(model);
  update_kinematics(model, state, &data);
  ContactSet contacts;
  for (const Corner& corner : corners) {
    const Vector3d p = get_pose(data, corner.link) * corner.p_LC;
    const double depth = height * n.z() - n.dot(p);
    if (depth < 0.0) continue;
    if (contacts.empty() || contacts.back().body_a != corner.link) {
      contacts.emplace_back();
      contacts.back().body_a = corner.link;
      contacts.back().friction = friction;
      contacts.back().p_WR = get_pose(data, corner.link).p;
    }
    ContactPoint point;
    point.p_WC = p + 0.5 * depth * n;
    point.n_BA_W = n;
    point.depth = depth;
    contacts.back().points.push_back(point);
  }
  return contacts;
}

}  // namespace hrp::rigs
