// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/log/body_motion.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "common/spatial/turn.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/floating/checks/flat_feet.h"
#include "diagnosis/floating/equations/joint_turns.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

// q^-1 dq/dt = w / 2 and q^-1 d2q/dt2 = dw / 2 - w.w / 4, w in body axes.
void calc_quaternion_rates(const Track* wxyz, size_t k, Vector3d* w, Vector3d* dw) {
  const Eigen::Quaterniond q = get_quaternion(wxyz, k);
  const Eigen::Quaterniond rate(wxyz[0].rate[k], wxyz[1].rate[k], wxyz[2].rate[k], wxyz[3].rate[k]);
  const Eigen::Quaterniond second(wxyz[0].second[k], wxyz[1].second[k], wxyz[2].second[k], wxyz[3].second[k]);
  *w = 2 * (q.conjugate() * rate).vec();
  *dw = 2 * (q.conjugate() * second).vec();
}

int BodyMotion::find_main_imu(const LeggedLog& log) {
  int best = -1;
  for (size_t i = 0; i < log.imus.size(); ++i) {
    if (!log.imus[i].gyro) continue;
    const bool better = best < 0 || (!log.imus[static_cast<size_t>(best)].accelerometer && log.imus[i].accelerometer);
    const bool nearer = best >= 0 && log.imus[i].link == 0 && log.imus[static_cast<size_t>(best)].link != 0 &&
                        log.imus[i].accelerometer;
    if (better || nearer) best = static_cast<int>(i);
  }
  return best;
}

MotionSource BodyMotion::find_rate_source(const LeggedLog& log) {
  if (!log.experiment->scenario.floating_base) return MotionSource::kFixed;
  if (find_main_imu(log) >= 0) return MotionSource::kImu;
  if (log.base_pose) return MotionSource::kPose;
  return has_flat_foot(log) ? MotionSource::kFoot : MotionSource::kNone;
}

MotionSource BodyMotion::find_force_source(const LeggedLog& log) {
  if (!log.experiment->scenario.floating_base) return MotionSource::kFixed;
  const int imu = find_main_imu(log);
  if (imu >= 0 && log.imus[static_cast<size_t>(imu)].accelerometer) return MotionSource::kImu;
  if (log.base_pose) return MotionSource::kPose;
  return has_flat_foot(log) ? MotionSource::kFoot : MotionSource::kNone;
}

BodyMotion::BodyMotion(const LeggedLog& log, const Clip& clip)
    : log_(log),
      clip_(clip),
      model_(log.tree, log.tree.floating_base ? Vector3d::Zero() : log.experiment->scenario.gravity_W),
      data_(model_),
      state_(make_state(model_)),
      vdot_(Eigen::VectorXd::Zero(model_.nv())),
      rate_source_(find_rate_source(log)),
      force_source_(find_force_source(log)),
      imu_(find_main_imu(log)) {
  find_attitudes();
}

void BodyMotion::turn_joint(int j, int axis, double angle) {
  turned_ = axis == 0 ? j : -1;
  turn_ = angle;
  now_ = &model_;
  if (axis == 0 || angle == 0) return;
  auto at = bent_.find({j, axis});
  if (at == bent_.end() || at->second.first != angle) {
    TreeSpec tree = model_.spec();
    JointSpec& joint = tree.joint(j);
    joint.X_PF.R = joint.X_PF.R * make_turn(angle * get_cross_axis(joint, axis)).toRotationMatrix();
    at = bent_.insert_or_assign({j, axis}, std::pair(angle, Model(tree, model_.gravity_W()))).first;
  }
  now_ = &at->second.second;
}

void BodyMotion::read_joints(size_t k) {
  const int base = model_.num_base();
  for (int j = 0; j < model_.num_joints(); ++j) {
    const Track& t = clip_.position[static_cast<size_t>(j)];
    state_.q(j) = t.empty() ? 0.0 : t.value[k];
    state_.qd(j) = t.empty() ? 0.0 : t.rate[k];
    vdot_(base + j) = t.empty() ? 0.0 : t.second[k];
  }
  if (turned_ >= 0) state_.q(turned_) += turn_;
}

// Whether joints are between the base and what tells its rate. find_rate() then needs poses, and leaves the velocities
// that follow from that rate.
bool BodyMotion::is_felt_over_joints() const {
  const bool further_out = imu_ >= 0 && log_.imus[static_cast<size_t>(imu_)].link != 0;
  return rate_source_ == MotionSource::kFoot || (rate_source_ == MotionSource::kImu && further_out);
}

// Rate of the base and its derivative. An IMU further out feels the joints between, too.
void BodyMotion::find_rate(size_t k) {
  Vector3d dw = Vector3d::Zero();
  w_.setZero();
  if (rate_source_ == MotionSource::kPose) calc_quaternion_rates(clip_.base_attitude, k, &w_, &dw);
  if (rate_source_ == MotionSource::kImu && !is_felt_over_joints()) {
    const auto i = static_cast<size_t>(imu_);
    w_ = log_.imus[i].R_LI * (get_values(clip_.imus[i].gyro, k) + more_gyro_);
    dw = log_.imus[i].R_LI * (get_rates(clip_.imus[i].gyro, k) + more_gyro_rate_);
  } else if (rate_source_ == MotionSource::kImu) {
    const auto i = static_cast<size_t>(imu_);
    const ImuSensor& imu = log_.imus[i];
    const Matrix3d R_BI = get_pose(data_, imu.link).R * imu.R_LI;
    w_ = R_BI * (get_values(clip_.imus[i].gyro, k) + more_gyro_) - get_velocity(data_, imu.link).head<3>();
    state_.V_WB.head<3>() = w_;
    update_kinematics(*now_, state_, &data_);
    vdot_.head<6>().setZero();
    update_accelerations(*now_, vdot_, &data_);
    const Vector3d alpha0 = calc_point_acceleration(data_, imu.link, get_pose(data_, imu.link).p).head<3>();
    // d(R_WI w_I)/dt = R_WI dw_I: of a vector in the IMU's axes, its own rate adds nothing.
    dw = R_BI * (get_rates(clip_.imus[i].gyro, k) + more_gyro_rate_) - alpha0;
  }
  if (rate_source_ == MotionSource::kFoot) {
    w_ = -calc_feet_mean(k, [this](const Foot& f) -> Vector3d { return get_velocity(data_, f.link).head<3>(); });
    state_.V_WB.head<3>() = w_;
    update_kinematics(*now_, state_, &data_);
    vdot_.head<6>().setZero();
    update_accelerations(*now_, vdot_, &data_);
    dw = -calc_feet_mean(k, [this](const Foot& f) -> Vector3d {
      return calc_point_acceleration(data_, f.link, get_pose(data_, f.link).p).head<3>();
    });
  }
  vdot_.head<3>() = dw;
}

void BodyMotion::find_force(size_t k) {
  Vector3d a = Vector3d::Zero();
  const Vector3d& g_W = log_.experiment->scenario.gravity_W;
  if (force_source_ == MotionSource::kImu) {
    const auto i = static_cast<size_t>(imu_);
    const ImuSensor& imu = log_.imus[i];
    const Transform X_BL = get_pose(data_, imu.link);
    const Vector3d f = X_BL.R * imu.R_LI * get_values(clip_.imus[i].accelerometer, k);
    vdot_.segment<3>(3).setZero();
    update_accelerations(*now_, vdot_, &data_);
    a = f - calc_point_acceleration(data_, imu.link, X_BL * imu.p_LI).tail<3>();
  } else if (force_source_ == MotionSource::kPose) {
    const Vector3d second(clip_.base_position[0].second[k], clip_.base_position[1].second[k],
                          clip_.base_position[2].second[k]);
    a = get_quaternion(clip_.base_attitude, k).conjugate() * (second - g_W);
  } else if (force_source_ == MotionSource::kFoot && !attitude_.empty()) {
    vdot_.segment<3>(3).setZero();
    update_accelerations(*now_, vdot_, &data_);
    a = attitude_[k].conjugate() * -g_W - calc_feet_mean(k, [this](const Foot& f) -> Vector3d {
          return calc_point_acceleration(data_, f.link, get_pose(data_, f.link) * f.p_LC).tail<3>();
        });
  }
  vdot_.segment<3>(3) = a;
}

bool BodyMotion::update(size_t k) {
  state_.R_WB.setIdentity();
  state_.p_WB.setZero();
  state_.V_WB.setZero();
  read_joints(k);
  if (!model_.floating()) {
    state_.R_WB = make_rotation_from_rpy(log_.experiment->scenario.initial_rpy);
    update_kinematics(*now_, state_, &data_);
    update_accelerations(*now_, vdot_, &data_);
    return true;
  }
  if (is_felt_over_joints() || over_feet_) update_kinematics(*now_, state_, &data_);
  if (over_feet_) attitude_[k] = find_foot_attitude(k);
  find_rate(k);
  state_.V_WB.head<3>() = w_;
  if (!is_felt_over_joints()) update_kinematics(*now_, state_, &data_);
  find_force(k);
  update_accelerations(*now_, vdot_, &data_);
  return true;
}

Matrix3d BodyMotion::find_attitude(size_t k) const {
  if (!model_.floating()) return Matrix3d::Identity();
  return attitude_.empty() ? Matrix3d(Matrix3d::Identity()) : attitude_[k].toRotationMatrix();
}

Vector3d BodyMotion::find_up(size_t k) const {
  Vector3d up = -log_.experiment->scenario.gravity_W.normalized();
  if (!model_.floating()) return up;
  return find_attitude(k).transpose() * up;
}

Vector3d BodyMotion::find_place(size_t k) {
  if (log_.base_pose) return get_values(clip_.base_position, k) - get_values(clip_.base_position, 0);
  Vector3d place = Vector3d::Zero();
  for (size_t i = place_.size(); i < clip_.size(); ++i) {  // the ground holds the feet that stand
    update(i);
    const Vector3d back = calc_feet_mean(i, [this](const Foot& f) -> Vector3d {
      const Vector6d V = get_velocity(data_, f.link);
      const Transform X = get_pose(data_, f.link);
      return V.tail<3>() + V.head<3>().cross(X.R * f.p_LC);
    });
    place -= clip_.step * (find_attitude(i) * back);
    place_.push_back(place);
  }
  update(k);
  return place_[k];
}

// An IMU's own attitude first, as it is the sensor that is recorded most often; then the base's pose.
void BodyMotion::find_attitudes() {
  if (!model_.floating()) return void(has_attitude_ = true);
  for (size_t i = 0; i < log_.imus.size() && attitude_.empty(); ++i) {
    if (!log_.imus[i].attitude || (imu_ >= 0 && static_cast<int>(i) != imu_)) continue;
    for (size_t k = 0; k < clip_.size(); ++k) {
      state_.R_WB.setIdentity();
      read_joints(k);
      update_kinematics(*now_, state_, &data_);
      const Matrix3d R_BI = get_pose(data_, log_.imus[i].link).R * log_.imus[i].R_LI;
      attitude_.push_back(get_quaternion(clip_.imus[i].attitude, k) * Eigen::Quaterniond(R_BI).conjugate());
    }
  }
  if (attitude_.empty() && log_.base_pose) {
    for (size_t k = 0; k < clip_.size(); ++k) attitude_.push_back(get_quaternion(clip_.base_attitude, k));
  }
  has_attitude_ = !attitude_.empty();
  if (attitude_.empty() && imu_ >= 0 && log_.imus[static_cast<size_t>(imu_)].accelerometer) find_slow_attitudes();
  if (attitude_.empty() && force_source_ == MotionSource::kFoot) find_foot_attitudes();
}

// [N or the sensor's unit] What a flat foot bears, to weigh feet against each other; without sensors all count alike.
double BodyMotion::find_load(size_t f, size_t k) const {
  const Foot& foot = log_.feet[f];
  if (!foot.flat) return 0;
  if (foot.sensor < 0 || !log_.sensors[static_cast<size_t>(foot.sensor)].axis[2]) return 1;
  return std::max(0.0, calc_vertical_force(log_, clip_, static_cast<size_t>(foot.sensor), k));
}

// Of flat feet, by what they bear: so nothing jumps where the weight goes from one to the other.
Vector3d BodyMotion::calc_feet_mean(size_t k, const std::function<Vector3d(const Foot&)>& of) const {
  Vector3d sum = Vector3d::Zero(), plain = sum;
  double total = 0, count = 0;
  for (size_t f = 0; f < log_.feet.size(); ++f) {
    if (!log_.feet[f].flat) continue;
    const Vector3d v = of(log_.feet[f]);
    const double load = find_load(f, k);
    sum += load * v;
    total += load;
    plain += v;
    count += 1;
  }
  return total > 0 ? Vector3d(sum / total) : Vector3d(plain / std::max(1.0, count));
}

// Nothing else tells it: flat feet lie on level ground. `data_` has the pose of the joints.
Eigen::Quaterniond BodyMotion::find_foot_attitude(size_t k) const {
  const Vector3d up = -log_.experiment->scenario.gravity_W.normalized();
  const Vector3d normal =
      calc_feet_mean(k, [this](const Foot& f) -> Vector3d { return get_pose(data_, f.link).R.col(2); });
  return Eigen::Quaterniond::FromTwoVectors(normal, up);
}

void BodyMotion::find_foot_attitudes() {
  over_feet_ = true;
  for (size_t k = 0; k < clip_.size(); ++k) {
    state_.R_WB.setIdentity();
    read_joints(k);
    update_kinematics(*now_, state_, &data_);
    attitude_.push_back(find_foot_attitude(k));
  }
}

// The gyroscope integrated; in its axes, which drift slowly, the specific force points up on average over steps.
void BodyMotion::find_slow_attitudes() {
  const auto i = static_cast<size_t>(imu_);
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  std::vector<Eigen::Quaterniond> drifting;
  std::vector<Vector3d> force;
  for (size_t k = 0; k < clip_.size(); ++k) {
    read_joints(k);
    update_kinematics(*now_, state_, &data_);
    const Matrix3d R_BI = get_pose(data_, log_.imus[i].link).R * log_.imus[i].R_LI;
    if (k > 0) q = (q * make_turn(clip_.step * get_values(clip_.imus[i].gyro, k))).normalized();
    drifting.push_back(q * Eigen::Quaterniond(R_BI).conjugate());
    force.push_back(q * get_values(clip_.imus[i].accelerometer, k));
  }
  const auto n = static_cast<long>(clip_.size()), stride = std::max(1L, std::lround(0.02 / clip_.step));
  const auto half = std::lround(3 * kStepTakes / clip_.step);
  const Vector3d up = -log_.experiment->scenario.gravity_W.normalized();
  for (long k = 0; k < n; ++k) {
    Vector3d sum = Vector3d::Zero();
    for (long s = std::max(0L, k - half); s <= std::min(n - 1, k + half); s += stride) {
      sum += std::exp(-0.5 * std::pow(static_cast<double>(s - k) * clip_.step / kStepTakes, 2)) *
             force[static_cast<size_t>(s)];
    }
    attitude_.push_back(Eigen::Quaterniond::FromTwoVectors(sum, up) * drifting[static_cast<size_t>(k)]);
  }
}

}  // namespace hrp::diagnosis::floating
