// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright/channels.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/data/command_reader.h"
#include "diagnosis/upright/layout.h"

namespace hrp::diagnosis::upright {
namespace {

constexpr double kInside = 0.88;  // share of a sole's half edges within which the centre of pressure means flat contact
constexpr size_t kTurning = 5;    // samples: half of the 0.3 s over which turning is compared
constexpr double kLongEnough = 4;  // [s] a place known to 1 mm tells the mean acceleration over it to 3e-3 m/s^2
constexpr double kLoaded = 0.01;  // share of the weight that a foot must carry to count as standing

class Calculator {
 public:
  Calculator(const StandProblem& problem, const StandHypothesis& hypothesis, size_t recording)
      : p_(problem),
        r_(problem.recordings[recording]),
        terms_(problem, hypothesis),
        model_(terms_.tree, problem.experiment->scenario.gravity_W),
        data_(model_),
        state_(make_state(model_)),
        wrenches_(terms_.tree.links.size(), Vector6d::Zero()),
        vdot_(model_.nv()),
        tau_(model_.nv()),
        drives_(problem, r_, terms_),
        joints_(static_cast<size_t>(model_.num_joints())),
        force_(problem.feet.size()),
        torque_(problem.feet.size()),
        rolled_(problem.feet.size(), Vector3d::Zero()) {
    for (const LinkSpec& link : problem.tree.links) load_ += kLoaded * link.inertia.mass * 9.81;
    for (size_t j = 0; j < joints_.size(); ++j) slack_.push_back(terms_.joints[j].gap ? find_slack(problem, j) : 0);
  }

  std::vector<double> run(StandBase* base) {
    channels_ = list_channels(p_).size();
    out_.reserve(r_.samples.size() * channels_);
    for (int k : r_.samples) {
      add_sample(static_cast<size_t>(k));
      if (base) base->states.insert(base->states.end(), joints_.begin(), joints_.end());
    }
    remove_mean_places();
    add_turning();
    add_gravity();
    if (base) base->residuals = out_, base->flat = flat_, base->ratios = ratios_;
    return std::move(out_);
  }

 private:
  // A sensor's series at sample k, where its readings come late or its clock runs at another rate.
  double shifted(const Series& s, bool rate, size_t k, double delay, double skew) const {
    const std::vector<double>& values = rate ? s.rate : s.value;
    if (delay == 0 && skew == 0) return values[k];
    return interpolate(r_.time, values, (r_.time[k] + delay) / (1 + skew), k);
  }

  void read_imu(size_t k) {
    const ImuTerms& imu = terms_.imu;
    Eigen::Vector4d q;
    for (int i = 0; i < 4; ++i) q(i) = shifted(r_.attitude[i], false, k, imu.delay[0], imu.skew);
    const Eigen::Quaterniond attitude = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized();
    Vector3d w, dw, f;
    for (int i = 0; i < 3; ++i) {
      w(i) = shifted(r_.gyro[i], false, k, imu.delay[1], imu.skew);
      dw(i) = shifted(r_.gyro[i], true, k, imu.delay[1], imu.skew);
      f(i) = shifted(r_.accelerometer[i], false, k, imu.delay[2], imu.skew);
    }
    const Matrix3d R_attitude = make_rotation_from_rpy(imu.rpy[0]), R_gyro = make_rotation_from_rpy(imu.rpy[1]);
    w_ = R_gyro * Vector3d((w - imu.gyro_bias) / imu.gyro_scale), dw_ = R_gyro * Vector3d(dw / imu.gyro_scale);
    f_ = make_rotation_from_rpy(imu.rpy[2]) * Vector3d((f - imu.accelerometer_bias) / imu.accelerometer_scale);
    R_WI_ = attitude.toRotationMatrix() * R_attitude.transpose();
    attitudes_.emplace_back(R_WI_), rates_.push_back(w_), turns_.push_back(dw_);
  }

  // Joints as the encoders have them, and the links behind elastic or loose transmissions.
  void read_joints(size_t k) {
    floats_ = false;
    for (int j = 0; j < model_.num_joints(); ++j) {
      const auto i = static_cast<size_t>(j);
      const JointTerms& terms = terms_.joints[i];
      const Series& position = r_.position[i];
      double q = position.value[k], v = position.rate[k], a = position.second[k];
      if (terms.position_delay != 0) {
        const double t = r_.time[k] + terms.position_delay;
        q = interpolate(r_.time, position.value, t, k), v = interpolate(r_.time, position.rate, t, k);
        a = interpolate(r_.time, position.second, t, k);
      }
      const double scale = terms.position_scale;
      DriveState& s = joints_[i];
      s.encoder = (q - terms.position_bias) / scale, s.velocity = v / scale, s.acceleration = a / scale;
      double bent = 0, bent_rate = 0, bent_second = 0;
      if ((terms.compliance != 0 || terms.gap != 0) && p_.is_driven(i)) {
        double rate = 0;
        const double torque = drives_.find_effort(i, k, s, &rate) - terms.rotor * s.acceleration;
        // Loose teeth that nothing holds on one side are in the middle, more or less.
        const double side = terms.gap != 0 ? torque / std::max(1e-9, slack_[i]) : 0;
        floats_ = floats_ || (terms.gap != 0 && std::abs(side) < 1);
        bent = terms.compliance * torque + 0.5 * terms.gap * std::clamp(side, -1.0, 1.0);
        bent_rate = terms.compliance * rate;
        if (p_.effort[i]) bent_second = terms.compliance * r_.effort[i].second[k];
      }
      s.link = s.encoder - terms.offset - bent;
      state_.q(j) = s.link, state_.qd(j) = s.velocity - bent_rate;
      vdot_(6 + j) = s.acceleration - bent_second;
    }
  }

  // Base attitude, rate and accelerations from the IMU, wherever in the tree it sits.
  void find_base_motion() {
    state_.R_WB.setIdentity(), state_.p_WB.setZero(), state_.V_WB.setZero();
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

  void read_wrenches(size_t k) {
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
        force(static_cast<long>(i)) = shifted(r_.wrench[6 * foot + i], false, k, w.delay[0], w.skew);
        torque(static_cast<long>(i)) = shifted(r_.wrench[6 * foot + 3 + i], false, k, w.delay[1], w.skew);
      }
      force_[foot] = make_rotation_from_rpy(w.rpy[0]) * Vector3d((force - w.force_bias) / w.force_scale);
      torque_[foot] = make_rotation_from_rpy(w.rpy[1]) * Vector3d((torque - w.torque_bias) / w.torque_scale);
      const Matrix3d R = get_pose(data_, p_.feet[foot].link).R;
      wrenches_[static_cast<size_t>(p_.feet[foot].link)] << R * torque_[foot], R * force_[foot];
    }
  }

  // Where the ground presses on the sole: at an edge the foot may roll over it, and its tilt says nothing.
  bool stands_flat(size_t foot) const {
    const StandFoot& f = p_.feet[foot];
    const Vector3d moment = torque_[foot] - f.sole.cross(force_[foot]);
    const double fz = force_[foot].z();
    return !floats_ && fz > load_ && std::abs(moment.y() / fz) < kInside * f.size.x() / 2 &&
           std::abs(moment.x() / fz) < kInside * f.size.y() / 2;
  }

  // Tilt of a flat foot against the ground, less what its bush gives.
  void add_tilt(size_t foot, const Vector3d& normal_W, bool flat) {
    const StandFoot& f = p_.feet[foot];
    const FootTerms& t = terms_.feet[foot];
    const Transform X = get_pose(data_, f.link);
    const Vector3d w_F = X.R.transpose() * get_velocity(data_, f.link).head<3>(), n = X.R.transpose() * normal_W;
    const double angles[2] = {std::atan2(n.y(), n.z()), -std::asin(std::clamp(n.x(), -1.0, 1.0))};  // roll, pitch
    const Vector3d center = f.bush + t.shift;
    // Through the bush goes what the sensor feels and the weight of the foot between them.
    const Vector3d weight = f.mass * (X.R.transpose() * p_.experiment->scenario.gravity_W);
    const Vector3d moment = torque_[foot] - center.cross(force_[foot]) - (f.com - center).cross(weight);
    for (int a = 0; a < 2; ++a) {
      const double bent = -t.inverse_k[a] * (moment(a) + t.moment[a]) - t.c_over_k[a] * w_F(a) -
                          t.hardening * angles[a] * angles[a] * angles[a];
      out_.push_back(flat ? angles[a] - bent : 0);
    }
  }

  // A point of the foot that stays where it is: the bush's centre less how far it sank, a ball's centre less how far
  // it rolled.
  Vector3d find_fixed_point(size_t foot, double dt) {
    const StandFoot& f = p_.feet[foot];
    const Transform X = get_pose(data_, f.link);
    if (f.kind == SoleKind::kBall) {
      const Vector3d w_W = get_velocity(data_, f.link).head<3>();
      rolled_[foot] += dt * f.radius * w_W.cross(Vector3d::UnitZ());
      return X * f.bush - rolled_[foot];
    }
    return X * f.bush + Vector3d(0, 0, terms_.feet[foot].inverse_kz * force_[foot].z());
  }

  void add_feet(size_t k) {
    const Vector3d normal_W = make_rotation_from_rpy({terms_.slope_roll, terms_.slope_pitch, 0}) * Vector3d::UnitZ();
    const double dt = flat_.empty() ? 0 : r_.time[k] - r_.time[last_];
    last_ = k;
    std::vector<Vector3d> points;
    bool all_flat = true, slips = false;
    double worst = 0;
    for (size_t foot = 0; foot < p_.feet.size(); ++foot) {
      const bool flat = stands_flat(foot);
      all_flat = all_flat && flat;
      if (p_.feet[foot].kind == SoleKind::kFlat) add_tilt(foot, normal_W, flat);
      points.push_back(find_fixed_point(foot, dt));
      const double ratio = force_[foot].head<2>().norm() / std::max(1.0, force_[foot].z());
      slips = slips || (terms_.friction > 0 && ratio > 0.9 * terms_.friction);
      worst = std::max(worst, ratio);
    }
    places_.push_back(get_pose(data_, p_.imu_link) * p_.p_LI - points[0]);
    if (p_.base_pose) add_vector(find_standing_point(k));
    for (size_t foot = 1; foot < p_.feet.size(); ++foot) add_vector(points[foot] - points[0]);
    flat_.push_back(all_flat), slips_.push_back(slips), ratios_.push_back(worst);
  }

  // The first foot in the world, by the recorded pose of the base.
  Vector3d find_standing_point(size_t k) const {
    const StandFoot& f = p_.feet[0];
    const Vector3d at_B = state_.R_WB.conjugate() * (get_pose(data_, f.link) * f.bush - rolled_[0]);
    const Vector3d sunk(0, 0, terms_.feet[0].inverse_kz * force_[0].z());
    const Vector3d p_WB(r_.base_position[0].value[k], r_.base_position[1].value[k], r_.base_position[2].value[k]);
    return p_WB + read_base_attitude(k) * at_B + sunk;
  }

  Eigen::Quaterniond read_base_attitude(size_t k) const {
    const Series* q = r_.base_attitude;
    return Eigen::Quaterniond(q[0].value[k], q[1].value[k], q[2].value[k], q[3].value[k]).normalized();
  }

  void add_vector(const Vector3d& v) {
    for (int i = 0; i < 3; ++i) out_.push_back(v(i));
  }

  void add_base(size_t k) {
    if (!p_.base_pose || !p_.attitude) return;
    const Eigen::Quaterniond off = state_.R_WB * read_base_attitude(k).conjugate();
    add_vector((off.w() < 0 ? -2.0 : 2.0) * off.vec());  // in world axes; the heading less its mean, see below
    yaw_ += out_.back();
  }

  void add_sample(size_t k) {
    read_imu(k);
    read_joints(k);
    find_base_motion();
    read_wrenches(k);
    add_feet(k);
    calc_inverse_dynamics(model_, vdot_, &wrenches_, &data_, &tau_);
    for (int i = 0; i < 6; ++i) out_.push_back(tau_(i));
    add_base(k);
    for (size_t j = 0; j < joints_.size(); ++j) {
      joints_[j].torque = tau_(6 + static_cast<long>(j));
      drives_.add(j, k, joints_[j], &out_);
    }
    gravity_.push_back(f_ + R_WI_.transpose() * p_.experiment->scenario.gravity_W);
    for (int i = 0; i < 2; ++i) add_vector(Vector3d::Zero());  // filled by add_turning and add_gravity
  }

  // Places are known but for constants: the mean over the flat samples is taken out, or, where feet may have moved,
  // over each stretch in which they stood. The heading of IMU and base pose: the mean.
  void remove_mean_places() {
    const size_t n = r_.samples.size(), first = find_places(p_);
    std::vector<size_t> stretch(n, 0);
    size_t count = 1;
    for (size_t k = 1; k < n; ++k) {
      const bool seen = flat_[k] && flat_[k - 1] && follows(k);
      const bool moved = slips_[k] || slips_[k - 1] || (terms_.friction > 0 && !seen);
      stretch[k] = moved ? count++ : count - 1;
    }
    for (size_t c = first; c < first + count_places(p_); ++c) {
      std::vector<double> sum(count, 0.0), flat(count, 0.0);
      for (size_t k = 0; k < n; ++k) {
        if (flat_[k]) sum[stretch[k]] += out_[k * channels_ + c], ++flat[stretch[k]];
      }
      for (size_t k = 0; k < n; ++k) {
        double& place = out_[k * channels_ + c];
        place = flat_[k] && flat[stretch[k]] > 1 ? place - sum[stretch[k]] / flat[stretch[k]] : 0;
      }
    }
    if (!p_.base_pose || !p_.attitude) return;
    for (size_t k = 0; k < n; ++k) out_[k * channels_ + find_drives(p_) - 1] -= yaw_ / static_cast<double>(n);
  }

  // How the attitude turned in a stretch against the gyroscope's integral over it: a derivative of the attitude would
  // be far noisier. One stretch after the other, so that their errors are independent; between them nothing is said.
  // The trapezoidal rule with its end correction (Euler-Maclaurin): alone it errs by 1 % at 2 Hz and 30 ms a sample.
  void add_turning() {
    for (size_t s = kTurning; s + kTurning < r_.samples.size(); s += 2 * kTurning) {
      const auto time = [&](size_t k) { return r_.time[static_cast<size_t>(r_.samples[k])]; };
      const int span = r_.samples[s + kTurning] - r_.samples[s - kTurning];
      if (span > 2 * static_cast<int>(kTurning) * r_.window) continue;  // samples between are left out
      Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
      for (size_t k = s - kTurning; k < s + kTurning; ++k) {
        const double dt = time(k + 1) - time(k);
        const Vector3d step = 0.5 * dt * (rates_[k] + rates_[k + 1]) + dt * dt / 12 * (turns_[k] - turns_[k + 1]);
        turned = turned * Eigen::Quaterniond(1, step.x() / 2, step.y() / 2, step.z() / 2).normalized();
      }
      const Eigen::Quaterniond seen = attitudes_[s - kTurning].conjugate() * attitudes_[s + kTurning];
      const Eigen::Quaterniond off = turned.conjugate() * seen;
      const Vector3d rate = (off.w() < 0 ? -2.0 : 2.0) * off.vec() / (time(s + kTurning) - time(s - kTurning));
      for (size_t i = 0; i < 3; ++i) out_[s * channels_ + channels_ - 6 + i] = rate(static_cast<long>(i));
    }
  }

  // No sample is left out before the k-th.
  bool follows(size_t k) const { return r_.samples[k] - r_.samples[k - 1] <= r_.window; }

  // First and end of the longest run of samples without a gap or a slip.
  std::pair<size_t, size_t> find_longest_run() const {
    std::pair<size_t, size_t> best{0, 0};
    size_t begin = 0;
    for (size_t k = 1; k <= r_.samples.size(); ++k) {
      const bool goes_on = k < r_.samples.size() && follows(k) && !slips_[k];
      if (goes_on) continue;
      if (k - begin > best.second - best.first) best = {begin, k};
      begin = k;
    }
    return best;
  }

  // Mean of specific force and gravity with a window w = 1 - cos that fades at both ends, less the mean acceleration of
  // the IMU over its standing foot: w and its rate vanish at the ends, so that is the mean of w'' times the place.
  void add_gravity() {
    const auto [begin, end] = find_longest_run();
    const auto time = [&](size_t k) { return r_.time[static_cast<size_t>(r_.samples[k])]; };
    const double span = end > begin ? time(end - 1) - time(begin) : 0;
    if (span < kLongEnough) return;
    const double n = static_cast<double>(end - begin);
    Vector3d sum = Vector3d::Zero();
    double weight = 0;
    for (size_t k = begin; k < end; ++k) {
      const double angle = 2 * M_PI * (static_cast<double>(k - begin) + 0.5) / n;
      const double w = 1 - std::cos(angle), second = std::pow(2 * M_PI / span, 2) * std::cos(angle);
      sum += w * (attitudes_[k] * gravity_[k]) - second * places_[k], weight += w;
    }
    sum = attitudes_[(begin + end) / 2].conjugate() * sum;  // summed in the world, told in the sensor's axes
    for (size_t k = 0; k < r_.samples.size(); ++k) {
      for (size_t i = 0; i < 3; ++i) {
        out_[k * channels_ + channels_ - 3 + i] = sum(static_cast<long>(i)) / weight;
      }
    }
  }

  const StandProblem& p_;
  const StandRecording& r_;
  Terms terms_;
  Model model_;
  Data data_;
  State state_;
  LinkWrenches wrenches_;
  Eigen::VectorXd vdot_, tau_;
  Drives drives_;
  std::vector<DriveState> joints_;
  std::vector<Vector3d> force_, torque_, rolled_, gravity_;
  Matrix3d R_WI_ = Matrix3d::Identity();
  Vector3d w_, dw_, f_;
  std::vector<Eigen::Quaterniond> attitudes_;
  std::vector<Vector3d> rates_, turns_, places_;
  std::vector<char> flat_, slips_;
  std::vector<double> ratios_, out_;
  std::vector<double> slack_;  // [N m] by joint: less than that does not hold loose teeth on one side
  bool floats_ = false;        // a link floats between the teeth: feet may be anywhere
  double load_ = 0, yaw_ = 0;  // [N], [rad]
  size_t channels_ = 0, last_ = 0;
};

}  // namespace

std::vector<double> calc_channels(const StandProblem& problem, const StandHypothesis& hypothesis, size_t recording,
                                  StandBase* base) {
  return Calculator(problem, hypothesis, recording).run(base);
}

std::vector<double> calc_drive_channels(const StandProblem& problem, const StandHypothesis& hypothesis,
                                        size_t recording, const StandBase& base, int joint) {
  const StandRecording& r = problem.recordings[recording];
  const Terms terms(problem, hypothesis);
  const Drives drives(problem, r, terms);
  const size_t joints = terms.joints.size(), channels = base.residuals.size() / r.samples.size();
  size_t first = find_drives(problem);
  for (size_t j = 0; j < static_cast<size_t>(joint); ++j) first += count_drive_channels(problem, j);
  std::vector<double> out = base.residuals, added;
  for (size_t s = 0; s < r.samples.size(); ++s) {
    const auto j = static_cast<size_t>(joint);
    added.clear();
    drives.add(j, static_cast<size_t>(r.samples[s]), base.states[s * joints + j], &added);
    std::copy(added.begin(), added.end(), out.begin() + static_cast<long>(s * channels + first));
  }
  return out;
}

}  // namespace hrp::diagnosis::upright
