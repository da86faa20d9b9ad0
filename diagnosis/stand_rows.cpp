// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/stand_rows.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"

namespace hrp::diagnosis {
namespace {

constexpr int kHalf = 12;      // samples of the local cubics over IMU and wrenches
constexpr size_t kSkip = 5;    // samples between two that are kept

struct Channel {
  std::vector<double> value, rate, second;
};

Channel smooth(const Recording& r, const std::string& name) {
  Channel c;
  smooth_series(r.time, r.other.at(name), kHalf, &c.value, &c.rate, &c.second);
  return c;
}

struct Axes {
  Channel c[3];
  Vector3d at(size_t k) const { return {c[0].value[k], c[1].value[k], c[2].value[k]}; }
};

Axes smooth_axes(const Recording& r, const std::string& base) {
  Axes axes;
  const char* const names[] = {"/x", "/y", "/z"};
  for (int i = 0; i < 3; ++i) axes.c[i] = smooth(r, base + names[i]);
  return axes;
}

// Attitude by its four components, made a unit again.
std::vector<Matrix3d> smooth_attitude(const Recording& r, const std::string& base) {
  const char* const names[] = {"/w", "/x", "/y", "/z"};
  Channel c[4];
  for (int i = 0; i < 4; ++i) c[i] = smooth(r, base + names[i]);
  std::vector<Matrix3d> R;
  for (size_t k = 0; k < r.size(); ++k) {
    Eigen::Quaterniond q(c[0].value[k], c[1].value[k], c[2].value[k], c[3].value[k]);
    R.push_back(q.normalized().toRotationMatrix());
  }
  return R;
}

int find_link(const Experiment& e, const std::string& name, Transform* X_LF) {
  const int frame = e.robot.tree.find_frame(name);
  if (frame < 0) return -1;
  *X_LF = e.robot.tree.frames[static_cast<size_t>(frame)].X_LF;
  return e.robot.tree.frames[static_cast<size_t>(frame)].link;
}

// Centre of the lower face of a foot's sole shapes, link axes.
Vector3d find_sole_centre(const Experiment& e, int link) {
  Vector3d low = Vector3d::Constant(1e9), high = Vector3d::Constant(-1e9);
  for (const CollisionShape& shape : e.robot.shapes) {
    if (shape.link != link || shape.kind != ShapeKind::kBox) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d s(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
      const Vector3d p = shape.X_LG.R * shape.size.cwiseProduct(s) + shape.X_LG.p;
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
  }
  if (low.x() > 1e8) return Vector3d::Zero();
  return {0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), low.z()};
}

}  // namespace

struct StandRecording::Smooth {
  int imu_link = 0;
  Matrix3d R_LI = Matrix3d::Identity();
  Vector3d p_LI = Vector3d::Zero();
  std::vector<Matrix3d> R_WI;
  std::vector<Vector3d> attitude_rate;       // [rad/s] of R_WI, sensor axes
  Axes gyro, acc;
  std::vector<Axes> force, torque;
  std::vector<std::vector<double>> servo;    // by joint
  Channel base_z;
  StandSeries frame;                         // without samples

  Matrix3d attitude(size_t k, const StandChange& change) const { return R_WI[k] * make_rotation_from_rpy(change.attitude_turn); }
};

namespace {

class Builder {
 public:
  Builder(const Problem& problem, int recording, const StandRecording::Smooth& smooth, const StandChange& change)
      : e_(*problem.experiment), r_(e_.recordings[static_cast<size_t>(recording)]),
        smooth_(problem.smooth[static_cast<size_t>(recording)]), s_(smooth), change_(change),
        plant_(make_plant(e_, change.effects)), data_(*plant_.model), state_(make_state(*plant_.model)), n_(e_.num_joints()) {}

  StandSeries build() {
    StandSeries out = s_.frame;
    find_base_rates();
    for (size_t k = kHalf; k + kHalf < r_.size(); k += kSkip) out.samples.push_back(make_sample(k));
    return out;
  }

 private:
  void set_state(size_t k) {
    for (int j = 0; j < n_; ++j) {
      state_.q[j] = smooth_.joints[static_cast<size_t>(j)].q[k] - plant_.laws[static_cast<size_t>(j)].joint_offset;
      state_.qd[j] = smooth_.joints[static_cast<size_t>(j)].qd[k];
    }
  }

  // Angular velocity of the base at every sample, and its derivative.
  void find_base_rates() {
    std::vector<double> w[3];
    R_WB_.resize(r_.size());
    for (size_t k = 0; k < r_.size(); ++k) {
      set_state(k);
      state_.R_WB.setIdentity(), state_.p_WB.setZero(), state_.V_WB.setZero();
      update_kinematics(*plant_.model, state_, &data_);
      const Matrix3d R_BI = get_pose(data_, s_.imu_link).R * s_.R_LI, R_WI = s_.attitude(k, change_);
      R_WB_[k] = R_WI * R_BI.transpose();
      const Vector3d relative = R_WB_[k] * get_velocity(data_, s_.imu_link).head<3>();
      const Vector3d rate = R_WI * (s_.gyro.at(k) - change_.gyro_bias) - relative;
      for (int i = 0; i < 3; ++i) w[i].push_back(rate[i]);
    }
    for (int i = 0; i < 3; ++i) smooth_series(r_.time, w[i], kHalf, &w_[i].value, &w_[i].rate, &w_[i].second);
  }

  StandSample make_sample(size_t k) {
    StandSample s;
    s.time = r_.time[k];
    set_state(k);
    state_.R_WB = Eigen::Quaterniond(R_WB_[k]);
    state_.V_WB.setZero();
    for (int i = 0; i < 3; ++i) state_.V_WB[i] = w_[i].value[k];
    update_kinematics(*plant_.model, state_, &data_);
    Eigen::VectorXd vdot = Eigen::VectorXd::Zero(6 + n_);
    for (int i = 0; i < 3; ++i) vdot[i] = w_[i].rate[k];
    for (int j = 0; j < n_; ++j) vdot[6 + j] = smooth_.joints[static_cast<size_t>(j)].qdd[k];
    const Transform X_WL = get_pose(data_, s_.imu_link);
    update_accelerations(*plant_.model, vdot, &data_);
    const Vector3d relative = calc_point_acceleration(data_, s_.imu_link, X_WL.p + X_WL.R * s_.p_LI).tail<3>();
    vdot.segment<3>(3) = s_.attitude(k, change_) * (s_.acc.at(k) - change_.accelerometer_bias) + e_.scenario.gravity_W - relative;
    s.q = state_.q, s.qd = state_.qd, s.qdd = vdot.tail(n_);
    s.effort.setZero(n_), s.servo.setZero(n_);
    for (int j = 0; j < n_; ++j) {
      if (!smooth_.effort[static_cast<size_t>(j)].empty()) s.effort[j] = smooth_.effort[static_cast<size_t>(j)][k];
      s.servo[j] = s_.servo[static_cast<size_t>(j)].empty() ? s.effort[j] : s_.servo[static_cast<size_t>(j)][k];
    }
    s.gyro_error = s_.gyro.at(k) - change_.gyro_bias - s_.attitude_rate[k];
    add_rows(k, vdot, &s);
    if (s_.frame.has_base_z) s.base_z = s_.base_z.value[k];
    return s;
  }

  FootSample make_foot(size_t k, size_t f) {
    const int link = s_.frame.foot_links[f];
    const Transform X = get_pose(data_, link);
    FootSample foot;
    foot.force = s_.force[f].at(k), foot.torque = s_.torque[f].at(k);
    for (int i = 0; i < 3; ++i) foot.force_rate[i] = s_.force[f].c[i].rate[k], foot.torque_rate[i] = s_.torque[f].c[i].rate[k];
    // Z-Y-X angles of the foot against the world: roll about the foot's x, pitch about its y.
    foot.pitch = std::asin(std::max(-1.0, std::min(1.0, -X.R(2, 0))));
    foot.roll = std::atan2(X.R(2, 1), X.R(2, 2));
    foot.height = (X.p + X.R * s_.frame.sole_centres[f]).z() - state_.p_WB.z();
    Eigen::MatrixXd J(6, 6 + n_);
    calc_point_jacobian(*plant_.model, data_, link, X.p, J);
    Matrix6d turn = Matrix6d::Zero();
    turn.topLeftCorner<3, 3>() = X.R, turn.bottomRightCorner<3, 3>() = X.R;
    foot.JT = J.transpose() * turn;
    return foot;
  }

  void add_rows(size_t k, const Eigen::VectorXd& vdot, StandSample* s) {
    Eigen::VectorXd tau(6 + n_);
    calc_inverse_dynamics(*plant_.model, vdot, nullptr, &data_, &tau);
    LinkWrenches wrenches(static_cast<size_t>(plant_.model->num_links()), Vector6d::Zero());
    for (size_t f = 0; f < s_.frame.foot_links.size(); ++f) {
      const int link = s_.frame.foot_links[f];
      s->feet.push_back(make_foot(k, f));
      const Matrix3d R = get_pose(data_, link).R;
      Vector6d read;
      read << R * s->feet.back().torque, R * s->feet.back().force;
      wrenches[static_cast<size_t>(link)] = get_joint_wrench(data_, link) + read;
    }
    for (size_t link = 0; link < plant_.force_W.size(); ++link) {
      const Vector3d arm = get_pose(data_, static_cast<int>(link)).R * plant_.tree.links[link].inertia.p_LLcm_L;
      wrenches[link].head<3>() += arm.cross(plant_.force_W[link]);
      wrenches[link].tail<3>() += plant_.force_W[link];
    }
    calc_inverse_dynamics(*plant_.model, vdot, &wrenches, &data_, &tau);
    s->rows = -tau;
    for (int j = 0; j < n_; ++j) s->rows[6 + j] = smooth_.effort[static_cast<size_t>(j)].empty() ? 0.0 : s->rows[6 + j] + s->effort[j];
  }

  const Experiment& e_;
  const Recording& r_;
  const SmoothRecording& smooth_;
  const StandRecording::Smooth& s_;
  const StandChange& change_;
  Plant plant_;
  Data data_;
  State state_;
  int n_;
  std::vector<Matrix3d> R_WB_;
  Channel w_[3];
};

// [rad/s] of an attitude, body axes, from differences over neighbours.
std::vector<Vector3d> calc_rates(const std::vector<double>& time, const std::vector<Matrix3d>& R) {
  std::vector<Vector3d> rates(R.size(), Vector3d::Zero());
  for (size_t k = 1; k + 1 < R.size(); ++k) {
    const Eigen::AngleAxisd turn(Matrix3d(R[k - 1].transpose() * R[k + 1]));
    rates[k] = turn.axis() * turn.angle() / (time[k + 1] - time[k - 1]);
  }
  return rates;
}

}  // namespace

StandRecording::StandRecording(const Problem& problem, int recording)
    : problem_(&problem), recording_(recording), smooth_(std::make_unique<Smooth>()) {
  const Experiment& e = *problem.experiment;
  const Recording& r = e.recordings[static_cast<size_t>(recording)];
  const ImuSpec& imu = e.scenario.sensors.imus.front();
  Transform X_LF;
  smooth_->imu_link = find_link(e, imu.link, &X_LF);
  smooth_->R_LI = X_LF.R;
  smooth_->p_LI = X_LF.p + X_LF.R * imu.p_LS;
  const std::string base = "/imu/" + imu.name;
  smooth_->R_WI = smooth_attitude(r, base + "/orientation");
  smooth_->attitude_rate = calc_rates(r.time, smooth_->R_WI);
  smooth_->gyro = smooth_axes(r, base + "/angular_velocity");
  smooth_->acc = smooth_axes(r, base + "/linear_acceleration");
  StandSeries& frame = smooth_->frame;
  for (const WrenchSpec& w : e.scenario.sensors.wrenches) {
    if (std::find(e.scenario.feet.begin(), e.scenario.feet.end(), w.link) == e.scenario.feet.end()) continue;
    frame.foot_sensors.push_back(w.name);
    frame.foot_names.push_back(w.link);
    frame.foot_links.push_back(find_link(e, w.link, &X_LF));
    frame.sole_centres.push_back(find_sole_centre(e, frame.foot_links.back()));
    smooth_->force.push_back(smooth_axes(r, "/wrench/" + w.name + "/force"));
    smooth_->torque.push_back(smooth_axes(r, "/wrench/" + w.name + "/torque"));
  }
  frame.has_base_z = r.has("/base/pose/position/z");
  if (frame.has_base_z) smooth_->base_z = smooth(r, "/base/pose/position/z");
  const Plant plant = make_plant(e, {});
  smooth_->servo.resize(r.joints.size());
  for (size_t j = 0; j < r.joints.size(); ++j) {
    const JointColumns& c = r.joints[j];
    if (c.command.empty() || e.scenario.drive != "servo") continue;
    const SmoothJoint& joint = problem.smooth[static_cast<size_t>(recording)].joints[j];
    for (size_t k = 0; k < r.size(); ++k) {
      const double rate = c.command_rate.empty() ? 0.0 : c.command_rate[k];
      const double u = calc_servo_effort(plant.laws[j], c.command[k] - joint.q[k], rate - joint.qd[k], 0.0);
      smooth_->servo[j].push_back(std::max(-plant.laws[j].effort_limit, std::min(plant.laws[j].effort_limit, u)));
    }
  }
}

StandRecording::~StandRecording() = default;
StandRecording::StandRecording(StandRecording&&) noexcept = default;

StandSeries StandRecording::evaluate(const StandChange& change) const {
  return Builder(*problem_, recording_, *smooth_, change).build();
}

bool can_stand_on_paper(const Experiment& e) {
  if (!e.scenario.floating_base || e.scenario.sensors.imus.empty() || e.scenario.feet.empty()) return false;
  size_t feet = 0;
  for (const WrenchSpec& w : e.scenario.sensors.wrenches) {
    feet += std::find(e.scenario.feet.begin(), e.scenario.feet.end(), w.link) != e.scenario.feet.end() ? 1 : 0;
  }
  if (feet != e.scenario.feet.size()) return false;
  for (const Recording& r : e.recordings) {
    const std::string imu = "/imu/" + e.scenario.sensors.imus.front().name;
    for (const char* name : {"/orientation/x", "/orientation/w", "/angular_velocity/x", "/angular_velocity/z", "/linear_acceleration/x", "/linear_acceleration/z"}) {
      if (!r.has(imu + name)) return false;
    }
    for (const WrenchSpec& w : e.scenario.sensors.wrenches) {
      for (const char* name : {"/force/x", "/force/y", "/force/z", "/torque/x", "/torque/y", "/torque/z"}) {
        if (!r.has("/wrench/" + w.name + name)) return false;
      }
    }
    for (const JointColumns& joint : r.joints) {
      if (!joint.has(Quantity::kPosition)) return false;
    }
  }
  return true;
}

}  // namespace hrp::diagnosis
