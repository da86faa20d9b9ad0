// SPDX-License-Identifier: BSD-3-Clause
// Walking pattern: centre of mass, zero moment point and soles as functions of time, from the pendulum's closed form.
#pragma once

#include <vector>

#include "common/robot/walk_spec.h"
#include "common/spatial/gravity.h"
#include "common/spatial/transform.h"
#include "controller/walking/footsteps.h"
#include "controller/walking/lipm.h"

namespace hrp::walking {

// Where the pattern begins, world axes that are level and have their origin between the soles.
struct PatternStart {
  Vector3d com = Vector3d::Zero();       // [m]
  Transform soles[2];                    // by Side
  Matrix3d R_WB = Matrix3d::Identity();  // base
};

enum class Support { kBoth, kLeft, kRight };

struct PatternSample {
  Vector3d com = Vector3d::Zero(), com_velocity = Vector3d::Zero();
  Vector2d com_acceleration = Vector2d::Zero();  // [m/s^2]
  Vector3d zmp = Vector3d::Zero();               // on the ground
  Transform soles[2];                            // by Side
  Matrix3d R_WB = Matrix3d::Identity();
  Support support = Support::kBoth;
  int step = 0;                       // number of steps begun
  Vector2d shift = Vector2d::Zero();  // [m] by which step adjustment has moved com: at once, when a foot lands
};

// Smooth from 0 to 1 for s from 0 to 1: two derivatives continuous.
double calc_blend(double s);

// Height over the straight line between two footholds, s = 0 to 1 of a swing of T seconds: up to `height` at the
// middle; touches with `landing_speed`.
double calc_swing_height(double s, double T, double height, double landing_speed);

class WalkPattern {
 public:
  // g: [m/s^2]. Throws InputError: steps that cannot be walked.
  WalkPattern(const WalkSpec& spec, const PatternStart& start, double zc, double g = kGravity);

  PatternSample sample(double t) const;
  // Step adjustment: in single support the foot in the air comes down `shift` [m] beside its plan, within reach, and
  // the rest of the walk moves with it. Replaces what was asked for this step before. False when there is no such step,
  // or it is the last, which only closes up.
  bool move_step(double t, const Vector2d& shift);
  double find_remaining(double t) const;                             // [s] until the support changes
  double duration() const;                                           // [s] until the robot stands again
  const std::vector<Footstep>& footsteps() const { return steps_; }  // as placed by the modified rule
  const std::vector<Footstep>& planned() const { return planned_; }
  const Pendulum& pendulum() const { return pendulum_; }
  const ConstraintPlane& plane() const { return plane_; }
  // Tilt of soles that stand on the plane with this heading.
  Matrix3d calc_sole_attitude(double yaw) const;

 private:
  struct Phase {
    double begin = 0.0;
    ZmpSegment zmp;
    PendulumState state;  // at begin
    Support support = Support::kBoth;
    int step = 0;                       // steps begun, this one included
    Stance stance;                      // where the feet stand at begin
    double floor0 = 0.0, floor1 = 0.0;  // [m] height that carries the body, at begin and end, beside the plane
  };
  Vector2d find_zmp(const Stance& stance, Side side) const;
  Vector2d find_middle(const Stance& stance) const;
  void add(const ZmpSegment& zmp, Support support, const Stance& stance, double floor1);
  void make_phases();
  void start_walk(Side carrying, const Stance& stance);
  void finish();
  void make_walk(size_t first, Side carrying, Stance stance);
  void place(size_t n, Side carrying, const Stance& stance);
  Stance land(size_t n, Side carrying, Stance stance);
  Vector2d find_shift(int number) const;
  void shift(const Phase& phase, double s, PatternSample* sample) const;
  PendulumState find_target(size_t n) const;
  PendulumState calc_rest(const Phase& phase, double t) const;
  const Phase& find_phase(double t) const;
  PatternSample sample_settling(double t) const;
  void put_feet(const Phase& phase, double t, PatternSample* sample) const;
  Foothold find_swing(const Phase& phase, double s) const;

  WalkSpec spec_;
  PatternStart start_;
  Pendulum pendulum_;
  ConstraintPlane plane_;
  Stance first_;
  std::vector<Footstep> planned_, steps_;
  std::vector<Phase> phases_;
  PendulumState last_;
  double floor_ = 0.0;
  double time_ = 0.0;
  std::vector<Vector2d> shifts_;  // [m] of footholds from their plan, by step; the last one holds for all that follow
};

}  // namespace hrp::walking
