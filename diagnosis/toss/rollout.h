// SPDX-License-Identifier: BSD-3-Clause
// Simulates one rigid body from a start state: it flies, strikes the ground, slides, rolls and comes to rest. Contacts
// follow the simulator's law of rigid contact (impulse_contact.h). Free flight uses long steps that end at the first
// touch, so the prediction is a smooth function of the start state.
#pragma once

#include <vector>

#include "common/multibody/tree_spec.h"
#include "common/robot/sole.h"
#include "common/spatial/gravity.h"

namespace hrp::diagnosis::toss {

// Pose and twist of the body; world axes.
struct BodyState {
  Eigen::Quaterniond R_WB = Eigen::Quaterniond::Identity();
  Vector3d p_WB = Vector3d::Zero();  // [m] origin of the body's frame
  Vector3d w_WB = Vector3d::Zero();  // [rad/s] world axes
  Vector3d v_WB = Vector3d::Zero();  // [m/s]
};

// Everything that determines the motion.
struct World {
  TreeSpec body;  // one link, floating
  GroundSpec ground;
  double restitution = 0.0;
  double drag = 0.0;                    // [1/s] deceleration of the centre of mass per speed
  Vector3d gravity_W{0, 0, -kGravity};  // [m/s^2]
};

// Kind of motion at a sample.
enum class Regime { kFlight, kImpact, kContact };

// Computes the states at `time` [s] (increasing); the first one is `start`. Returns false if the motion becomes
// infinite or chatters without end. `regimes`, if given: kImpact if the interval before the sample contains an impact.
bool roll_out(const World& world, const std::vector<Sole>& soles, const BodyState& start,
              const std::vector<double>& time, std::vector<BodyState>* states, std::vector<Regime>* regimes = nullptr);

}  // namespace hrp::diagnosis::toss
