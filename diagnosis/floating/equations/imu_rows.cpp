// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/imu_rows.h"

#include <algorithm>

#include "common/multibody/kinematics.h"
#include "diagnosis/floating/checks/flat_feet.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kQuietRate = 0.05;  // [rad/s] of a body at rest: centripetal parts of its acceleration are negligible
constexpr double kQuietForce = 0.6;  // [m/s^2/s] slope of its specific force, likewise

// d/dt of the ground's moment about a sole's centre, foot axes [N m/s]; zero where it is not recorded.
Vector3d get_moment_rate(const LeggedLog& log, const Foot& foot, const Clip& clip, size_t k) {
  if (foot.sensor < 0) return Vector3d::Zero();
  const auto s = static_cast<size_t>(foot.sensor);
  const ForceSensor& sensor = log.sensors[s];
  if (!sensor.has_wrench() || sensor.world) return Vector3d::Zero();
  return move_to_sole(sensor, foot, get_rates(&clip.force[6 * s], k), get_rates(&clip.force[6 * s + 3], k));
}

}  // namespace

ImuRows::ImuRows(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout, RowTable* table)
    : log_(log), contacts_(contacts), layout_(layout), table_(*table), main_(BodyMotion::find_main_imu(log)) {
  const auto columns = [&](size_t imu, int from, int to) {
    std::vector<int> out;
    for (int c = from; c < to; ++c) out.push_back(layout.imu(static_cast<int>(imu), c));
    return out;
  };
  for (size_t i = 0; i < log.imus.size(); ++i) {
    const ImuSensor& imu = log.imus[i];
    Channels c;
    const bool first = static_cast<int>(i) == main_,
               other = log.base_pose || (!first && main_ >= 0) || (first && imu.attitude);
    for (int a = 0; a < 3; ++a) {
      const std::string base = "/imu/" + imu.name;
      const ChannelInfo gyro{
          {EquationKind::kGyroscope, a}, base + "/angular_velocity", "rad/s", "sensor", base + "/angular_velocity"};
      const ChannelInfo force{{EquationKind::kAccelerometer, a},
                              base + "/linear_acceleration",
                              "m/s^2",
                              "sensor",
                              base + "/linear_acceleration"};
      if (imu.gyro && other) c.gyro[a] = table->add_channel(gyro, columns(i, kGyroScaleColumn, kImuColumns));
      c.over_feet = imu.gyro && first && !other && log.tree.floating_base && !contacts.walks && has_flat_foot(log);
      if (c.over_feet)
        c.gyro[a] = table->add_channel(
            {{EquationKind::kGyroscopeOverFeet, a}, gyro.signal, gyro.unit, gyro.place, gyro.name}, list_over_feet(i));
      const bool two = log.base_pose || (!first && main_ >= 0 && log.imus[static_cast<size_t>(main_)].accelerometer);
      if (imu.accelerometer && two) c.accelerometer[a] = table->add_channel(force, columns(i, 0, kGyroScaleColumn));
    }
    if (imu.accelerometer) {
      const std::string signal = "/imu/" + imu.name + "/linear_acceleration";
      c.gravity = table->add_channel({EquationKind::kGravity, signal, "m/s^2", "sensor", signal},
                                     columns(i, 0, kGyroScaleColumn));
    }
    channels_.push_back(c);
  }
}

// Of a gyroscope over feet that stand: its own, and what soles give.
std::vector<int> ImuRows::list_over_feet(size_t imu) const {
  std::vector<int> out;
  for (int c = kGyroScaleColumn; c < kAttitudeTurnColumn; ++c) out.push_back(layout_.imu(static_cast<int>(imu), c));
  for (int f = 0; f < layout_.feet; ++f) {
    out.push_back(layout_.foot(f, kRollGiveColumn));
    out.push_back(layout_.foot(f, kPitchGiveColumn));
  }
  return out;
}

// reading = R(turn)^T (scale expected + bias), late by a delay: how the difference changes with each.
void ImuRows::put(const int* channels, int scale_column, int imu, const Vector3d& reading, const Vector3d& rate,
                  const Vector3d& expected) {
  const Vector3d y = reading - expected;
  for (int a = 0; a < 3; ++a) {
    table_.begin_row(channels[a], y(a), reading(a));
    table_.add(channels[a], layout_.imu(imu, scale_column), expected(a));
    table_.add(channels[a], layout_.imu(imu, scale_column + 1 + a), 1.0);
    table_.add(channels[a], layout_.imu(imu, scale_column + 4), -rate(a));
    for (int b = 0; b < 3; ++b) {
      table_.add(channels[a], layout_.imu(imu, scale_column + 5 + b), -Vector3d::Unit(b).cross(expected)(a));
    }
  }
}

void ImuRows::add_gyro(size_t i, const Clip& clip, size_t k, BodyMotion* motion) {
  if (channels_[i].gyro[0] < 0) return;
  const ImuSensor& imu = log_.imus[i];
  const Vector3d reading = get_values(clip.imus[i].gyro, k), rate = get_rates(clip.imus[i].gyro, k);
  Vector3d expected, unused;
  const Transform X = get_pose(motion->data(), imu.link);
  const Vector3d against_base = get_velocity(motion->data(), imu.link).head<3>() - motion->rate();
  if (log_.base_pose) {
    calc_quaternion_rates(clip.base_attitude, k, &expected, &unused);
    expected = imu.R_LI.transpose() * X.R.transpose() * (expected + against_base);
  } else if (static_cast<int>(i) == main_) {
    calc_quaternion_rates(clip.imus[i].attitude, k, &expected, &unused);
  } else {
    expected = imu.R_LI.transpose() * X.R.transpose() * (motion->rate() + against_base);
  }
  put(channels_[i].gyro, kGyroScaleColumn, static_cast<int>(i), reading, rate, expected);
  if (log_.base_pose || static_cast<int>(i) != main_) return;
  // Against its own attitude: what turns or delays both is no difference.
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      table_.add(channels_[i].gyro[a], layout_.imu(main_, kAttitudeTurnColumn + b),
                 Vector3d::Unit(b).cross(expected)(a));
    }
    table_.add(channels_[i].gyro[a], layout_.imu(main_, kAttitudeDelayColumn), rate(a));
  }
}

// Flat feet that stand do not turn, but for soles that give: w_WF = -give dM/dt about their axes x and y, M what the
// ground does to the foot. Feet count by what they bear.
void ImuRows::add_gyro_over_feet(size_t i, size_t c, size_t k, BodyMotion* motion) {
  const Clip& clip = log_.clips[c];
  const ImuSensor& imu = log_.imus[i];
  const Matrix3d R_IB = (get_pose(motion->data(), imu.link).R * imu.R_LI).transpose();
  std::vector<double> share(log_.feet.size(), 0.0);
  double total = 0;
  for (size_t f = 0; f < share.size(); ++f) {
    if (!log_.feet[f].flat || !contacts_.loaded[c][f][k]) continue;
    const int s = log_.feet[f].sensor;
    const bool felt = s >= 0 && log_.sensors[static_cast<size_t>(s)].axis[2];
    share[f] = felt ? std::max(0.0, calc_vertical_force(log_, clip, static_cast<size_t>(s), k)) : 1.0;
    total += share[f];
  }
  if (total <= 0) return;
  Vector3d turns = Vector3d::Zero();  // of the feet, as gyroscope and encoders have it; IMU axes [rad/s]
  for (size_t f = 0; f < share.size(); ++f)
    turns += share[f] / total * (R_IB * get_velocity(motion->data(), log_.feet[f].link).head<3>());
  const Vector3d reading = get_values(clip.imus[i].gyro, k);
  put(channels_[i].gyro, kGyroScaleColumn, static_cast<int>(i), reading, get_rates(clip.imus[i].gyro, k),
      reading - turns);
  for (size_t f = 0; f < share.size(); ++f) {
    if (share[f] <= 0) continue;
    const Matrix3d R_IF = R_IB * get_pose(motion->data(), log_.feet[f].link).R;
    const Vector3d rate = get_moment_rate(log_, log_.feet[f], clip, k);
    for (int a = 0; a < 3; ++a) {
      table_.add(channels_[i].gyro[a], layout_.foot(static_cast<int>(f), kRollGiveColumn),
                 -share[f] / total * R_IF(a, 0) * rate.x());
      table_.add(channels_[i].gyro[a], layout_.foot(static_cast<int>(f), kPitchGiveColumn),
                 -share[f] / total * R_IF(a, 1) * rate.y());
    }
  }
}

void ImuRows::add_accelerometer(size_t i, const Clip& clip, size_t k, BodyMotion* motion) {
  if (channels_[i].accelerometer[0] < 0) return;
  const ImuSensor& imu = log_.imus[i];
  const Transform X = get_pose(motion->data(), imu.link);
  const Vector3d p = X * imu.p_LI;
  const Vector3d reading = get_values(clip.imus[i].accelerometer, k), rate = get_rates(clip.imus[i].accelerometer, k);
  Vector3d force = calc_point_acceleration(motion->data(), imu.link, p).tail<3>();
  if (log_.base_pose) {  // what the base's pose says of its origin stands in for what the main IMU says
    const Vector3d second(clip.base_position[0].second[k], clip.base_position[1].second[k],
                          clip.base_position[2].second[k]);
    const Eigen::Quaterniond q(clip.base_attitude[0].value[k], clip.base_attitude[1].value[k],
                               clip.base_attitude[2].value[k], clip.base_attitude[3].value[k]);
    force += q.normalized().conjugate() * (second - log_.experiment->scenario.gravity_W) - motion->vdot().segment<3>(3);
  }
  put(channels_[i].accelerometer, kAccelerometerScaleColumn, static_cast<int>(i), reading, rate,
      imu.R_LI.transpose() * X.R.transpose() * force);
}

// A body at rest feels its weight. Without an attitude only how much of it is known, not where from.
void ImuRows::add_gravity(size_t i, size_t c, size_t k, BodyMotion*) {
  const Clip& clip = log_.clips[c];
  if (channels_[i].gravity < 0) return;
  const Vector3d w = log_.imus[i].gyro ? get_values(clip.imus[i].gyro, k) : Vector3d::Zero();
  const Vector3d reading = get_values(clip.imus[i].accelerometer, k), rate = get_rates(clip.imus[i].accelerometer, k);
  const int all = get_phase_of_all(log_);
  if (w.norm() > kQuietRate || rate.norm() > kQuietForce || contacts_.find_phase(c, k) != all) return;
  const double g = log_.experiment->scenario.gravity_W.norm();
  const Vector3d along = reading.normalized();
  const int channel = channels_[i].gravity;
  table_.begin_row(channel, reading.norm() - g, reading.norm());
  table_.add(channel, layout_.imu(static_cast<int>(i), kAccelerometerScaleColumn), g);
  for (int a = 0; a < 3; ++a)
    table_.add(channel, layout_.imu(static_cast<int>(i), kAccelerometerBiasColumn + a), along(a));
}

void ImuRows::add(size_t clip, size_t k, BodyMotion* motion) {
  for (size_t i = 0; i < log_.imus.size(); ++i) {
    channels_[i].over_feet ? add_gyro_over_feet(i, clip, k, motion) : add_gyro(i, log_.clips[clip], k, motion);
    add_accelerometer(i, log_.clips[clip], k, motion);
    add_gravity(i, clip, k, motion);
  }
}

}  // namespace hrp::diagnosis::floating
