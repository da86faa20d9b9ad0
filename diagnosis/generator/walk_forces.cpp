// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/walk_forces.h"

#include <algorithm>
#include <cmath>

namespace hrp::cases {

WalkForces::WalkForces(const RobotPlan& robot, const std::vector<Hidden>& hidden, const mjModel* m) {
  for (const Hidden& h : hidden) {
    if (h.effect == "cable") {
      Cable c;
      c.body = mj_name2id(m, mjOBJ_BODY, h.where.c_str());
      c.stiffness = h.get("stiffness");
      const Vec3 anchor = h.get3("anchor");
      std::copy(anchor.begin(), anchor.end(), c.anchor);
      // The trunk is some two legs above the ground, over the origin.
      c.length = std::hypot(anchor[0], anchor[1], anchor[2] - 1.4 * robot.leg) + h.get("slack");
      cables_.push_back(c);
    }
    if (h.effect != "sticky_sole") continue;
    for (const FootPlan& foot : robot.feet) {
      if (robot.links[static_cast<std::size_t>(foot.link)].name != h.where) continue;
      glues_.push_back({mj_name2id(m, mjOBJ_BODY, h.where.c_str()),
                        {foot.center[0], foot.center[1], foot.center[2] - foot.size[2] / 2},
                        h.get("pull"),
                        h.get("reach")});
    }
  }
}

void WalkForces::apply(const mjModel* m, mjData* d) const {
  const double none[3] = {0, 0, 0};
  for (const Cable& c : cables_) {
    const double* at = d->xipos + 3 * c.body;
    double way[3];
    mju_sub3(way, c.anchor, at);
    const double stretch = mju_normalize3(way) - c.length;
    if (stretch <= 0) continue;
    mju_scl3(way, way, c.stiffness * stretch);
    mj_applyFT(m, d, way, none, at, c.body, d->qfrc_applied);
  }
  for (const Glue& g : glues_) {
    double at[3];
    mju_mulMatVec(at, d->xmat + 9 * g.body, g.place, 3, 3);
    mju_addTo3(at, d->xpos + 3 * g.body);
    if (at[2] > g.reach) continue;
    const double pull[3] = {0, 0, -g.pull * (1 - std::max(0.0, at[2]) / g.reach)};
    mj_applyFT(m, d, pull, none, at, g.body, d->qfrc_applied);
  }
}

}  // namespace hrp::cases
