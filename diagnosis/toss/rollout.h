// SPDX-License-Identifier: BSD-3-Clause
// One rigid body that flies, strikes the ground, slides, rolls and comes to rest: its motion from a start state, with
// the simulator's own law of rigid contact (impulse_contact.h). Free flight is integrated in long steps and ends where
// the first point touches, so that a prediction depends smoothly on where and how fast the body starts.
#pragma once

#include <vector>

#include "common/multibody/tree_spec.h"
#include "common/robot/sole.h"

namespace hrp::diagnosis::toss {

struct BodyState {
  Eigen::Quaterniond R_WB = Eigen::Quaterniond::Identity();
  Vector3d p_WB = Vector3d::Zero();  // [m] origin of the body's frame
  Vector3d w_WB = Vector3d::Zero();  // [rad/s] world axes
  Vector3d v_WB = Vector3d::Zero();  // [m/s]
};

// Everything that decides the motion.
struct World {
  TreeSpec body;  // one link, floating
  GroundSpec ground;
  double restitution = 0.0;
  double drag = 0.0;                // [1/s] deceleration of the centre of mass per speed
  Vector3d gravity_W{0, 0, -9.81};  // [m/s^2]
};

// Which kind of motion a sample lies in.
enum class Regime { kFlight, kImpact, kContact };

// States at `time` (increasing; the first is `start`). False when the motion does not stay finite.
// `regimes`, where asked for: impact when the interval before the sample holds one.
bool roll_out(const World& world, const std::vector<Sole>& soles, const BodyState& start,
              const std::vector<double>& time, std::vector<BodyState>* states, std::vector<Regime>* regimes = nullptr);

}  // namespace hrp::diagnosis::toss
