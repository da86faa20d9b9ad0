// SPDX-License-Identifier: BSD-3-Clause
// One joint within one step: servo, drive, friction, transmission and springs put together in their order, as effort
// on the link that is affine in the joint's velocity at the end of the step, with regimes for what switches.
//
//   start_drive      regimes as the state at the start suggests
//   linearise_drive  effort = a - b v', or "held": the joint does not move during this step
//   resolve_drive    after a solve: do the regimes agree with v'? Changes those that do not
//   finish_drive     moves the memories on, gives the efforts that acted
//
// The chain: reference -> servo -> limit -> lag -> torque constant -> saturation -> motor (inertia, friction, cogging)
// -> transmission (stiffness, gap) -> link (parallel spring, hysteresis, stops). A stiff transmission is the same body
// as the link. A motor behind an elastic one is eliminated: its velocity is affine in v' as well.
#pragma once

#include "common/effects/joint_law.h"

namespace hrp {

// What a joint remembers from step to step.
struct DriveMemory {
  double motor_q = 0.0, motor_v = 0.0;  // [rad], [rad/s] motor side, reflected; elastic transmissions only
  double lag_effort = 0.0;              // [N m] drive effort behind the lag
  double hysteresis = 0.0;              // Bouc-Wen z
  double bend = 0.0;                    // [rad] of dry friction that bends before it slips; on the motor side
};

struct DriveInput {
  double q = 0.0, v = 0.0;                            // link side at the start of the step
  double reference = 0.0, rate = 0.0, forward = 0.0;  // at the start of the step + horizon
  double horizon = 0.0;                               // [s] time step: implicit; 0: explicit
  double dt = 0.0;                                    // [s] time step
};

enum class FrictionRegime : signed char { kNone, kHeld, kForward, kBackward };

struct DriveRegime {
  signed char servo = 0;                            // -1, +1: at the effort limit
  signed char saturation = 0;                       // -1, +1: at the true torque's limit
  signed char gap = 0;                              // side of the backlash that carries, 0 inside
  signed char stop = 0;                             // -1 lower, +1 upper stop carries
  FrictionRegime friction = FrictionRegime::kNone;  // of friction that bends: the direction; never held
  bool slips = false;  // friction that bends: bent as far as it goes by the end of the step
  signed char changes = 0;
};

struct DriveStep {
  DriveInput in;
  DriveRegime regime;
  AffineEffort servo;    // logged effort over motor velocity
  AffineEffort motor;    // everything on the motor but the transmission
  AffineEffort link;     // effort on the link over v'
  AffineEffort twist;    // transmission effort = twist.a + twist.b (motor v' - link v')
  AffineEffort motor_v;  // motor v' = motor_v.a - motor_v.b v'
  bool held = false;     // the link's joint is held by friction (no elastic transmission)
  double load = 0.0;     // [N m] the drive's torque, for friction that depends on it
};

struct DriveEfforts {
  double link = 0.0;   // [N m] on the link
  double servo = 0.0;  // [N m] as the drive logs it
};

DriveMemory make_drive_memory(const JointLaws& laws, double q);

void start_drive(const JointLaws& laws, const DriveMemory& memory, const DriveInput& in, DriveStep* step);
void linearise_drive(const JointLaws& laws, const DriveMemory& memory, DriveStep* step);
// v: joint velocity at the end of the step; held_effort: what holding the joint took, if it was held. True: changed.
bool resolve_drive(const JointLaws& laws, const DriveMemory& memory, double v, double held_effort, DriveStep* step);
DriveEfforts finish_drive(const JointLaws& laws, const DriveStep& step, double v, double held_effort,
                          DriveMemory* memory);

}  // namespace hrp
