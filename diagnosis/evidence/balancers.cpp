// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/balancers.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// True if a joint's effort shows the term: more of it than efforts are known to.
bool is_shown(const TorqueDesign& design, const JointDesign& joint, const GradedTerm& g) {
  const auto at = std::find_if(design.whole.begin(), design.whole.end(),
                               [&](const Term& t) { return t.row == g.term.row && t.place == g.term.place; });
  const Columns columns = list_whole_columns(design, joint, static_cast<size_t>(at - design.whole.begin()));
  return calc_square(joint.total, columns, g.parameters) > std::pow(kKnown * joint.spread, 2) * joint.total.n;
}

// What is across gravity may be none, or is a detail.
bool is_upright(const Vector3d& gravity_W, const GradedTerm& g) {
  const Vector3d force = g.parameters, up = gravity_W.normalized();
  for (long axis = 0; axis < 3; ++axis) {
    const double across = std::abs(force[axis] - force.dot(up) * up[axis]);
    if (across > std::max(kDetail * force.norm(), kNinetyFive * g.width[axis])) return false;
  }
  return gravity_W.norm() > 0.0;
}

}  // namespace

void doubt_balancers(const TorqueDesign& design, std::vector<GradedTerm>* graded) {
  for (GradedTerm& g : *graded) {
    if (g.term.effect().id != EffectId::kExternalForce || !is_upright(design.data->experiment->scenario.gravity_W, g))
      continue;
    std::vector<int> joints;
    for (const JointDesign& joint : design.joints) {
      if (is_shown(design, joint, g)) joints.push_back(joint.joint);
    }
    // With one joint in all, other rules ask whether it is another mass.
    if (joints.size() == 1 && design.joints.size() > 1) {
      g.grade = Grade::kAmbiguous;
      g.balanced = joints[0];
    }
  }
}

}  // namespace hrp::diagnosis
