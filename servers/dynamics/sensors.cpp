// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/sensors.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/base/noise.h"
#include "common/multibody/kinematics.h"

namespace hrp {
namespace {

// Channels: encoders first (three groups of joints), then groups of three axes.
constexpr unsigned long long kGroupChannels = 1ull << 20;

}  // namespace

double quantise(double value, double quantum) { return quantum > 0.0 ? quantum * std::round(value / quantum) : value; }

Vector3d apply_errors(const SensorErrors& errors, const Vector3d& value, unsigned long long seed,
                      unsigned long long channel, unsigned long long step) {
  Vector3d turned = value;
  if (!errors.misalignment.isZero(0.0)) turned = make_rotation_from_rpy(errors.misalignment).transpose() * value;
  Vector3d reading = errors.scale.cwiseProduct(turned) + errors.bias;
  for (int i = 0; i < 3; ++i) {
    const unsigned long long axis = channel + static_cast<unsigned>(i);
    if (errors.noise[i] > 0.0) reading[i] += errors.noise[i] * calc_noise(seed, axis, step);
    reading[i] = quantise(reading[i], errors.quantum);
  }
  return reading;
}

Sensors::Sensors(const Model& model, const Scenario& scenario)
    : spec_(scenario.sensors), seed_(scenario.seed), gravity_W_(model.gravity_W()) {
  for (const ImuSpec& imu : spec_.imus) {
    imus_.push_back(find_mount(model, imu.link, imu.p_LS));
    add_delay(imu.gyro, scenario);
    add_delay(imu.accelerometer, scenario);
  }
  for (const WrenchSpec& wrench : spec_.wrenches) {
    wrenches_.push_back(find_mount(model, wrench.link, Vector3d::Zero()));
    add_delay(wrench.force, scenario);
    add_delay(wrench.torque, scenario);
  }
  acceleration_W_.resize(imus_.size(), Vector3d::Zero());
  joint_wrench_L_.resize(wrenches_.size(), Vector6d::Zero());
  tau_.setZero(model.nv());
  sample_.imus.resize(imus_.size());
  sample_.wrenches.resize(wrenches_.size());
  sample_.q = sample_.qd = sample_.effort = Eigen::VectorXd::Zero(model.num_joints());
  sample_.has_base_pose = spec_.base_pose;
}

Sensors::Mounted Sensors::find_mount(const Model& model, const std::string& link, const Vector3d& p) const {
  const int frame = model.spec().find_frame(link), moving = model.spec().find_link(link);
  Mounted mounted;
  if (frame >= 0) {
    mounted.link = model.spec().frames[static_cast<size_t>(frame)].link;
    mounted.X_LS = model.spec().frames[static_cast<size_t>(frame)].X_LF * Transform{Matrix3d::Identity(), p};
  } else if (moving >= 0) {
    mounted.link = moving;
    mounted.X_LS.p = p;
  } else {
    refuse_input({"", "sensors"}, "the robot has no link '" + link + "'");
  }
  return mounted;
}

// A clock that runs behind makes readings later and later. One that runs ahead would need the future: it is set so that
// it is right at the end of the run, which differs by a constant delay only.
void Sensors::add_delay(const SensorErrors& errors, const Scenario& scenario) {
  const double all = scenario.duration / scenario.time_step;  // steps of the run
  Delay delay;
  delay.gain = -errors.clock_skew;
  delay.steps = errors.delay / scenario.time_step + std::max(0.0, errors.clock_skew) * all;
  const double latest = delay.steps + std::max(0.0, delay.gain) * all;
  if (latest > 0.0) {
    delay.ring.resize(static_cast<size_t>(std::ceil(latest)) + 2, Vector3d::Zero());
    needs_every_step_ = true;
  }
  delays_.push_back(delay);
}

void Sensors::reset(const State& state, const Data& data, const EncoderTruth& encoders) {
  for (Vector3d& a : acceleration_W_) a.setZero();
  for (Vector6d& F : joint_wrench_L_) F.setZero();
  for (Delay& delay : delays_) std::fill(delay.ring.begin(), delay.ring.end(), Vector3d(NAN, 0, 0));
  update_readings(state, data, encoders, 0);
}

void Sensors::update_forces(const Model& model, const Eigen::VectorXd& vdot, const LinkWrenches& wrenches, Data* data) {
  if (imus_.empty() && wrenches_.empty()) return;
  calc_inverse_dynamics(model, vdot, &wrenches, data, &tau_);
  // In the axes the link has here: turned by those after the step, the moment of 300 N under an ankle 0.1 m high would
  // be off by 0.03 N m s/rad times the rate, a tenth of a per cent of a foot's damping.
  for (size_t i = 0; i < wrenches_.size(); ++i) {
    const Matrix3d R_LW = get_pose(*data, wrenches_[i].link).R.transpose();
    const Vector6d F_W = get_joint_wrench(*data, wrenches_[i].link);
    joint_wrench_L_[i] << R_LW * F_W.head<3>(), R_LW * F_W.tail<3>();
  }
  if (imus_.empty()) return;
  update_accelerations(model, vdot, data);
  for (size_t i = 0; i < imus_.size(); ++i) {
    const Vector3d p_WS = get_pose(*data, imus_[i].link) * imus_[i].X_LS.p;
    acceleration_W_[i] = calc_point_acceleration(*data, imus_[i].link, p_WS).tail<3>();
  }
}

// Late readings are interpolated between the steps; before the first there is the first.
Vector3d Sensors::pass(const SensorErrors& errors, Delay* delay, const Vector3d& value, unsigned long long channel,
                       unsigned long long step) {
  Vector3d late = value;
  if (!delay->ring.empty()) {
    const size_t slots = delay->ring.size();
    if (std::isnan(delay->ring[0].x())) std::fill(delay->ring.begin(), delay->ring.end(), value);
    delay->ring[step % slots] = value;
    const double longest = static_cast<double>(slots - 2);
    const double behind = std::clamp(delay->steps + delay->gain * static_cast<double>(step), 0.0, longest);
    const auto whole = static_cast<unsigned long long>(behind);
    const double part = behind - static_cast<double>(whole);
    const Vector3d& newer = delay->ring[(step + slots - whole % slots) % slots];
    const Vector3d& older = delay->ring[(step + 2 * slots - whole % slots - 1) % slots];
    late = newer + part * (older - newer);
  }
  return apply_errors(errors, late, seed_, channel, step);
}

void Sensors::update_readings(const State& state, const Data& data, const EncoderTruth& encoders,
                              unsigned long long step) {
  update_encoders(encoders, step);
  update_imus(data, step);
  update_wrenches(step);
  sample_.X_WB = state.X_WB();
  sample_.V_WB = state.V_WB;
}

void Sensors::update_encoders(const EncoderTruth& encoders, unsigned long long step) {
  const EncoderSpec& e = spec_.encoders;
  const auto n = static_cast<unsigned long long>(encoders.q.size());
  for (unsigned long long i = 0; i < n; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    double q = encoders.q[k], qd = encoders.qd[k], effort = encoders.effort[k];
    if (e.position_noise > 0.0) q += e.position_noise * calc_noise(seed_, i, step);
    if (e.velocity_noise > 0.0) qd += e.velocity_noise * calc_noise(seed_, n + i, step);
    if (e.effort_noise > 0.0) effort += e.effort_noise * calc_noise(seed_, 2 * n + i, step);
    sample_.q[k] = quantise(q, e.position_quantum);
    sample_.qd[k] = qd;
    sample_.effort[k] = effort;
  }
}

void Sensors::update_imus(const Data& data, unsigned long long step) {
  for (size_t i = 0; i < imus_.size(); ++i) {
    const Matrix3d R_WS = get_pose(data, imus_[i].link).R * imus_[i].X_LS.R;
    const Vector3d rate = R_WS.transpose() * get_velocity(data, imus_[i].link).head<3>();
    const Vector3d force = R_WS.transpose() * (acceleration_W_[i] - gravity_W_);
    const unsigned long long channel = kGroupChannels + 6 * i;
    sample_.imus[i].R_WS = Eigen::Quaterniond(R_WS);
    sample_.imus[i].angular_velocity = pass(spec_.imus[i].gyro, &delays_[2 * i], rate, channel, step);
    sample_.imus[i].linear_acceleration =
        pass(spec_.imus[i].accelerometer, &delays_[2 * i + 1], force, channel + 3, step);
  }
}

// The sensor reads what its link exerts on the parent: the opposite of what the joint passes to the link.
void Sensors::update_wrenches(unsigned long long step) {
  for (size_t i = 0; i < wrenches_.size(); ++i) {
    const Transform& X_LS = wrenches_[i].X_LS;
    const Vector3d force = -joint_wrench_L_[i].tail<3>();
    const Vector3d moment = -joint_wrench_L_[i].head<3>() - X_LS.p.cross(force);
    const size_t first = 2 * (imus_.size() + i);
    const unsigned long long channel = 2 * kGroupChannels + 6 * i;
    const Matrix3d R_SL = X_LS.R.transpose();
    sample_.wrenches[i].force = pass(spec_.wrenches[i].force, &delays_[first], R_SL * force, channel, step);
    sample_.wrenches[i].torque = pass(spec_.wrenches[i].torque, &delays_[first + 1], R_SL * moment, channel + 3, step);
  }
}

}  // namespace hrp
