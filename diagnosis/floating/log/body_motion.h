// SPDX-License-Identifier: BSD-3-Clause
// How the body moves at a sample, from whichever sensors tell it. Everything is in the axes of the base: the equations
// of motion need rate, its derivative and specific force of the base there, and no attitude.
#pragma once

#include <functional>
#include <map>
#include <utility>

#include "common/multibody/inverse_dynamics.h"
#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis::floating {

// Samples from one to the next where a mean is all that is asked for: neighbours are alike.
constexpr size_t kStride = 5;

// Where rate and specific force of the base come from. kFoot: flat feet stand on the ground and do not move.
enum class MotionSource { kNone, kFixed, kImu, kPose, kFoot };

class BodyMotion {
 public:
  BodyMotion(const LeggedLog& log, const Clip& clip);
  BodyMotion(const BodyMotion&) = delete;
  BodyMotion& operator=(const BodyMotion&) = delete;

  // Which sources this recording has, best first.
  static MotionSource find_rate_source(const LeggedLog& log);
  static MotionSource find_force_source(const LeggedLog& log);
  static int find_main_imu(const LeggedLog& log);  // -1: none with a gyroscope

  // State, velocities and accelerations at sample k. False where the sources say nothing.
  bool update(size_t k);

  // From the next update() on, joint j stands so much further than its encoder says, about its own axis (0) or one
  // across (1, 2; get_cross_axis).
  void turn_joint(int j, int axis, double angle);
  // The same of the main IMU's gyroscope: it reads so much more [rad/s], and its rate so much [rad/s^2], in its axes.
  void add_gyro(const Vector3d& more, const Vector3d& more_rate) {
    more_gyro_ = more;
    more_gyro_rate_ = more_rate;
  }

  const Model& model() const { return *now_; }
  Data& data() { return data_; }
  const State& state() const { return state_; }
  const Eigen::VectorXd& vdot() const { return vdot_; }  // [alpha; specific force of the base's origin; qdd], base axes
  const Vector3d& rate() const { return w_; }
  // Upwards in base axes: from an attitude, else from gyroscope and specific force over seconds.
  Vector3d find_up(size_t k) const;
  bool has_attitude() const { return has_attitude_; }
  Matrix3d find_attitude(size_t k) const;  // R_WB; yaw means nothing where no attitude was recorded
  // [m] of the base in the world from where the recording began: from the base's pose, else by the feet that stand.
  Vector3d find_place(size_t k);

 private:
  void read_joints(size_t k);
  bool is_felt_over_joints() const;
  void find_rate(size_t k);
  void find_force(size_t k);
  void find_attitudes();
  void find_slow_attitudes();
  void find_foot_attitudes();
  Eigen::Quaterniond find_foot_attitude(size_t k) const;
  double find_load(size_t foot, size_t k) const;
  Vector3d calc_feet_mean(size_t k, const std::function<Vector3d(const Foot&)>& of) const;

  const LeggedLog& log_;
  const Clip& clip_;
  Model model_;
  Data data_;
  State state_;
  Eigen::VectorXd vdot_;
  MotionSource rate_source_, force_source_;
  int imu_ = -1, accelerometer_ = -1;
  bool has_attitude_ = false;
  bool over_feet_ = false;  // the attitude follows from flat feet, so that a joint that is turned turns it
  int turned_ = -1;
  double turn_ = 0;
  const Model* now_ = &model_;                                    // with the joint that is turned
  std::map<std::pair<int, int>, std::pair<double, Model>> bent_;  // by joint and axis
  Vector3d more_gyro_{0, 0, 0}, more_gyro_rate_{0, 0, 0};
  Vector3d w_{0, 0, 0};
  std::vector<Eigen::Quaterniond> attitude_;  // R_WB by sample; empty: unknown
  std::vector<Vector3d> place_;               // by sample; empty: not asked for yet
};

// Rate and its derivative in body axes from a unit quaternion's tracks (w x y z) at a sample.
void calc_quaternion_rates(const Track* wxyz, size_t k, Vector3d* w, Vector3d* dw);

}  // namespace hrp::diagnosis::floating
