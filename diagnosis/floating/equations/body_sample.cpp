// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/body_sample.h"

#include <algorithm>

#include "common/multibody/kinematics.h"
#include "diagnosis/floating/equations/joint_turns.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

bool is_whole(const LeggedLog& log, const ForceSensor& s) {
  return s.has_wrench() || (s.has_force() && (s.foot < 0 || !log.feet[static_cast<size_t>(s.foot)].flat));
}

bool is_known(const LeggedLog& log, const Foot& foot) {
  if (foot.sensor < 0) return false;
  const ForceSensor& s = log.sensors[static_cast<size_t>(foot.sensor)];
  return s.has_wrench() || (s.has_force() && !foot.flat);
}

void find_sensor_frame(const BodySample& at, int s, Matrix3d* R, Vector3d* p) {
  const ForceSensor& sensor = at.log.sensors[static_cast<size_t>(s)];
  const Transform X = get_pose(at.motion.data(), sensor.link);
  *R = sensor.world ? Matrix3d(at.motion.find_attitude(at.k).transpose()) : Matrix3d(X.R * sensor.X_LS.R);
  *p = X * sensor.X_LS.p;
  if (sensor.foot < 0 || sensor.has_wrench()) return;
  const Foot& foot = at.log.feet[static_cast<size_t>(sensor.foot)];
  *p = X * foot.p_LC - foot.radius * at.motion.find_up(at.k);
}

PointWrench read_wrench(const BodySample& at, int s) {
  PointWrench w;
  Matrix3d R;
  const ForceSensor& sensor = at.log.sensors[static_cast<size_t>(s)];
  w.link = sensor.link;
  w.whole = is_whole(at.log, sensor);
  find_sensor_frame(at, s, &R, &w.p);
  w.force = R * get_values(&at.clip.force[6 * static_cast<size_t>(s)], at.k);
  w.moment = R * get_values(&at.clip.force[6 * static_cast<size_t>(s) + 3], at.k);
  return w;
}

Vector3d calc_force_below(const BodySample& at) {
  Vector3d sum = Vector3d::Zero();
  for (const ForceSensor& s : at.log.sensors) {
    if (s.below.mass <= 0) continue;
    const Vector3d p = get_pose(at.motion.data(), s.link) * s.below.p_LLcm_L;
    sum += s.below.mass * calc_point_acceleration(at.motion.data(), s.link, p).tail<3>();
  }
  return sum;
}

Vector3d calc_passed_moment(const BodySample& at, int link) {
  Vector3d moment = get_joint_wrench(at.motion.data(), link).head<3>();
  const Vector3d p = get_pose(at.motion.data(), link).p;
  for (size_t s = 0; s < at.log.sensors.size(); ++s) {
    if (!is_above(at.log.tree, link, at.log.sensors[s].link)) continue;
    const PointWrench w = read_wrench(at, static_cast<int>(s));
    moment -= w.moment + (w.p - p).cross(w.force);
  }
  return moment;
}

Vector3d find_normal(const BodySample& at) {
  Vector3d normal = Vector3d::Zero();
  for (const Foot& foot : at.log.feet) {
    if (!foot.flat || foot.sensor < 0) continue;
    Matrix3d R;
    Vector3d p;
    find_sensor_frame(at, foot.sensor, &R, &p);
    // Along the foot's z axis, however its sensor is mounted.
    const bool world = at.log.sensors[static_cast<size_t>(foot.sensor)].world;
    const Vector3d up = world ? R.col(2) : get_pose(at.motion.data(), foot.link).R.col(2);
    normal += std::max(0.0, calc_vertical_force(at.log, at.clip, static_cast<size_t>(foot.sensor), at.k)) * up;
  }
  return normal.norm() > 0 ? Vector3d(normal.normalized()) : at.motion.find_up(at.k);
}

}  // namespace hrp::diagnosis::floating
