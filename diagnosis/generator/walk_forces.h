// SPDX-License-Identifier: BSD-3-Clause
// Forces on a walking robot that no list of effects has: a cable that pulls, a sole that sticks.
#pragma once

#include <mujoco/mujoco.h>

#include "diagnosis/generator/hidden.h"

namespace hrp::cases {

class WalkForces {
 public:
  WalkForces(const RobotPlan& robot, const std::vector<Hidden>& hidden, const mjModel* m);
  void apply(const mjModel* m, mjData* d) const;

 private:
  struct Cable {
    int body = 0;
    double anchor[3]{}, stiffness = 0, length = 0;  // [N/m], [m] at which it is taut
  };
  struct Glue {
    int body = 0;
    double place[3]{}, pull = 0, reach = 0;  // lower face of the sole in the body [m]; [N], fading over [m]
  };
  std::vector<Cable> cables_;
  std::vector<Glue> glues_;
};

}  // namespace hrp::cases
