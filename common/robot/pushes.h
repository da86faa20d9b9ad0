// SPDX-License-Identifier: BSD-3-Clause
// What pushes one robot or object from outside: the scenario's pushes and hands, and people during a run.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/kinematics.h"
#include "common/robot/external_wrench.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

// Scenario::pushes and Scenario::hands as wrenches.
class Pushes {
 public:
  // Leaves out pushes on objects and other robots (make_movers()). Throws InputError: unknown link, a hand that is too
  // stiff for a step. `start`: where hands take hold.
  Pushes(const RobotDescription& robot, const Scenario& scenario, const State& start);
  // Those that act in the step that begins at `time`; a hand's force is that of the state at the step's beginning. The
  // result lives until the next call.
  const ExternalWrenches& find(double time, const State& state);
  // Live pushes that act from now on, instead of those before. Their links must be the robot's.
  void set_live(const PushForces& forces);
  void let_go() {
    live_.clear();
    acting_.clear();
  }
  // What the last find() told of, with the scenario's names and moving links.
  const PushForces& acting() const { return acting_; }

 private:
  struct Push {
    int link = 0;
    PushSpec spec;
  };
  struct Hand {
    int link = 0;
    HandSpec spec;
    Vector3d p_WH0 = Vector3d::Zero();  // [m] where it takes hold
  };
  void add_hands(const Scenario& scenario, const State& start);
  void add(const std::string& name, int link, const Vector3d& p_LQ, const Vector3d& arm_W, const Vector3d& force_W);
  void add(const Push& push, const Transform& X_WL) {
    add(push.spec.name, push.link, push.spec.p_LQ, X_WL.R * push.spec.p_LQ, push.spec.force_W);
  }

  std::vector<Push> pushes_;
  std::vector<Push> live_;  // act until they are replaced
  std::vector<Hand> hands_;
  Model model_;
  Data data_;
  ExternalWrenches active_;
  PushForces acting_;
};

}  // namespace hrp
