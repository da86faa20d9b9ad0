// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright_channels.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"

namespace hrp::diagnosis::upright {
namespace {

constexpr double kStick = 0.004;   // [rad/s] slower than this a joint may be stuck: noise of smoothed velocities is below 0.001
constexpr double kInside = 0.88;   // share of a sole's half edges within which the centre of pressure means flat contact

// The value of a series at any time between its stamps.
double interpolate(const std::vector<double>& time, const std::vector<double>& values, double t) {
  const auto at = std::upper_bound(time.begin() + 1, time.end() - 1, t) - time.begin();
  const auto k = static_cast<size_t>(at);
  const double s = std::clamp((t - time[k - 1]) / (time[k] - time[k - 1]), 0.0, 1.0);
  return values[k - 1] + s * (values[k] - values[k - 1]);
}

struct JointTerms {
  double viscous = 0, coulomb = 0, asymmetry = 0, rotor = 0, spring = 0, moment = 0, torque_scale = 1, offset = 0, delay = 0, lag = 0;
  double effort_bias = 0, effort_scale = 1;
};

struct WrenchTerms {
  Vector3d force_bias{0, 0, 0}, torque_bias{0, 0, 0}, rpy{0, 0, 0};
  double force_scale = 1, torque_scale = 1, delay = 0, skew = 0;
};

struct ImuTerms {
  Vector3d gyro_bias{0, 0, 0}, accelerometer_bias{0, 0, 0}, rpy{0, 0, 0};
  double gyro_scale = 1, accelerometer_scale = 1, delay = 0, skew = 0;
};

struct FootTerms {
  double p[kFootParameters] = {}, hardening = 0;
};

Vector3d get3(const std::vector<double>& p, size_t at = 0) { return {p[at], p[at + 1], p[at + 2]}; }

// The hypothesis, sorted by where it acts.
struct Terms {
  std::vector<JointTerms> joints;
  std::vector<WrenchTerms> wrenches;
  std::vector<FootTerms> feet;
  ImuTerms imu;
  double slope_roll = 0, slope_pitch = 0, friction = 0;
  TreeSpec tree;
  std::vector<Vector3d> force_W;

  Terms(const StandProblem& problem, const StandHypothesis& hypothesis)
      : joints(static_cast<size_t>(problem.tree.num_joints())), wrenches(problem.feet.size()), feet(problem.feet.size()),
        tree(problem.tree), force_W(problem.tree.links.size(), Vector3d::Zero()) {
    for (const StandEffect& effect : hypothesis) {
      if (!add_joint(effect) && !add_link(effect) && !add_wrench(effect)) add_rest(effect);
    }
  }

  bool add_joint(const StandEffect& e) {
    if (e.id > StandId::kActuatorLag && e.id < StandId::kEffortBias) return false;
    JointTerms& j = joints[static_cast<size_t>(e.place)];
    switch (e.id) {
      case StandId::kViscous: j.viscous = e.p[0]; break;
      case StandId::kCoulomb: j.coulomb = e.p[0], j.asymmetry = e.p[1]; break;
      case StandId::kRotorInertia: j.rotor = e.p[0]; break;
      case StandId::kSpring: j.spring = e.p[0], j.moment = e.p[1]; break;
      case StandId::kTorqueConstant: j.torque_scale = e.p[0]; break;
      case StandId::kJointOffset: j.offset = e.p[0]; break;
      case StandId::kCommandDelay: j.delay = e.p[0]; break;
      case StandId::kActuatorLag: j.lag = e.p[0]; break;
      case StandId::kEffortBias: j.effort_bias = e.p[0]; break;
      default: j.effort_scale = e.p[0];
    }
    return true;
  }

  bool add_link(const StandEffect& e) {
    if (e.id < StandId::kPayload || e.id > StandId::kExternalForce) return false;
    LinkInertia& link = tree.links[static_cast<size_t>(e.place)].inertia;
    if (e.id == StandId::kMassError) link.mass *= e.p[0], link.I_LLcm_L *= e.p[0];
    if (e.id == StandId::kComError) link.p_LLcm_L += get3(e.p);
    if (e.id == StandId::kExternalForce) force_W[static_cast<size_t>(e.place)] = get3(e.p);
    if (e.id == StandId::kPayload) {
      const Vector3d moment = link.mass * link.p_LLcm_L + get3(e.p, 1);  // written in mass and mass x com: linear
      const double mass = std::max(1e-6, link.mass + e.p[0]);
      link.p_LLcm_L = moment / mass, link.mass = mass;
    }
    return true;
  }

  bool add_wrench(const StandEffect& e) {
    if (e.id < StandId::kForceBias || e.id > StandId::kWrenchSkew) return false;
    WrenchTerms& w = wrenches[static_cast<size_t>(e.place)];
    switch (e.id) {
      case StandId::kForceBias: w.force_bias = get3(e.p); break;
      case StandId::kTorqueBias: w.torque_bias = get3(e.p); break;
      case StandId::kForceScale: w.force_scale = e.p[0]; break;
      case StandId::kTorqueScale: w.torque_scale = e.p[0]; break;
      case StandId::kWrenchDelay: w.delay = e.p[0]; break;
      case StandId::kWrenchMisalignment: w.rpy = get3(e.p); break;
      default: w.skew = e.p[0];
    }
    return true;
  }

  void add_rest(const StandEffect& e) {
    switch (e.id) {
      case StandId::kGroundSlope: slope_roll = e.p[0], slope_pitch = e.p[1]; break;
      case StandId::kGroundFriction: friction = e.p[0]; break;
      case StandId::kGyroBias: imu.gyro_bias = get3(e.p); break;
      case StandId::kAccelerometerBias: imu.accelerometer_bias = get3(e.p); break;
      case StandId::kGyroScale: imu.gyro_scale = e.p[0]; break;
      case StandId::kAccelerometerScale: imu.accelerometer_scale = e.p[0]; break;
      case StandId::kImuDelay: imu.delay = e.p[0]; break;
      case StandId::kImuMisalignment: imu.rpy = get3(e.p); break;
      case StandId::kImuSkew: imu.skew = e.p[0]; break;
      default: {  // compliance of all feet at once
        const bool hard = e.id == StandId::kFootHardening;
        const size_t size = kFootParameters + (hard ? 1 : 0);
        for (size_t f = 0; f < feet.size(); ++f) {
          std::copy_n(e.p.begin() + static_cast<long>(f * size), kFootParameters, feet[f].p);
          if (hard) feet[f].hardening = e.p[f * size + kFootParameters];
        }
      }
    }
  }
};

class Calculator {
 public:
  Calculator(const StandProblem& problem, const StandHypothesis& hypothesis, size_t recording)
      : problem_(problem), r_(problem.recordings[recording]), terms_(problem, hypothesis), model_(terms_.tree, problem.experiment->scenario.gravity_W),
        data_(model_), state_(make_state(model_)), wrenches_(terms_.tree.links.size(), Vector6d::Zero()), vdot_(model_.nv()), tau_(model_.nv()) {
    for (int j = 0; j < model_.num_joints(); ++j) {
      const auto& servo = problem.experiment->scenario.servo_joints;
      const auto at = servo.find(terms_.tree.joint(j).name);
      servo_.push_back(at == servo.end() ? problem.experiment->scenario.servo_default : at->second);
    }
  }

  std::vector<double> run() {
    channels_ = list_channels(problem_).size();
    out_.reserve(r_.samples.size() * channels_);
    for (int k : r_.samples) add_sample(static_cast<size_t>(k));
    remove_mean_gap();
    add_gravity();
    return std::move(out_);
  }

  const std::vector<double>& ratios() const { return ratios_; }  // after run(): tangential over normal force

 private:
  double shifted(const Series& s, bool rate, double t, double delay, double skew) const {
    return interpolate(r_.time, rate ? s.rate : s.value, (t + delay) / (1 + skew));
  }

  void read_imu(double t) {
    const ImuTerms& imu = terms_.imu;
    const Matrix3d R_turn = make_rotation_from_rpy(imu.rpy);
    Eigen::Vector4d q, dq;
    for (int i = 0; i < 4; ++i) {
      q(i) = shifted(r_.attitude[i], false, t, imu.delay, imu.skew), dq(i) = shifted(r_.attitude[i], true, t, imu.delay, imu.skew);
    }
    const Eigen::Quaterniond attitude = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized();
    const Eigen::Quaterniond rate(dq(0), dq(1), dq(2), dq(3));
    const Vector3d turning = 2 * (attitude.conjugate() * rate).vec();
    Vector3d w, dw, f;
    for (int i = 0; i < 3; ++i) {
      w(i) = shifted(r_.gyro[i], false, t, imu.delay, imu.skew), dw(i) = shifted(r_.gyro[i], true, t, imu.delay, imu.skew);
      f(i) = shifted(r_.accelerometer[i], false, t, imu.delay, imu.skew);
    }
    w = (w - imu.gyro_bias) / imu.gyro_scale, dw /= imu.gyro_scale, f = (f - imu.accelerometer_bias) / imu.accelerometer_scale;
    gyro_residual_ = turning - w;
    R_WI_ = attitude.toRotationMatrix() * R_turn.transpose();
    w_ = R_turn * w, dw_ = R_turn * dw, f_ = R_turn * f;
  }

  void read_joints(size_t k) {
    for (int j = 0; j < model_.num_joints(); ++j) {
      const auto i = static_cast<size_t>(j);
      state_.q(j) = r_.position[i].value[k] - terms_.joints[i].offset;
      state_.qd(j) = r_.position[i].rate[k];
      vdot_(6 + j) = r_.position[i].second[k];
    }
  }

  // Base attitude, rate and accelerations from the IMU, wherever in the tree it sits.
  void find_base_motion() {
    state_.R_WB.setIdentity(), state_.p_WB.setZero(), state_.V_WB.setZero();
    update_kinematics(model_, state_, &data_);
    const Matrix3d R_BI = get_pose(data_, problem_.imu_link).R * problem_.R_LI;
    const Vector3d w_BL = get_velocity(data_, problem_.imu_link).head<3>();
    const Matrix3d R_WB = R_WI_ * R_BI.transpose();
    state_.R_WB = Eigen::Quaterniond(R_WB).normalized();
    state_.V_WB.head<3>() = R_WI_ * w_ - R_WB * w_BL;
    update_kinematics(model_, state_, &data_);
    const Vector3d p_WI = get_pose(data_, problem_.imu_link) * problem_.p_LI;
    vdot_.head<6>().setZero();
    update_accelerations(model_, vdot_, &data_);
    const Vector6d a0 = calc_point_acceleration(data_, problem_.imu_link, p_WI);
    const Vector3d alpha_B = R_WI_ * dw_ - a0.head<3>();
    const Vector3d a_I = R_WI_ * f_ + problem_.experiment->scenario.gravity_W;
    vdot_.head<3>() = alpha_B;
    vdot_.segment<3>(3) = a_I - alpha_B.cross(p_WI) - a0.tail<3>();
  }

  void read_wrenches(double t) {
    for (Vector6d& w : wrenches_) w.setZero();
    for (size_t link = 0; link < wrenches_.size(); ++link) {
      if (terms_.force_W[link].isZero()) continue;
      const Matrix3d R = get_pose(data_, static_cast<int>(link)).R;
      wrenches_[link] << Vector3d(R * terms_.tree.links[link].inertia.p_LLcm_L).cross(terms_.force_W[link]), terms_.force_W[link];
    }
    for (size_t foot = 0; foot < problem_.feet.size(); ++foot) {
      const WrenchTerms& w = terms_.wrenches[foot];
      Vector3d force, torque;
      for (int i = 0; i < 3; ++i) {
        force(i) = shifted(r_.wrench[6 * foot + static_cast<size_t>(i)], false, t, w.delay, w.skew);
        torque(i) = shifted(r_.wrench[6 * foot + 3 + static_cast<size_t>(i)], false, t, w.delay, w.skew);
      }
      const Matrix3d R_turn = make_rotation_from_rpy(w.rpy);
      force_[foot] = R_turn * Vector3d((force - w.force_bias) / w.force_scale);
      torque_[foot] = R_turn * Vector3d((torque - w.torque_bias) / w.torque_scale);
      const Matrix3d R = get_pose(data_, problem_.feet[foot].link).R;
      wrenches_[static_cast<size_t>(problem_.feet[foot].link)] << R * torque_[foot], R * force_[foot];
    }
  }

  // Where the ground presses on the sole: at an edge the foot may roll over it, and its tilt says nothing.
  bool stands_flat(size_t foot) const {
    const StandFoot& f = problem_.feet[foot];
    const Vector3d moment = torque_[foot] - f.sole.cross(force_[foot]);
    const double fz = force_[foot].z();
    return fz > 5 && std::abs(moment.y() / fz) < kInside * f.size.x() / 2 && std::abs(moment.x() / fz) < kInside * f.size.y() / 2;
  }

  void add_feet() {
    std::vector<Vector3d> centers;
    const Vector3d normal_W = make_rotation_from_rpy({terms_.slope_roll, terms_.slope_pitch, 0}) * Vector3d::UnitZ();
    bool all_flat = true, slips = false;
    for (size_t foot = 0; foot < problem_.feet.size(); ++foot) {
      const StandFoot& f = problem_.feet[foot];
      const FootTerms& t = terms_.feet[foot];
      const Transform X = get_pose(data_, f.link);
      const Vector3d w_F = X.R.transpose() * get_velocity(data_, f.link).head<3>(), n = X.R.transpose() * normal_W;
      const double angles[2] = {std::atan2(n.y(), n.z()), -std::asin(std::clamp(n.x(), -1.0, 1.0))};  // roll, pitch
      const Vector3d moment = torque_[foot] - f.bush.cross(force_[foot]);                             // about the bush
      const bool flat = stands_flat(foot);
      all_flat = all_flat && flat;
      for (int a = 0; a < 2; ++a) {
        const double* p = t.p + 4 * a;
        const double bent = -p[0] * moment(a) - p[1] * w_F(a) - p[2] * force_[foot].z() - p[3] * force_[foot](1 - a) -
                            t.hardening * angles[a] * angles[a] * angles[a];
        out_.push_back(flat ? angles[a] - bent : 0);
      }
      centers.push_back(X * f.bush + Vector3d(0, 0, t.p[8] * force_[foot].z()));
      const double ratio = force_[foot].head<2>().norm() / std::max(1.0, force_[foot].z());
      slips = slips || (terms_.friction > 0 && ratio > 0.9 * terms_.friction);
      worst_ratio_ = foot == 0 ? ratio : std::max(worst_ratio_, ratio);
    }
    for (size_t foot = 1; foot < problem_.feet.size(); ++foot) {
      const Vector3d gap = centers[foot] - centers[0];
      for (int i = 0; i < 3; ++i) out_.push_back(gap(i));
    }
    flat_.push_back(all_flat), slips_.push_back(slips), ratios_.push_back(worst_ratio_);
  }

  // What is missing in the effort after dry friction: all of what it can hold at rest, its level in motion.
  double take_friction(const JointTerms& t, size_t k, size_t joint, double v, double missing) const {
    if (t.coulomb == 0) return missing;
    const std::vector<double>& rate = r_.position[joint].rate;
    const size_t near = static_cast<size_t>(std::max(1, r_.samples[1] - r_.samples[0]));
    const double before = rate[k >= near ? k - near : 0], after = rate[std::min(k + near, rate.size() - 1)];
    const bool moving = std::abs(v) > kStick && before * v > 0 && after * v > 0;
    const double forward = t.coulomb * (1 + t.asymmetry), backward = -t.coulomb * (1 - t.asymmetry);
    if (moving) return missing - (v > 0 ? forward : backward);
    return missing - std::clamp(missing, std::min(backward, forward), std::max(backward, forward));
  }

  double clamp_effort(int j, double u) const {
    const double limit = servo_[static_cast<size_t>(j)].effort_limit;
    return std::clamp(u, -limit, limit);
  }

  void add_drives(size_t k) {
    for (int j = 0; j < model_.num_joints(); ++j) {
      const auto i = static_cast<size_t>(j);
      if (!problem_.driven[i]) continue;
      const JointTerms& t = terms_.joints[i];
      const double v = state_.qd(j);
      const double u = (r_.effort[i].value[k] - t.effort_bias) / t.effort_scale;
      const double needed = tau_(6 + j) + t.viscous * v + t.rotor * vdot_(6 + j) +
                            t.spring * state_.q(j) + t.moment;
      out_.push_back(take_friction(t, k, i, v, (u - t.lag * r_.effort[i].rate[k]) * t.torque_scale - needed));
      if (r_.command[i].value.empty()) continue;
      const ServoGains& servo = servo_[i];
      const double c = interpolate(r_.time, r_.command[i].value, r_.time[k] - t.delay), cd = interpolate(r_.time, r_.command[i].rate, r_.time[k] - t.delay);
      out_.push_back(u - clamp_effort(j, servo.kp * (c - r_.position[i].value[k]) + servo.kd * (cd - v)));
    }
  }

  void add_sample(size_t k) {
    const double t = r_.time[k];
    force_.resize(problem_.feet.size()), torque_.resize(problem_.feet.size());
    read_imu(t);
    read_joints(k);
    find_base_motion();
    read_wrenches(t);
    add_feet();
    calc_inverse_dynamics(model_, vdot_, &wrenches_, &data_, &tau_);
    for (int i = 0; i < 6; ++i) out_.push_back(tau_(i));
    add_drives(k);
    for (int i = 0; i < 3; ++i) out_.push_back(gyro_residual_(i));
    gravity_.push_back(f_ + R_WI_.transpose() * problem_.experiment->scenario.gravity_W);
    for (int i = 0; i < 3; ++i) out_.push_back(0);  // filled by add_gravity
  }

  // Gaps: slips taken out (with less friction than nominal in the hypothesis), then the mean of the flat samples.
  void remove_mean_gap() {
    const size_t first = 2 * problem_.feet.size(), n = r_.samples.size();
    for (size_t c = first; c < first + 3 * (problem_.feet.size() - 1); ++c) {
      double slipped = 0, previous = out_[c], mean = 0, count = 0;
      for (size_t k = 0; k < n; ++k) {
        double& gap = out_[k * channels_ + c];
        if (k > 0 && (slips_[k] || slips_[k - 1])) slipped += gap - previous;
        previous = gap;
        gap -= slipped;
        if (flat_[k]) mean += gap, ++count;
      }
      for (size_t k = 0; k < n; ++k) {
        double& gap = out_[k * channels_ + c];
        gap = flat_[k] ? gap - mean / std::max(1.0, count) : 0;
      }
    }
  }

  // Mean of specific force less gravity with a window that fades at both ends: what the robot's own motion adds cancels.
  void add_gravity() {
    const size_t n = r_.samples.size();
    Vector3d sum = Vector3d::Zero();
    double weight = 0;
    for (size_t k = 0; k < n; ++k) {
      const double w = 1 - std::cos(2 * M_PI * (static_cast<double>(k) + 0.5) / static_cast<double>(n));
      sum += w * gravity_[k], weight += w;
    }
    for (size_t k = 0; k < n; ++k) {
      for (size_t i = 0; i < 3; ++i) out_[k * channels_ + channels_ - 3 + i] = sum(static_cast<long>(i)) / weight;
    }
  }

  const StandProblem& problem_;
  const StandRecording& r_;
  Terms terms_;
  Model model_;
  Data data_;
  State state_;
  LinkWrenches wrenches_;
  Eigen::VectorXd vdot_, tau_;
  std::vector<ServoGains> servo_;
  std::vector<Vector3d> force_, torque_, gravity_;
  Matrix3d R_WI_ = Matrix3d::Identity();
  Vector3d w_, dw_, f_, gyro_residual_;
  std::vector<char> flat_, slips_;
  std::vector<double> ratios_;
  double worst_ratio_ = 0;
  size_t channels_ = 0;
  std::vector<double> out_;
};

}  // namespace

std::vector<Channel> list_channels(const StandProblem& problem) {
  std::vector<Channel> out;
  const std::string imu = "/imu/" + problem.imu;
  for (const StandFoot& foot : problem.feet) {
    for (int i = 0; i < 2; ++i) out.push_back({"tilt", imu + "/orientation", "", foot.name, "", ""});
  }
  for (size_t f = 1; f < problem.feet.size(); ++f) {
    for (int i = 0; i < 3; ++i) out.push_back({"gap", imu + "/orientation", "", problem.feet[f].name, "", ""});
  }
  for (int i = 0; i < 6; ++i) {
    const std::string sensor = "/wrench/" + problem.feet[0].sensor;
    out.push_back({"balance", sensor + (i < 3 ? "/torque" : "/force"), "", "", "", problem.tree.links[0].name});
  }
  for (int j = 0; j < problem.tree.num_joints(); ++j) {
    const auto i = static_cast<size_t>(j);
    if (!problem.driven[i]) continue;
    const std::string name = problem.tree.joint(j).name, signal = "/joint_states/" + name + "/effort";
    out.push_back({"effort", signal, name, "", "", ""});
    if (!problem.recordings[0].command[i].value.empty()) out.push_back({"servo", signal, name, "", "", ""});
  }
  for (int i = 0; i < 3; ++i) out.push_back({"gyro", imu + "/angular_velocity", "", "", imu, ""});
  for (int i = 0; i < 3; ++i) out.push_back({"gravity", imu + "/linear_acceleration", "", "", imu, ""});
  return out;
}

std::vector<double> calc_channels(const StandProblem& problem, const StandHypothesis& hypothesis, size_t recording) {
  return Calculator(problem, hypothesis, recording).run();
}

bool find_slip_ratio(const StandProblem& problem, double* ratio, double* spread) {
  const size_t channels = list_channels(problem).size(), first = 2 * problem.feet.size();
  if (problem.feet.size() < 2) return false;
  std::vector<double> slipping;
  for (size_t r = 0; r < problem.recordings.size(); ++r) {
    Calculator calculator(problem, {}, r);
    const std::vector<double> flat = calculator.run();
    const std::vector<double>& ratios = calculator.ratios();
    for (size_t k = 1; k < ratios.size(); ++k) {
      double moved = 0;
      for (size_t i = 0; i < 2; ++i) moved = std::max(moved, std::abs(flat[k * channels + first + i] - flat[(k - 1) * channels + first + i]));
      if (moved > 4e-4) slipping.push_back(ratios[k]);  // [m] in 0.03 s; noise is below 5e-5
    }
  }
  if (slipping.size() < 20) return false;
  std::sort(slipping.begin(), slipping.end());
  const size_t n = slipping.size();
  *ratio = slipping[n / 2];
  *spread = (slipping[n * 84 / 100] - slipping[n * 16 / 100]) / 2;
  return *spread < 0.25 * *ratio;
}

}  // namespace hrp::diagnosis::upright
