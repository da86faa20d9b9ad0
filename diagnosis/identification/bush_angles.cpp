// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/bush_angles.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/identification/attitude.h"
#include "diagnosis/identification/foot_signals.h"
#include "diagnosis/identification/smoothing.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::identification {

const char* const kAxisNames[kAxes] = {"roll", "pitch"};

namespace {

constexpr double kQuick = 0.005;  // [s] halves the encoders' noise
// [s] at the start soles may shuffle while the robot takes its first load on them, and a hanging robot sags on its
// servos: 1 mrad at the waist within 12 s would pass for 1e-4 rad/s of the gyroscope, which a turning waist makes 3e-5
// rad of roll.
constexpr double kSettling = 1.5;
constexpr double kEnds = 2.0;         // [s] at both ends the drift smoother sees one side only: no tracks there
constexpr double kGyroWander = 1e-6;  // [rad/s] a bias is not constant to less than this
constexpr double kStretch = 1.0;      // [s] both feet stand for less: says nothing of slip

Eigen::VectorXd median_of(const Samples& samples) {
  Eigen::VectorXd median(samples.rows());
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    std::vector<double> row(static_cast<size_t>(samples.cols()));
    for (size_t k = 0; k < row.size(); ++k) row[k] = samples(i, static_cast<Eigen::Index>(k));
    median[i] = diagnosis::find_median(std::move(row));
  }
  return median;
}

RobotLog leave_out_start(const RobotLog& log, double time) {
  const Eigen::Index rest =
      log.size() - std::min(log.size() / 2, static_cast<Eigen::Index>(std::lround(time / log.period)));
  RobotLog late = log;
  late.q = log.q.rightCols(rest);
  if (log.effort.size() > 0) late.effort = log.effort.rightCols(rest);
  late.gyro = log.gyro.rightCols(rest);
  late.accelerometer = log.accelerometer.rightCols(rest);
  for (size_t f = 0; f < log.wrenches.size(); ++f) late.wrenches[f] = log.wrenches[f].rightCols(rest);
  return late;
}

}  // namespace

struct BushObserver::Impl {
  struct Chain {                               // by sample
    std::vector<std::vector<Transform>> X_UI;  // by foot
  };
  explicit Impl(const Scenario& scenario_in);
  bool is_between(int joint) const;  // the IMU and a foot
  Chain calc_chain(const RobotLog& log) const;
  VerticalEstimate calc_vertical(const RobotLog& log, const Chain& chain, const Vector3d& gyro_bias,
                                 const std::vector<Mask>& stands) const;
  Samples calc_acceleration(const RobotLog& log, const Chain& chain, const Samples& n_I, size_t foot) const;
  void fill_foot(const RobotLog& log, const Chain& chain, const VerticalEstimate& vertical, const SensorZero& zero,
                 size_t foot, MotionTrack* track) const;
  void fill_between(const RobotLog& log, const Chain& chain, const Samples& n_I, const std::vector<Mask>& stands,
                    MotionTrack* track) const;

  Scenario scenario;
  RobotDescription robot;
  Model model;
  int imu_link = 0;
  Transform X_LI;
  std::vector<FootFrame> feet;
};

BushObserver::Impl::Impl(const Scenario& s) : scenario(s), robot(load_robot(without_bush(s))), model(robot.tree) {
  const auto fail = [&](const std::string& key, const std::string& what) {
    throw InputError(scenario.make_diagnostic(key, what));
  };
  const ImuSpec& imu = find_imu(scenario);
  const int frame = robot.tree.find_frame(imu.link);
  if (frame < 0) fail("sensors.imu", "the robot has no link '" + imu.link + "'");
  imu_link = robot.tree.frames[static_cast<size_t>(frame)].link;
  X_LI = robot.tree.frames[static_cast<size_t>(frame)].X_LF * Transform{Matrix3d::Identity(), imu.p_LS};
  feet = make_feet(scenario, robot);
}

bool BushObserver::Impl::is_between(int joint) const {
  const int link = joint + 1;
  return std::any_of(feet.begin(), feet.end(), [&](const FootFrame& foot) {
    return model.is_ancestor(link, imu_link) != model.is_ancestor(link, foot.link);
  });
}

BushObserver::Impl::Chain BushObserver::Impl::calc_chain(const RobotLog& log) const {
  Chain chain;
  chain.X_UI.resize(feet.size());
  Data data(model);
  State state = make_state(model);
  std::vector<int> index;
  for (const std::string& joint : log.joints) index.push_back(robot.tree.find_joint(joint));
  for (int i = 0; i < robot.tree.num_joints(); ++i) {
    if (robot.tree.joint(i).actuated && is_between(i) && !has(index, i)) {
      refuse_input(log.name, "has no positions of joint '" + robot.tree.joint(i).name +
                                 "', expected those of all joints between IMU and feet");
    }
  }
  for (Eigen::Index k = 0; k < log.size(); ++k) {
    for (size_t j = 0; j < index.size(); ++j) {
      if (index[j] >= 0) state.q[index[j]] = log.q(static_cast<Eigen::Index>(j), k);
    }
    update_kinematics(model, state, &data);
    const Transform X_BI = get_pose(data, imu_link) * X_LI;
    for (size_t f = 0; f < feet.size(); ++f) chain.X_UI[f].push_back(get_pose(data, feet[f].link).inverse() * X_BI);
  }
  return chain;
}

// [m/s^2] of the IMU in its axes, with the sole of `foot` at rest.
Samples BushObserver::Impl::calc_acceleration(const RobotLog& log, const Chain& chain, const Samples& n_I,
                                              size_t foot) const {
  const GaussianFilter filter(2.0 * kSmoothing, log.period);
  Samples p(3, log.size()), a(3, log.size());
  std::vector<Matrix3d> R_IS(static_cast<size_t>(log.size()));
  for (Eigen::Index k = 0; k < log.size(); ++k) {
    const Transform& X_UI = chain.X_UI[foot][static_cast<size_t>(k)];
    const Matrix3d R_SU = make_R_SU(calc_angles(X_UI.R * n_I.col(k)));
    p.col(k) = R_SU * (X_UI.p - feet[foot].p_UC);
    R_IS[static_cast<size_t>(k)] = (R_SU * X_UI.R).transpose();
  }
  for (int i = 0; i < 3; ++i) a.row(i) = filter.apply(p.row(i).transpose(), 2).transpose();
  const Eigen::Index margin = filter.margin();
  for (Eigen::Index k = 0; k < log.size(); ++k) {
    const bool edge = k < margin || k >= log.size() - margin;
    a.col(k) = edge ? Vector3d::Zero().eval() : (R_IS[static_cast<size_t>(k)] * Vector3d(a.col(k))).eval();
  }
  return a;
}

VerticalEstimate BushObserver::Impl::calc_vertical(const RobotLog& log, const Chain& chain, const Vector3d& gyro_bias,
                                                   const std::vector<Mask>& stands) const {
  VerticalEstimate result{integrate_gyro(log, gyro_bias), Samples(3, log.size()), {}};
  const std::vector<Matrix3d>& R = result.R;
  Samples& n_I = result.n_I;
  const GaussianFilter filter(2.0 * kSmoothing, log.period);
  const Eigen::Index margin = filter.margin() + 1;
  Samples acceleration = Samples::Zero(3, log.size()), u(3, log.size()), felt(3, log.size());
  // Through the filter of calc_acceleration, and in axes that do not turn: what the filter takes from one it must take
  // from the other, or the rest of a quick sway, turned by the sway itself, has a mean of 2e-4 m/s^2.
  for (Eigen::Index k = 0; k < log.size(); ++k) felt.col(k) = R[static_cast<size_t>(k)] * log.accelerometer.col(k);
  for (int i = 0; i < 3; ++i) felt.row(i) = filter.apply(felt.row(i).transpose(), 0).transpose();
  // The acceleration needs the vertical and the vertical the acceleration; what enters is its slow part only, so each
  // round makes the error a hundred times smaller.
  for (int round = 0; round < 3; ++round) {
    for (Eigen::Index k = 0; k < log.size(); ++k) {
      u.col(k) = (felt.col(k) - R[static_cast<size_t>(k)] * acceleration.col(k)) / kGravity;
    }
    const Samples drift = smooth_drift(u, margin, log.period);
    for (Eigen::Index k = 0; k < log.size(); ++k)
      n_I.col(k) = R[static_cast<size_t>(k)].transpose() * Vector3d(drift.col(k)).normalized();
    acceleration.setZero();
    Eigen::ArrayXd count = Eigen::ArrayXd::Zero(log.size());
    for (size_t f = 0; f < feet.size(); ++f) {
      if (!stands[f].any()) continue;
      const Eigen::ArrayXd share = stands[f].cast<double>();
      acceleration += calc_acceleration(log, chain, n_I, f) * share.matrix().asDiagonal();
      count += share;
    }
    acceleration.array().rowwise() /= count.max(1.0).transpose();
  }
  fill_gains(log, gyro_bias, margin, &result);
  return result;
}

namespace {

// Second differences [unit/s^2] of samples `period` [s] apart; 0 at the ends.
Eigen::VectorXd calc_difference(const Eigen::VectorXd& x, double period) {
  Eigen::VectorXd d = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index k = 1; k + 1 < x.size(); ++k) d[k] = (x[k + 1] - 2.0 * x[k] + x[k - 1]) / (period * period);
  return d;
}

}  // namespace

void BushObserver::Impl::fill_foot(const RobotLog& log, const Chain& chain, const VerticalEstimate& vertical,
                                   const SensorZero& zero, size_t f, MotionTrack* track) const {
  const FootSignals s = calc_foot_signals(log, chain.X_UI[f], vertical, zero, feet[f], log.wrenches[f]);
  const auto thin = [&](const Eigen::VectorXd& signal, int order) { return track->thin(signal, order); };
  const GaussianFilter quick(kQuick, log.period);
  BushTrack& out = track->feet[f];
  for (int a = 0; a < kAxes; ++a) {
    out.angle[a] = thin(s.angle[a], 0);
    out.quick[a] = quick.apply(s.angle[a], 0);
    out.rate[a] = thin(s.angle[a], 1);
    out.acceleration[a] = thin(s.angle[a], 2);
    out.torque[a] = thin(s.torque[a], 0);
    out.arm[a] = thin(s.arm[a], 0);
    out.angle_gain[a].resize(track->time.size(), kImuErrors);
    out.rate_gain[a].resize(track->time.size(), kImuErrors);
    for (int i = 0; i < kImuErrors; ++i) {
      out.angle_gain[a].col(i) = thin(s.gain[a][i], 0);
      out.rate_gain[a].col(i) = thin(s.gain[a][i], 1);
    }
  }
  out.load = thin(s.load, 0);
  // A second difference of positions is the mean of the acceleration over a triangle of two samples; the
  // accelerometer's is as Numerov takes it, (1 10 1) / 12. Plain second derivatives would be off by 0.2 %, and the
  // slide is a tenth of this.
  const auto difference = [&](const Eigen::VectorXd& x) { return calc_difference(x, log.period); };
  const Eigen::VectorXd mean_rise = s.rise + difference(s.rise) * (log.period * log.period / 12.0);
  out.rise = thin(mean_rise, 0);
  out.rise_rate = thin(mean_rise, 1);
  out.slide_acceleration = thin(difference(s.height), 0) - out.rise;
  for (int i = 0; i < 3; ++i) out.load_derivative[i] = thin(difference(s.load), i);
  out.zmp.resize(2, track->time.size());
  for (int i = 0; i < 2; ++i) out.zmp.row(i) = thin(s.zmp.row(i).transpose(), 0).transpose();
}

namespace {

void leave_out(double from, double to, MotionTrack* track) {
  for (Eigen::Index j = 0; j < track->time.size(); ++j) {
    if (track->time[j] < from || track->time[j] >= to) continue;
    for (Mask& stands : track->stands) stands[j] = false;
    track->slipped += track->period;
  }
}

}  // namespace

// Closed chain, both soles on the same floor: what their distance and heights say.
void BushObserver::Impl::fill_between(const RobotLog& log, const Chain& chain, const Samples& n_I,
                                      const std::vector<Mask>& stands, MotionTrack* track) const {
  if (feet.size() != 2) return;
  const Eigen::Index n = log.size();
  Samples p(5, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Transform &X_0I = chain.X_UI[0][static_cast<size_t>(k)], &X_1I = chain.X_UI[1][static_cast<size_t>(k)];
    const Matrix3d R_S0 = make_R_SU(calc_angles(X_0I.R * n_I.col(k))),
                   R_S1 = make_R_SU(calc_angles(X_1I.R * n_I.col(k)));
    const Transform X_01 = X_0I * X_1I.inverse();
    const Vector3d between = R_S0 * (X_01 * feet[1].p_UC - feet[0].p_UC);
    const Matrix3d turn = R_S0 * X_01.R * R_S1.transpose();
    p.col(k) << between.z(), between.head<2>().norm(), std::atan2(turn(1, 0), turn(0, 0)), between.x(), between.y();
  }
  const GaussianFilter filter(kSmoothing, log.period);
  for (int i = 0; i < 5; ++i) p.row(i) = filter.apply(p.row(i).transpose(), 0).transpose();
  Mask both = stands[0] && stands[1];
  const auto samples = [&](double time) { return static_cast<Eigen::Index>(std::lround(time / log.period)); };
  both.head(std::min(n / 2, samples(kSettling))).setConstant(false);
  for (const auto& [first, end] : find_stretches(both)) {
    if (end - first < samples(kStretch)) continue;
    const Samples settled = p.middleCols(first, end - first);
    const Eigen::VectorXd middle = median_of(settled);
    if (track->second_sole.isZero()) track->second_sole << middle[3], middle[4], middle[2];
    const double slip = (settled.row(1).array() - middle[1]).abs().maxCoeff();
    const double turn = (settled.row(2).array() - middle[2]).abs().maxCoeff();
    track->slip = std::max(track->slip, slip);
    track->turn = std::max(track->turn, turn);
    if (slip > kSlipDistance || turn > kSlipTurn)
      leave_out(static_cast<double>(first) * log.period, static_cast<double>(end) * log.period, track);
  }
  if (!(track->stands[0] && track->stands[1]).all()) return;
  const Eigen::Index margin = samples(track->time[0]);
  track->slide.resize(track->time.size());
  // S is below U's bush centre by the slide: a bush that is pressed has its centre lower.
  for (Eigen::Index j = 0; j < track->slide.size(); ++j) track->slide[j] = p(0, margin + j * kThinning);
  track->slide.array() -= track->slide.mean();
}

BushObserver::BushObserver(const Scenario& scenario) : impl_(std::make_unique<Impl>(scenario)) {}
BushObserver::~BushObserver() = default;
BushObserver::BushObserver(BushObserver&&) noexcept = default;

const std::vector<FootFrame>& BushObserver::feet() const { return impl_->feet; }

std::vector<Vector3d> BushObserver::bush_centres() const {
  std::vector<Vector3d> centres;
  for (const FootFrame& foot : impl_->feet) centres.push_back(foot.p_UC);
  return centres;
}

HangingAngles BushObserver::calc_hanging(size_t f, const double (&K)[kAxes], const double (&O)[kAxes]) const {
  const FootFrame& foot = impl_->feet[f];
  const double weight = (foot.mass - foot.upper_mass) * kGravity;
  const Vector3d arm = foot.p_Ucm - foot.p_UC;  // of the sole's centre of mass, before it tilts
  HangingAngles q{};
  for (int round = 0; round < 3; ++round) {  // weight is a tenth of what the bush carries: converges at once
    const Vector3d turned = make_R_SU({q[0], q[1]}).transpose() * arm;
    const Vector3d moment = turned.cross(Vector3d(0.0, 0.0, -weight));  // of the sole's weight on the bush
    // The bush turns the sole back by -K q - O.
    for (int a = 0; a < kAxes; ++a) q[static_cast<size_t>(a)] = (moment[a] - O[a]) / K[a];
  }
  return q;
}

std::vector<SensorZero> BushObserver::calc_zeros(const RobotLog& all, const std::vector<HangingAngles>& angles) const {
  const RobotLog hanging = leave_out_start(all, kSettling);
  const Impl::Chain chain = impl_->calc_chain(hanging);
  const Vector3d gyro_bias = hanging.gyro.rowwise().mean();
  const std::vector<Mask> in_the_air(impl_->feet.size(), Mask::Constant(hanging.size(), false));
  const Samples n_I = impl_->calc_vertical(hanging, chain, gyro_bias, in_the_air).n_I;
  const double count = static_cast<double>(hanging.size());
  const double gyro_std = std::sqrt((hanging.gyro.colwise() - gyro_bias).rowwise().squaredNorm().maxCoeff()) / count;
  std::vector<SensorZero> zeros(impl_->feet.size());
  for (size_t f = 0; f < zeros.size(); ++f) {
    // At rest the foot pulls its weight on the sensor, down; that of the sole where it has tilted to.
    const FootFrame& foot = impl_->feet[f];
    const double share = 1.0 - foot.upper_mass / foot.mass;
    const Matrix3d R_US =
        angles.empty() ? Matrix3d::Identity() : make_R_SU({angles[f][0], angles[f][1]}).transpose().eval();
    const Vector3d p_Ucm = foot.p_Ucm + share * (R_US * (foot.p_Ucm - foot.p_UC) - (foot.p_Ucm - foot.p_UC));
    Samples error = hanging.wrenches[f];
    for (Eigen::Index k = 0; k < hanging.size(); ++k) {
      const Vector3d weight = -foot.mass * kGravity * (chain.X_UI[f][static_cast<size_t>(k)].R * n_I.col(k));
      error.col(k).head<3>() -= weight;
      error.col(k).tail<3>() -= p_Ucm.cross(weight);
    }
    zeros[f].gyro_bias = gyro_bias;
    zeros[f].gyro_std = std::max(gyro_std, kGyroWander);
    zeros[f].lift = hanging.accelerometer.rowwise().mean().norm() - kGravity;
    zeros[f].bias = error.rowwise().mean();
    const Samples rest = error.colwise() - Eigen::VectorXd(zeros[f].bias);
    zeros[f].covariance = rest * rest.transpose() / (count - 1.0) / count;
  }
  return zeros;
}

std::vector<Matrix3d> BushObserver::calc_attitude(const RobotLog& log, const std::vector<SensorZero>& zeros) const {
  const std::vector<Mask> stands = find_standing(log, impl_->feet, zeros);
  const Samples n_I = impl_->calc_vertical(log, impl_->calc_chain(log), zeros[0].gyro_bias, stands).n_I;
  std::vector<Matrix3d> R = integrate_gyro(log, zeros[0].gyro_bias);
  for (Eigen::Index k = 0; k < log.size(); ++k) {
    Matrix3d& R_k = R[static_cast<size_t>(k)];
    R_k = Eigen::Quaterniond::FromTwoVectors(Vector3d(R_k * n_I.col(k)), Vector3d::UnitZ()).toRotationMatrix() * R_k;
  }
  return R;
}

MotionTrack BushObserver::observe(const RobotLog& log, const std::vector<SensorZero>& zeros) const {
  const auto margin = static_cast<Eigen::Index>(std::lround(kEnds / log.period));
  if (log.size() < 3 * margin) throw std::runtime_error(log.name + ": too short: motions need at least 6 s");
  MotionTrack track;
  track.name = log.name;
  track.period = kThinning * log.period;
  track.log_period = log.period;
  track.time.resize((log.size() - 2 * margin - 1) / kThinning + 1);
  for (Eigen::Index j = 0; j < track.time.size(); ++j) {
    track.time[j] = static_cast<double>(margin + j * kThinning) * log.period;
  }
  track.feet.resize(impl_->feet.size());
  const std::vector<Mask> stands = find_standing(log, impl_->feet, zeros);
  for (const Mask& all : stands) {
    track.stands.push_back(Mask(track.time.size()));
    for (Eigen::Index j = 0; j < track.time.size(); ++j) track.stands.back()[j] = all[margin + j * kThinning];
  }
  const Impl::Chain chain = impl_->calc_chain(log);
  const VerticalEstimate vertical = impl_->calc_vertical(log, chain, zeros[0].gyro_bias, stands);
  for (size_t f = 0; f < impl_->feet.size(); ++f) impl_->fill_foot(log, chain, vertical, zeros[f], f, &track);
  impl_->fill_between(log, chain, vertical.n_I, stands, &track);
  return track;
}

}  // namespace hrp::identification
