// SPDX-License-Identifier: BSD-3-Clause
// Columns of faults of force sensors and of the main IMU, whose readings enter all equations of the body. Each fault
// changes a reading to first order: a factor adds the reading, a zero adds a unit, a turn by the vector a adds -a x
// reading, a delay subtracts the reading's rate.
#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/floating/equations/body_rows.h"

namespace hrp::diagnosis::floating {
namespace {

// reading = R(turn)^T (scale true + bias), late by a delay. R: axes of the sensor, base axes.
void add_force_sensor(const BodyEquations& equations, int s, BodyRows* rows) {
  const BodySample& at = rows->at();
  const ForceSensor& sensor = at.log.sensors[static_cast<size_t>(s)];
  const Track* tracks = &at.clip.force[6 * static_cast<size_t>(s)];
  Matrix3d R;
  Vector3d p;
  find_sensor_frame(at, s, &R, &p);
  const PointWrench w = read_wrench(at, s);
  const Vector3d none = Vector3d::Zero();
  const bool whole = sensor.has_wrench();
  const auto add = [&](const Vector3d& force, const Vector3d& moment, int column) {
    rows->put_wrench({w.link, w.p, force, moment, w.whole}, 1, equations.layout.sensor(s, column));
  };
  add(w.force, none, kForceScaleColumn);
  if (whole) add(none, w.moment, kTorqueScaleColumn);
  for (int a = 0; a < 3; ++a) {
    const Vector3d axis = R.col(a);
    if (sensor.axis[a]) add(axis, none, kForceBiasColumn + a);
    if (whole) add(none, axis, kTorqueBiasColumn + a);
    if (!sensor.has_force()) continue;
    add(-axis.cross(w.force), whole ? Vector3d(-axis.cross(w.moment)) : none, kWrenchTurnColumn + a);
  }
  add(-(R * get_rates(tracks, at.k)), whole ? Vector3d(-(R * get_rates(tracks + 3, at.k))) : none, kWrenchDelayColumn);
}

// How the residuals of all velocities change by specific force [m/s^2] in the axes of the IMU.
Eigen::MatrixXd calc_slope_by_specific_force(const BodyRows& rows, const Matrix3d& R_BI) {
  BodyMotion& motion = rows.at().motion;
  const Eigen::VectorXd& nominal = rows.nominal().tau;
  Eigen::MatrixXd slope(nominal.size(), 3);
  Eigen::VectorXd tau(nominal.size());
  for (int a = 0; a < 3; ++a) {
    Eigen::VectorXd moved = motion.vdot();
    moved.segment<3>(3) += R_BI.col(a);
    calc_inverse_dynamics(motion.model(), moved, nullptr, &motion.data(), &tau);
    slope.col(a) = nominal - tau;
  }
  return slope;
}

}  // namespace

void add_force_sensor_columns(const BodyEquations& equations, BodyRows* rows) {
  for (int s = 0; s < equations.layout.sensors; ++s) add_force_sensor(equations, s, rows);
}

// Specific force moves every equation as a translation of the base does.
void add_accelerometer_columns(const BodyEquations& equations, BodyRows* rows) {
  const BodySample& at = rows->at();
  const int imu = BodyMotion::find_main_imu(at.log);
  const ImuSensor& sensor = at.log.imus[static_cast<size_t>(imu)];
  const Track* accelerometer = at.clip.imus[static_cast<size_t>(imu)].accelerometer;
  const Eigen::MatrixXd slope =
      calc_slope_by_specific_force(*rows, get_pose(at.motion.data(), sensor.link).R * sensor.R_LI);
  const auto add = [&](const Vector3d& change, int c) {
    const Eigen::VectorXd d = slope * change;
    const int column = equations.layout.imu(imu, c);
    for (int r = 0; r < 6 && equations.channels.balances; ++r) rows->put(r, d(r), column);
    if (equations.channels.weighs) rows->put(kWeightRow, rows->normal().dot(d.segment<3>(3)), column);
    for (int j = 0; j < equations.layout.joints; ++j) rows->put(kJointRow + j, d(6 + j), column);
  };
  const Vector3d f = get_values(accelerometer, at.k);
  add(f, kAccelerometerScaleColumn);
  for (int a = 0; a < 3; ++a) {
    add(Vector3d::Unit(a), kAccelerometerBiasColumn + a);
    add(-Vector3d::Unit(a).cross(f), kAccelerometerTurnColumn + a);
  }
  add(-get_rates(accelerometer, at.k), kAccelerometerDelayColumn);
}

// The body turns as the gyroscope says. Its rate is in centripetal forces, and the slope of its rate in moments.
void add_gyroscope_columns(const BodyEquations& equations, BodyRows* rows) {
  const BodySample& at = rows->at();
  const int imu = BodyMotion::find_main_imu(at.log);
  const Track* gyro = at.clip.imus[static_cast<size_t>(imu)].gyro;
  const Vector3d none = Vector3d::Zero();
  Eigen::MatrixXd slope(rows->nominal().y.size(), 6);  // by the rate, by its slope
  for (int i = 0; i < 6; ++i) {
    const Vector3d more = kSlopeStep * Vector3d::Unit(i % 3);
    at.motion.add_gyro(i < 3 ? more : none, i < 3 ? none : more);
    at.motion.update(at.k);
    slope.col(i) = rows->calc_slope(kSlopeStep);
  }
  at.motion.add_gyro(none, none);
  at.motion.update(at.k);
  const auto add = [&](const Vector3d& change, const Vector3d& of_slope, int column) {
    rows->put_all(slope.leftCols<3>() * change + slope.rightCols<3>() * of_slope, equations.layout.imu(imu, column));
  };
  const Vector3d w = get_values(gyro, at.k), rate = get_rates(gyro, at.k);
  add(w, rate, kGyroScaleColumn);
  for (int a = 0; a < 3; ++a) {
    add(Vector3d::Unit(a), none, kGyroBiasColumn + a);
    add(-Vector3d::Unit(a).cross(w), -Vector3d::Unit(a).cross(rate), kGyroTurnColumn + a);
  }
  add(-rate, -Vector3d(gyro[0].second[at.k], gyro[1].second[at.k], gyro[2].second[at.k]), kGyroDelayColumn);
}

}  // namespace hrp::diagnosis::floating
