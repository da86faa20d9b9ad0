// SPDX-License-Identifier: BSD-3-Clause
#include "controller/ros/trajectory.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace hrp {
namespace {

JointCommand make_rest(JointCommand command) {
  command.qd.setZero(command.q.size());
  return command;
}

void widen(double value, Extremes* extremes) {
  extremes->lowest = std::min(extremes->lowest, value);
  extremes->highest = std::max(extremes->highest, value);
}

}  // namespace

CubicSegment make_cubic(double q0, double v0, double q1, double v1, double duration) {
  const double slope = (q1 - q0) / duration;
  return {q0, v0, (3.0 * slope - 2.0 * v0 - v1) / duration, (v0 + v1 - 2.0 * slope) / (duration * duration), duration};
}

CubicSegment make_line(double q0, double q1, double duration) { return {q0, (q1 - q0) / duration, 0.0, 0.0, duration}; }

// Between its ends the position turns where v0 + 2 a t + 3 b t^2 = 0. The root far from zero is found without a
// difference of equal numbers, the other one from their product.
Extremes calc_position_extremes(const CubicSegment& segment) {
  const double end = segment.find_position(segment.duration);
  Extremes extremes{std::min(segment.q0, end), std::max(segment.q0, end)};
  const double discriminant = segment.a * segment.a - 3.0 * segment.b * segment.v0;
  if (discriminant <= 0.0) return extremes;  // it turns nowhere
  const double far = -(segment.a + std::copysign(std::sqrt(discriminant), segment.a));
  for (const double t : {far / (3.0 * segment.b), segment.v0 / far}) {
    if (t > 0.0 && t < segment.duration) widen(segment.find_position(t), &extremes);
  }
  return extremes;
}

Extremes calc_velocity_extremes(const CubicSegment& segment) {
  const double end = segment.find_velocity(segment.duration);
  Extremes extremes{std::min(segment.v0, end), std::max(segment.v0, end)};
  const double t = -segment.a / (3.0 * segment.b);  // not finite for lines and parabolas, whose extremes are their ends
  if (t > 0.0 && t < segment.duration) widen(segment.find_velocity(t), &extremes);
  return extremes;
}

Trajectory::Trajectory(std::vector<TrajectoryPoint> points, bool cubic) : points_(std::move(points)), cubic_(cubic) {
  HRP_CHECK(!points_.empty(), "a trajectory without points");
}

CubicSegment Trajectory::find_segment(size_t i, Eigen::Index joint) const {
  const TrajectoryPoint &from = points_[i], &to = points_[i + 1];
  const double duration = to.time - from.time;
  if (!cubic_) return make_line(from.command.q[joint], to.command.q[joint], duration);
  return make_cubic(from.command.q[joint], from.command.qd[joint], to.command.q[joint], to.command.qd[joint], duration);
}

JointCommand Trajectory::sample(double time) const {
  if (time <= points_.front().time) return make_rest(points_.front().command);
  if (time >= points_.back().time) return make_rest(points_.back().command);
  const auto after = std::upper_bound(points_.begin(), points_.end(), time,
                                      [](double t, const TrajectoryPoint& point) { return t < point.time; });
  const size_t i = static_cast<size_t>(after - points_.begin()) - 1;
  const TrajectoryPoint& from = points_[i];
  JointCommand command = from.command;
  for (Eigen::Index joint = 0; joint < command.q.size(); ++joint) {
    const CubicSegment segment = find_segment(i, joint);
    command.q[joint] = segment.find_position(time - from.time);
    command.qd[joint] = segment.find_velocity(time - from.time);
  }
  command.effort += (time - from.time) / (after->time - from.time) * (after->command.effort - from.command.effort);
  return command;
}

Trajectory make_hold(const JointCommand& command) { return Trajectory({{0.0, make_rest(command)}}, false); }

}  // namespace hrp
