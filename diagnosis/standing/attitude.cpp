// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/attitude.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "common/spatial/turn.h"

namespace hrp::diagnosis::standing {
namespace {

using Eigen::Quaterniond;

constexpr double kDrift = 1.0;  // [s] half the window in which the gyroscope's drift is fitted by a cubic

Vector3d get(const SmoothSeries (&s)[3], size_t k) { return {s[0].value[k], s[1].value[k], s[2].value[k]}; }
Vector3d get_rate(const SmoothSeries (&s)[3], size_t k) { return {s[0].rate[k], s[1].rate[k], s[2].rate[k]}; }

class AttitudeFinder {
 public:
  AttitudeFinder(const StandProblem& problem, StandRecording* recording)
      : p_(problem), r_(*recording), model_(problem.tree), data_(model_), state_(make_state(model_)) {}

  double run() {
    const bool known = !r_.base_attitude[0].value.empty();
    const double error = known ? take_base_pose() : integrate();
    write();
    return error;
  }

 private:
  size_t count() const { return r_.time.size(); }

  // Orientation of the IMU in the base, and the mean position of the feet relative to the IMU in its axes [m], from the
  // encoders.
  void place(size_t k, Matrix3d* R_BI, Vector3d* foot_I) {
    for (int j = 0; j < model_.num_joints(); ++j) state_.q(j) = r_.position[static_cast<size_t>(j)].value[k];
    state_.R_WB.setIdentity();
    state_.p_WB.setZero();
    update_kinematics(model_, state_, &data_);
    const Transform X = get_pose(data_, p_.imu_link);
    *R_BI = X.R * p_.R_LI;
    foot_I->setZero();
    for (const StandFoot& foot : p_.feet) {
      const Vector3d at = get_pose(data_, foot.link) * foot.bush - X * p_.p_LI;
      *foot_I += R_BI->transpose() * at / static_cast<double>(p_.feet.size());
    }
  }

  double take_base_pose() {
    for (size_t k = 0; k < count(); ++k) {
      Matrix3d R_BI;
      Vector3d foot_I;
      place(k, &R_BI, &foot_I);
      const SmoothSeries* q = r_.base_attitude;
      const Quaterniond base(q[0].value[k], q[1].value[k], q[2].value[k], q[3].value[k]);
      attitude_.push_back(base.normalized() * Quaterniond(R_BI));
    }
    return 0;
  }

  // Direction of gravity in the IMU's axes. The feet stand, so the IMU accelerates only by its rotation about them and
  // by the joints: f + g_I = a_I = -(dw x r + w x (w x r) + 2 w x dr + ddr), with r from the IMU to the feet.
  std::vector<Vector3d> find_gravity() {
    std::vector<Vector3d> at(count()), down(count());
    for (size_t k = 0; k < count(); ++k) {
      Matrix3d R_BI;
      place(k, &R_BI, &at[k]);
    }
    const auto reach = static_cast<size_t>(r_.window);
    for (size_t k = 0; k < count(); ++k) {
      const size_t a = k >= reach ? k - reach : 0, b = std::min(count() - 1, k + reach);
      const double before = r_.time[k] - r_.time[a], after = r_.time[b] - r_.time[k];
      Vector3d rate = (at[b] - at[a]) / (before + after), second = Vector3d::Zero();
      if (before > 0 && after > 0) {
        second = 2 * ((at[b] - at[k]) / after - (at[k] - at[a]) / before) / (before + after);
      }
      const Vector3d w = get(r_.gyro, k), dw = get_rate(r_.gyro, k);
      const Vector3d moved = dw.cross(at[k]) + w.cross(w.cross(at[k])) + 2 * w.cross(rate) + second;
      down[k] = -(get(r_.accelerometer, k) + moved).normalized();
    }
    return down;
  }

  double integrate() {
    const std::vector<Vector3d> down = find_gravity();
    Vector3d first = Vector3d::Zero();
    for (size_t k = 0; k < std::min<size_t>(count(), 20); ++k) first += down[k];
    attitude_.push_back(Quaterniond::FromTwoVectors(first, -Vector3d::UnitZ()));
    for (size_t k = 1; k < count(); ++k) {
      const Vector3d mean = 0.5 * (get(r_.gyro, k - 1) + get(r_.gyro, k));
      attitude_.push_back((attitude_.back() * make_turn(mean * (r_.time[k] - r_.time[k - 1]))).normalized());
    }
    std::vector<double> drift[2];
    for (size_t k = 0; k < count(); ++k) {
      const Vector3d off = (attitude_[k] * down[k]).cross(-Vector3d::UnitZ());
      drift[0].push_back(off.x());
      drift[1].push_back(off.y());
    }
    const double step = (r_.time.back() - r_.time.front()) / static_cast<double>(count() - 1);
    const int half = std::min(static_cast<int>(count() / 3), static_cast<int>(kDrift / step));
    const Smoother smoother(r_.time, half, Parity::kAll);
    const SmoothSeries x = smoother.run(drift[0]), y = smoother.run(drift[1]);
    double sum = 0;
    for (size_t k = 0; k < count(); ++k) {
      attitude_[k] = make_turn({x.value[k], y.value[k], 0}) * attitude_[k];
      sum += std::pow(drift[0][k] - x.value[k], 2) + std::pow(drift[1][k] - y.value[k], 2);
    }
    // The inputs are smoothed over one window already, so windows are the independent samples. The value of a local
    // cubic has 9/4 of the variance of a mean, hence the factor 1.5.
    const double scatter = std::sqrt(sum / (2.0 * static_cast<double>(count())));
    const double independent = std::max(1.0, 2.0 * half / static_cast<double>(r_.window));
    return 1.5 * scatter / std::sqrt(independent);
  }

  void write() {
    for (SmoothSeries& s : r_.attitude) s = SmoothSeries{};
    for (size_t k = 0; k < count(); ++k) {
      if (k > 0 && attitude_[k].coeffs().dot(attitude_[k - 1].coeffs()) < 0) attitude_[k].coeffs() *= -1;
      const double wxyz[4] = {attitude_[k].w(), attitude_[k].x(), attitude_[k].y(), attitude_[k].z()};
      for (int i = 0; i < 4; ++i) r_.attitude[i].value.push_back(wxyz[i]);
    }
    for (SmoothSeries& s : r_.attitude) {
      for (size_t k = 0; k < count(); ++k) {
        const size_t a = k > 0 ? k - 1 : 0, b = std::min(count() - 1, k + 1);
        s.rate.push_back((s.value[b] - s.value[a]) / (r_.time[b] - r_.time[a]));
      }
    }
  }

  const StandProblem& p_;
  StandRecording& r_;
  Model model_;
  Data data_;
  State state_;
  std::vector<Quaterniond> attitude_;
};

}  // namespace

double find_attitude(const StandProblem& problem, StandRecording* recording) {
  return AttitudeFinder(problem, recording).run();
}

}  // namespace hrp::diagnosis::standing
