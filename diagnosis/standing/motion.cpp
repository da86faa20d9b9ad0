// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/motion.h"

#include "common/multibody/kinematics.h"
#include "diagnosis/data/command_reader.h"

namespace hrp::diagnosis::standing {

StandMotion::StandMotion(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording,
                         PlayOffsets offsets)
    : p_(problem),
      r_(problem.recordings[recording]),
      terms_(problem, hypothesis),
      model_(terms_.tree, problem.experiment->scenario.gravity_W),
      data_(model_),
      state_(make_state(model_)),
      wrenches_(terms_.tree.links.size(), Vector6d::Zero()),
      vdot_(model_.nv()),
      drives_(problem, r_, terms_),
      joints_(static_cast<size_t>(model_.num_joints())),
      force_(problem.feet.size()),
      torque_(problem.feet.size()),
      offsets_(std::move(offsets)) {}

// Value or rate of a sensor's series at sample k, corrected for its delay [s] and clock skew [1].
double StandMotion::shifted(const SmoothSeries& s, bool rate, size_t k, double delay, double skew) {
  const std::vector<double>& values = rate ? s.rate : s.value;
  if (delay == 0 && skew == 0) return values[k];
  const double t = (r_.time[k] + delay) / (1 + skew);
  known_ = known_ && t >= r_.time.front() && t <= r_.time.back();
  return interpolate(r_.time, values, t, k);
}

void StandMotion::read_imu(size_t k) {
  const ImuTerms& imu = terms_.imu;
  Eigen::Vector4d q;
  for (int i = 0; i < 4; ++i) q(i) = shifted(r_.attitude[i], false, k, imu.attitude.delay, imu.attitude.clock_skew);
  const Eigen::Quaterniond attitude = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized();
  Vector3d w, dw, f;
  for (int i = 0; i < 3; ++i) {
    w(i) = shifted(r_.gyro[i], false, k, imu.gyro.delay, imu.gyro.clock_skew);
    dw(i) = shifted(r_.gyro[i], true, k, imu.gyro.delay, imu.gyro.clock_skew);
    f(i) = shifted(r_.accelerometer[i], false, k, imu.accelerometer.delay, imu.accelerometer.clock_skew);
  }
  const Matrix3d R_attitude = make_rotation_from_rpy(imu.attitude.misalignment);
  const Matrix3d R_gyro = make_rotation_from_rpy(imu.gyro.misalignment);
  const double gyro_scale = imu.gyro.scale.x(), accelerometer_scale = imu.accelerometer.scale.x();
  w_ = R_gyro * Vector3d((w - imu.gyro.bias) / gyro_scale);
  dw_ = R_gyro * Vector3d(dw / gyro_scale);
  f_ = make_rotation_from_rpy(imu.accelerometer.misalignment) *
       Vector3d((f - imu.accelerometer.bias) / accelerometer_scale);
  R_WI_ = attitude.toRotationMatrix() * R_attitude.transpose();
}

// State of the joints from the encoders, and of the links behind elastic or loose transmissions.
void StandMotion::read_joints(size_t k, size_t sample) {
  for (int j = 0; j < model_.num_joints(); ++j) {
    const auto i = static_cast<size_t>(j);
    const JointTerms& terms = terms_.joints[i];
    const SmoothSeries& position = r_.position[i];
    double q = position.value[k], v = position.rate[k], a = position.second[k];
    if (terms.position.delay != 0) {
      const double t = r_.time[k] + terms.position.delay;
      q = interpolate(r_.time, position.value, t, k);
      v = interpolate(r_.time, position.rate, t, k);
      a = interpolate(r_.time, position.second, t, k);
    }
    const double scale = terms.position.scale.x();
    DriveState& s = joints_[i];
    s.encoder = (q - terms.position.bias.x()) / scale;
    s.velocity = v / scale;
    s.acceleration = a / scale;
    double bent = 0, bent_rate = 0, bent_second = 0;
    if (!offsets_[i].empty()) bent = offsets_[i][sample];
    if (terms.compliance != 0 && p_.is_driven(i)) {
      double rate = 0;
      bent += terms.compliance * (drives_.find_effort(i, k, s, &rate) - terms.laws.motor_inertia * s.acceleration);
      bent_rate = terms.compliance * rate;
      if (p_.effort[i]) bent_second = terms.compliance * r_.effort[i].second[k];
    }
    s.link = s.encoder - terms.laws.joint_offset - bent;
    state_.q(j) = s.link;
    state_.qd(j) = s.velocity - bent_rate;
    vdot_(6 + j) = s.acceleration - bent_second;
  }
}

void StandMotion::read_motion(size_t sample) {
  const auto k = static_cast<size_t>(r_.samples[sample]);
  known_ = true;
  read_imu(k);
  read_joints(k, sample);
  find_base_motion();
  read_wrenches(k);
}

// Attitude, angular velocity and accelerations of the base, from an IMU at any link.
void StandMotion::find_base_motion() {
  state_.R_WB.setIdentity();
  state_.p_WB.setZero();
  state_.V_WB.setZero();
  update_kinematics(model_, state_, &data_);
  const Matrix3d R_BI = get_pose(data_, p_.imu_link).R * p_.R_LI;
  const Vector3d w_BL = get_velocity(data_, p_.imu_link).head<3>();
  const Matrix3d R_WB = R_WI_ * R_BI.transpose();
  state_.R_WB = Eigen::Quaterniond(R_WB).normalized();
  state_.V_WB.head<3>() = R_WI_ * w_ - R_WB * w_BL;
  update_kinematics(model_, state_, &data_);
  const Vector3d p_WI = get_pose(data_, p_.imu_link) * p_.p_LI;
  vdot_.head<6>().setZero();
  update_accelerations(model_, vdot_, &data_);
  const Vector6d a0 = calc_point_acceleration(data_, p_.imu_link, p_WI);
  const Vector3d alpha_B = R_WI_ * dw_ - a0.head<3>();
  const Vector3d a_I = R_WI_ * f_ + p_.experiment->scenario.gravity_W;
  vdot_.head<3>() = alpha_B;
  vdot_.segment<3>(3) = a_I - alpha_B.cross(p_WI) - a0.tail<3>();
}

void StandMotion::read_wrenches(size_t k) {
  for (Vector6d& w : wrenches_) w.setZero();
  for (size_t link = 0; link < wrenches_.size(); ++link) {
    if (terms_.force_W[link].isZero()) continue;
    const Matrix3d R = get_pose(data_, static_cast<int>(link)).R;
    const Vector3d arm = R * terms_.tree.links[link].inertia.p_LLcm_L;
    wrenches_[link] << arm.cross(terms_.force_W[link]), terms_.force_W[link];
  }
  for (size_t foot = 0; foot < p_.feet.size(); ++foot) {
    const WrenchTerms& w = terms_.wrenches[foot];
    Vector3d force, torque;
    for (size_t i = 0; i < 3; ++i) {
      force(static_cast<long>(i)) = shifted(r_.wrench[6 * foot + i], false, k, w.force.delay, w.force.clock_skew);
      torque(static_cast<long>(i)) =
          shifted(r_.wrench[6 * foot + 3 + i], false, k, w.torque.delay, w.torque.clock_skew);
    }
    force_[foot] = make_rotation_from_rpy(w.force.misalignment) * Vector3d((force - w.force.bias) / w.force.scale.x());
    torque_[foot] =
        make_rotation_from_rpy(w.torque.misalignment) * Vector3d((torque - w.torque.bias) / w.torque.scale.x());
    const Matrix3d R = get_pose(data_, p_.feet[foot].link).R;
    wrenches_[static_cast<size_t>(p_.feet[foot].link)] << R * torque_[foot], R * force_[foot];
  }
}

}  // namespace hrp::diagnosis::standing
