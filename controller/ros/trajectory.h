// SPDX-License-Identifier: BSD-3-Clause
// Joint references between the points of a trajectory: cubic through positions and velocities, or straight lines.
#pragma once

#include <vector>

#include "common/robot/signals.h"

namespace hrp {

// One joint between two points: q(t) = q0 + v0 t + a t^2 + b t^3 for 0 <= t <= duration [s].
struct CubicSegment {
  double q0 = 0.0;        // [rad or m]
  double v0 = 0.0;        // [rad/s or m/s]
  double a = 0.0;         // [rad/s^2 or m/s^2] half of the acceleration at the start
  double b = 0.0;         // [rad/s^3 or m/s^3]
  double duration = 0.0;  // [s] positive
  double find_position(double t) const { return q0 + t * (v0 + t * (a + t * b)); }
  double find_velocity(double t) const { return v0 + t * (2.0 * a + t * 3.0 * b); }
};

// The cubic with these positions and velocities at its ends.
CubicSegment make_cubic(double q0, double v0, double q1, double v1, double duration);
// The straight line between two positions.
CubicSegment make_line(double q0, double q1, double duration);

struct Extremes {
  double lowest = 0.0, highest = 0.0;
};
// Of the positions [rad or m] and velocities [rad/s or m/s] within the segment, its ends included.
Extremes calc_position_extremes(const CubicSegment& segment);
Extremes calc_velocity_extremes(const CubicSegment& segment);

// What all joints are told at one time; q, qd and effort have one number a joint.
struct TrajectoryPoint {
  double time = 0.0;  // [s] since the trajectory began
  JointCommand command;
};

class Trajectory {
 public:
  Trajectory() = default;
  // At least one point, times increase. Not cubic: velocities of the points are not used.
  Trajectory(std::vector<TrajectoryPoint> points, bool cubic);
  // Before the first point and after the last one their positions and efforts are held, at rest. Efforts are straight
  // lines between points.
  JointCommand sample(double time) const;
  // Of `joint` between points i and i + 1.
  CubicSegment find_segment(size_t i, Eigen::Index joint) const;
  const std::vector<TrajectoryPoint>& points() const { return points_; }

 private:
  std::vector<TrajectoryPoint> points_;
  bool cubic_ = false;
};

// Holds the positions and efforts of `command`, at rest.
Trajectory make_hold(const JointCommand& command);

}  // namespace hrp
