// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/log/correct_log.h"

#include <algorithm>
#include <cmath>

#include "common/spatial/turn.h"

namespace hrp::diagnosis::floating {
namespace {

double shift_value(const std::vector<double>& v, double samples) {
  const double at = std::clamp(samples, 0.0, static_cast<double>(v.size() - 1));
  const auto below = static_cast<size_t>(at);
  const size_t above = std::min(below + 1, v.size() - 1);
  return v[below] + (at - static_cast<double>(below)) * (v[above] - v[below]);
}

// What is linear in a track holds for its rates, too.
template <class Apply>
void apply_to_all(Track* xyz, const Apply& apply) {
  for (std::vector<double> Track::*part : {&Track::value, &Track::rate, &Track::second}) {
    for (size_t k = 0; k < (xyz[0].*part).size(); ++k) {
      const Vector3d was((xyz[0].*part)[k], (xyz[1].*part)[k], (xyz[2].*part)[k]);
      const Vector3d is = apply(was, part == &Track::value);
      for (int i = 0; i < 3; ++i) (xyz[i].*part)[k] = is(i);
    }
  }
}

struct Fault {
  double scale = 1, delay = 0;  // [s]
  Vector3d bias{0, 0, 0}, turn{0, 0, 0};
};

// true(t) = (R(turn) reading(t + delay) - bias) / scale
void correct_vector(const Fault& fault, double step, Track* xyz) {
  const bool whole = !xyz[0].empty() && !xyz[1].empty() && !xyz[2].empty();
  for (int i = 0; i < 3; ++i) {
    if (!xyz[i].empty() && fault.delay != 0) xyz[i] = shift_track(xyz[i], step, fault.delay);
  }
  const Matrix3d R = make_turn(fault.turn).toRotationMatrix();
  if (whole) {
    apply_to_all(xyz, [&](const Vector3d& v, bool value) -> Vector3d {
      return (R * v - (value ? fault.bias : Vector3d::Zero())) / fault.scale;
    });
    return;
  }
  for (int i = 0; i < 3; ++i) {
    for (double& v : xyz[i].value) v = (v - fault.bias(i)) / fault.scale;
    for (double& v : xyz[i].rate) v /= fault.scale;
    for (double& v : xyz[i].second) v /= fault.scale;
  }
}

// An attitude that is turned by `turn` about its own axes: true = read R(turn)^-1, which is linear in the quaternion.
void correct_attitude(const Vector3d& turn, double delay, double step, Track* wxyz) {
  if (wxyz[0].empty()) return;
  for (int i = 0; i < 4 && delay != 0; ++i) wxyz[i] = shift_track(wxyz[i], step, delay);
  const Eigen::Quaterniond back(make_turn(-turn));
  for (std::vector<double> Track::*part : {&Track::value, &Track::rate, &Track::second}) {
    for (size_t k = 0; k < (wxyz[0].*part).size(); ++k) {
      const Eigen::Quaterniond q((wxyz[0].*part)[k], (wxyz[1].*part)[k], (wxyz[2].*part)[k], (wxyz[3].*part)[k]);
      const Eigen::Quaterniond p = q * back;
      (wxyz[0].*part)[k] = p.w();
      (wxyz[1].*part)[k] = p.x();
      (wxyz[2].*part)[k] = p.y();
      (wxyz[3].*part)[k] = p.z();
    }
  }
}

Vector3d get3(const Eigen::VectorXd& x, int first) { return x.segment<3>(first); }

void correct_sensor(const ColumnLayout& at, const Eigen::VectorXd& x, int s, Clip* clip) {
  Fault force{1 + x(at.sensor(s, kForceScaleColumn)), x(at.sensor(s, kWrenchDelayColumn)),
              get3(x, at.sensor(s, kForceBiasColumn)), get3(x, at.sensor(s, kWrenchTurnColumn))};
  Fault torque{1 + x(at.sensor(s, kTorqueScaleColumn)), force.delay, get3(x, at.sensor(s, kTorqueBiasColumn)),
               force.turn};
  correct_vector(force, clip->step, &clip->force[6 * static_cast<size_t>(s)]);
  correct_vector(torque, clip->step, &clip->force[6 * static_cast<size_t>(s) + 3]);
}

void correct_imu(const ColumnLayout& at, const Eigen::VectorXd& x, int i, Clip* clip) {
  ImuTracks& imu = clip->imus[static_cast<size_t>(i)];
  const auto read = [&](int first) {  // scale, bias, delay, turn, in the order of the columns
    return Fault{1 + x(at.imu(i, first)), x(at.imu(i, first + 4)), get3(x, at.imu(i, first + 1)),
                 get3(x, at.imu(i, first + 5))};
  };
  correct_vector(read(kAccelerometerScaleColumn), clip->step, imu.accelerometer);
  correct_vector(read(kGyroScaleColumn), clip->step, imu.gyro);
  correct_attitude(get3(x, at.imu(i, kAttitudeTurnColumn)), x(at.imu(i, kAttitudeDelayColumn)), clip->step,
                   imu.attitude);
}

// The log of an effort stays beside what the drive gives: the servo law is compared with the log.
void correct_drive(const ColumnLayout& at, const Eigen::VectorXd& x, int j, Clip* clip) {
  const auto i = static_cast<size_t>(j);
  const double lag = x(at.joint(j, kLagColumn)), delay = x(at.joint(j, kDelayColumn));
  if (lag > 0 && !clip->effort[i].empty()) {
    if (clip->logged.empty()) clip->logged = clip->effort;
    clip->effort[i] = lag_track(clip->effort[i], clip->step, lag);
  }
  if (delay == 0 || clip->command[i].empty()) return;
  clip->command[i] = shift_track(clip->command[i], clip->step, -delay);
  if (!clip->command_rate[i].empty()) clip->command_rate[i] = shift_track(clip->command_rate[i], clip->step, -delay);
}

}  // namespace

void correct_links(const ColumnLayout& layout, const Eigen::VectorXd& by_column, LeggedLog* log) {
  const auto about = [](double m, const Vector3d& c) {
    return Matrix3d(m * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose()));
  };
  for (int l = 0; l < layout.links; ++l) {
    const Eigen::VectorXd add = by_column.segment(layout.link(l, 0), kInertialParameters);  // columns.h
    LinkInertia& link = log->tree.links[static_cast<size_t>(l)].inertia;
    const double mass = link.mass + add(0);
    if (add.isZero() || mass <= 0) continue;
    const Vector3d c = (link.mass * link.p_LLcm_L + add.segment<3>(1)) / mass;
    Matrix3d I;  // about the link's origin
    I << add(4), add(5), add(6), add(5), add(7), add(8), add(6), add(8), add(9);
    link.I_LLcm_L += about(link.mass, link.p_LLcm_L) + I - about(mass, c);
    link.mass = mass;
    link.p_LLcm_L = c;
  }
}

Track lag_track(const Track& x, double step, double time) {
  Track y = x;
  // Exact for an input that is a line from sample to sample.
  const double keep = std::exp(-step / time);
  for (size_t k = 1; k < x.value.size(); ++k) {
    const double slope = (x.value[k] - x.value[k - 1]) / step;
    y.value[k] = x.value[k] - slope * time + keep * (y.value[k - 1] - x.value[k - 1] + slope * time);
  }
  for (size_t k = 0; k < x.value.size(); ++k) {
    y.rate[k] = (x.value[k] - y.value[k]) / time;
    y.second[k] = (x.rate[k] - y.rate[k]) / time;
  }
  return y;
}

Track shift_track(const Track& x, double step, double ahead) {
  Track y = x;
  for (std::vector<double> Track::*part : {&Track::value, &Track::rate, &Track::second}) {
    for (size_t k = 0; k < (x.*part).size(); ++k)
      (y.*part)[k] = shift_value(x.*part, static_cast<double>(k) + ahead / step);
  }
  return y;
}

bool is_correctable(const ColumnLayout& layout, int column) {
  if (column >= layout.sensor(0, 0) && column < layout.foot(0, 0)) return true;
  const int joint = column - layout.joint(0, 0), kind = joint % kJointColumns;
  return joint >= 0 && column < layout.sensor(0, 0) && (kind == kLagColumn || kind == kDelayColumn);
}

void correct_log(const ColumnLayout& layout, const Eigen::VectorXd& x, LeggedLog* log) {
  for (Clip& clip : log->clips) {
    for (int s = 0; s < layout.sensors; ++s) correct_sensor(layout, x, s, &clip);
    for (int i = 0; i < layout.imus; ++i) correct_imu(layout, x, i, &clip);
    for (int j = 0; j < layout.joints; ++j) correct_drive(layout, x, j, &clip);
  }
}

}  // namespace hrp::diagnosis::floating
