// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/bush_angles.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"
#include "common/robot/sole.h"
#include "diagnosis/identification/smoothing.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::identification {

const char* const kAxisNames[kAxes] = {"roll", "pitch"};

namespace {

constexpr double kGravity = 9.81;       // [m/s^2]
constexpr double kSmoothing = 0.03;     // [s] passes what bushes answer to (up to 6 Hz), stops the noise
constexpr double kDriftWindow = 2.0;    // [s] where gyroscope drift and accelerometer noise are about equal
constexpr int kDriftThinning = 20;      // the drift is slow: smoothed on every 20th sample
constexpr int kThinning = 4;            // of the result: smoothed samples are alike
constexpr double kSettling = 1.5;       // [s] soles may shuffle while the robot takes its first load on them
constexpr double kAirborne = 20.0;      // [N] less load than this: not standing

Vector3d median_of(const Samples& samples) {
  Vector3d median;
  for (int i = 0; i < 3; ++i) {
    std::vector<double> row(static_cast<size_t>(samples.cols()));
    for (size_t k = 0; k < row.size(); ++k) row[k] = samples(i, static_cast<Eigen::Index>(k));
    std::nth_element(row.begin(), row.begin() + static_cast<long>(row.size() / 2), row.end());
    median[i] = row[row.size() / 2];
  }
  return median;
}

Matrix3d make_turn(const Vector3d& turn) {
  const double angle = turn.norm();
  if (angle < 1e-12) return Matrix3d::Identity() + skew(turn);
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

// Attitude by the gyroscope alone, from any start.
std::vector<Matrix3d> integrate_gyro(const RobotLog& log, const Vector3d& bias) {
  const auto n = static_cast<size_t>(log.size());
  std::vector<Matrix3d> R(n, Matrix3d::Identity());
  for (size_t k = 1; k < n; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    R[k] = R[k - 1] * make_turn(log.period * (0.5 * (log.gyro.col(i - 1) + log.gyro.col(i)) - bias));
  }
  return R;
}

// The vertical in gyroscope-integrated axes, slowly drifting: a line by least squares, then a wide smoother. `margin`
// samples at both ends are left out, where the robot's acceleration is not known; there the drift is held.
Samples smooth_drift(const Samples& all, Eigen::Index margin, double period) {
  const auto u = all.middleCols(margin, all.cols() - 2 * margin);
  const Eigen::Index n = u.cols(), m = (n + kDriftThinning - 1) / kDriftThinning;
  Samples coarse = Samples::Zero(3, m);
  Eigen::VectorXd centre(m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const Eigen::Index first = j * kDriftThinning, count = std::min<Eigen::Index>(kDriftThinning, n - first);
    coarse.col(j) = u.middleCols(first, count).rowwise().mean();
    centre[j] = static_cast<double>(first) + 0.5 * static_cast<double>(count - 1);
  }
  Eigen::MatrixXd line(m, 2);
  line << Eigen::VectorXd::Ones(m), centre;
  const Eigen::MatrixXd trend = line.householderQr().solve(coarse.transpose());
  const Samples rest = coarse - (line * trend).transpose();
  const GaussianFilter wide(kDriftWindow, period * kDriftThinning);
  Samples smooth(3, m), result(3, all.cols());
  for (int i = 0; i < 3; ++i) smooth.row(i) = wide.apply(rest.row(i).transpose(), 0).transpose();
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    const Eigen::Index k = std::clamp<Eigen::Index>(i - margin, 0, n - 1);
    const double at = std::clamp((static_cast<double>(k) - centre[0]) / kDriftThinning, 0.0, static_cast<double>(m - 1));
    const Eigen::Index j = std::min<Eigen::Index>(static_cast<Eigen::Index>(at), std::max<Eigen::Index>(m - 2, 0));
    const double s = m > 1 ? at - static_cast<double>(j) : 0.0;
    result.col(i) = (1.0 - s) * smooth.col(j) + s * smooth.col(std::min(j + 1, m - 1)) +
                    trend.row(0).transpose() + trend.row(1).transpose() * static_cast<double>(k);
  }
  return result;
}

struct Angles {
  double roll, pitch;
};

// R_US = Rx(roll) Ry(pitch) and S level: the vertical in U is (sin p, -sin r cos p, cos r cos p).
Angles calc_angles(const Vector3d& n_U) {
  return {std::atan2(-n_U.y(), n_U.z()), std::asin(std::clamp(n_U.x(), -1.0, 1.0))};
}

Matrix3d make_R_SU(const Angles& a) {
  return (Eigen::AngleAxisd(-a.pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(-a.roll, Vector3d::UnitX())).toRotationMatrix();
}

}  // namespace

struct BushObserver::Impl {
  struct Foot {
    int link = 0;
    Vector3d p_UC = Vector3d::Zero();    // centre of the bush
    double mass = 0.0, upper_mass = 0.0; // [kg] of the foot, and above the bush
    Vector3d p_Ucm = Vector3d::Zero();
  };
  struct Chain {                          // by sample
    std::vector<std::vector<Transform>> X_UI;  // by foot
  };
  explicit Impl(const Scenario& scenario_in);
  Chain calc_chain(const RobotLog& log) const;
  // The vertical in I, and what each error of the IMU does to it.
  struct Vertical {
    Samples n_I, gain[kImuErrors];
  };
  Vertical calc_vertical(const RobotLog& log, const Chain& chain, const Vector3d& gyro_bias, const std::vector<bool>& loaded) const;
  Samples calc_acceleration(const RobotLog& log, const Chain& chain, const Samples& n_I, size_t foot) const;
  void fill_foot(const RobotLog& log, const Chain& chain, const Vertical& vertical, const SensorZero& zero, size_t foot,
                 MotionTrack* track) const;
  void fill_between(const RobotLog& log, const Chain& chain, const Samples& n_I, MotionTrack* track) const;

  Scenario scenario;
  RobotDescription robot;
  Model model;
  int imu_link = 0;
  Transform X_LI;
  std::vector<Foot> feet;
};

namespace {

Scenario without_bush(Scenario scenario) {
  scenario.foot_bush.clear();
  scenario.joint_laws.clear();
  return scenario;
}

}  // namespace

BushObserver::Impl::Impl(const Scenario& s) : scenario(s), robot(load_robot(without_bush(s))), model(robot.tree) {
  const auto fail = [&](const std::string& key, const std::string& what) { throw InputError(scenario.make_diagnostic(key, what)); };
  if (scenario.sensors.imus.empty()) fail("sensors.imu", "the bush's angles need an IMU");
  const ImuSpec& imu = scenario.sensors.imus[0];
  const int frame = robot.tree.find_frame(imu.link);
  if (frame < 0) fail("sensors.imu", "the robot has no link '" + imu.link + "'");
  imu_link = robot.tree.frames[static_cast<size_t>(frame)].link;
  X_LI = robot.tree.frames[static_cast<size_t>(frame)].X_LF * Transform{Matrix3d::Identity(), imu.p_LS};
  const std::vector<Sole> soles = make_soles(robot);
  for (const std::string& name : scenario.feet) {
    Foot foot;
    foot.link = robot.tree.find_link(name);
    if (foot.link < 0) fail("feet", "the robot has no link '" + name + "'");
    const auto bush = scenario.foot_bush.find(name);
    for (const Sole& sole : soles) {
      if (sole.link == foot.link) foot.p_UC = sole.p_LR;
    }
    const LinkInertia& inertia = robot.tree.links[static_cast<size_t>(foot.link)].inertia;
    foot.mass = inertia.mass;
    foot.p_Ucm = inertia.p_LLcm_L;
    foot.upper_mass = FootBushSpec{}.upper_mass_ratio * inertia.mass;
    if (bush != scenario.foot_bush.end()) {
      if (bush->second.center) foot.p_UC = *bush->second.center;
      foot.upper_mass = bush->second.upper_mass_ratio * inertia.mass;
    }
    feet.push_back(foot);
  }
}

BushObserver::Impl::Chain BushObserver::Impl::calc_chain(const RobotLog& log) const {
  Chain chain;
  chain.X_UI.resize(feet.size());
  Data data(model);
  State state = make_state(model);
  std::vector<int> index;
  for (const std::string& joint : log.joints) index.push_back(robot.tree.find_joint(joint));
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
Samples BushObserver::Impl::calc_acceleration(const RobotLog& log, const Chain& chain, const Samples& n_I, size_t foot) const {
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

BushObserver::Impl::Vertical BushObserver::Impl::calc_vertical(const RobotLog& log, const Chain& chain, const Vector3d& gyro_bias,
                                                               const std::vector<bool>& loaded) const {
  const std::vector<Matrix3d> R = integrate_gyro(log, gyro_bias);
  const GaussianFilter filter(2.0 * kSmoothing, log.period);
  const Eigen::Index margin = filter.margin() + 1;
  Vertical result;
  Samples n_I(3, log.size()), acceleration = Samples::Zero(3, log.size()), u(3, log.size()), felt(3, log.size());
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
    for (Eigen::Index k = 0; k < log.size(); ++k) n_I.col(k) = R[static_cast<size_t>(k)].transpose() * Vector3d(drift.col(k)).normalized();
    acceleration.setZero();
    int count = 0;
    for (size_t f = 0; f < feet.size(); ++f) {
      if (!loaded[f]) continue;
      acceleration += calc_acceleration(log, chain, n_I, f);
      ++count;
    }
    if (count > 1) acceleration /= count;
  }
  // A bias turns with the IMU, and the drift smoother sees it turn.
  for (int i = 0; i < 3; ++i) {
    for (Eigen::Index k = 0; k < log.size(); ++k) u.col(k) = R[static_cast<size_t>(k)].col(i) / kGravity;
    const Samples drift = smooth_drift(u, margin, log.period);
    result.gain[i].resize(3, log.size());
    for (Eigen::Index k = 0; k < log.size(); ++k) result.gain[i].col(k) = R[static_cast<size_t>(k)].transpose() * Vector3d(drift.col(k));
  }
  // A late gyroscope gives R(t - delay) = R (1 - delay [w]x): the vertical lags, but for what the drift smoother mends.
  for (Eigen::Index k = 0; k < log.size(); ++k) u.col(k) = R[static_cast<size_t>(k)] * Vector3d(log.gyro.col(k) - gyro_bias).cross(Vector3d(n_I.col(k)));
  const Samples slow = smooth_drift(u, margin, log.period);
  result.gain[kDelay].resize(3, log.size());
  for (Eigen::Index k = 0; k < log.size(); ++k) {
    result.gain[kDelay].col(k) = R[static_cast<size_t>(k)].transpose() * Vector3d(u.col(k) - slow.col(k));
  }
  result.n_I = n_I;
  return result;
}

void BushObserver::Impl::fill_foot(const RobotLog& log, const Chain& chain, const Vertical& vertical, const SensorZero& zero,
                                   size_t f, MotionTrack* track) const {
  const Foot& foot = feet[f];
  const Eigen::Index n = log.size();
  Eigen::VectorXd angle[kAxes], torque[kAxes], arm[kAxes], load(n), rise(n), height(n), gain[kAxes][kImuErrors];
  Eigen::Matrix2Xd zmp(2, n);
  for (auto* list : {angle, torque, arm}) {
    for (int a = 0; a < kAxes; ++a) list[a].resize(n);
  }
  for (auto& list : gain) {
    for (Eigen::VectorXd& g : list) g.resize(n);
  }
  for (Eigen::Index k = 0; k < n; ++k) {
    const Matrix3d& R_UI = chain.X_UI[f][static_cast<size_t>(k)].R;
    const Vector3d n_U = R_UI * vertical.n_I.col(k);
    const Angles at = calc_angles(n_U);
    angle[0][k] = at.roll;
    angle[1][k] = at.pitch;
    for (int i = 0; i < kImuErrors; ++i) {  // angles are close to linear in the vertical
      const Angles moved = calc_angles((n_U + 1e-4 * R_UI * vertical.gain[i].col(k)).normalized());
      gain[0][i][k] = (moved.roll - at.roll) / 1e-4;
      gain[1][i][k] = (moved.pitch - at.pitch) / 1e-4;
    }
    const Vector3d weight = foot.upper_mass * kGravity * n_U;  // of what is above the bush: the bush carries it, too
    const Vector3d force = log.wrenches[f].col(k).head<3>() - zero.bias.head<3>();
    const Vector3d moment = log.wrenches[f].col(k).tail<3>() - zero.bias.tail<3>() - foot.p_UC.cross(force) +
                            (foot.p_Ucm - foot.p_UC).cross(weight);
    torque[0][k] = moment.x();
    torque[1][k] = moment.y() * std::cos(at.roll) + moment.z() * std::sin(at.roll);
    const Vector3d carried = force + weight;
    load[k] = carried.dot(n_U);
    // Axes higher by compliance x load along U's z: moment less that shift x force.
    arm[0][k] = carried.z() * carried.y();
    arm[1][k] = -carried.z() * carried.x() * std::cos(at.roll);
    height[k] = (make_R_SU(at) * (chain.X_UI[f][static_cast<size_t>(k)].p - foot.p_UC)).z();
    rise[k] = log.accelerometer.col(k).dot(vertical.n_I.col(k)) - kGravity;
    zmp.col(k) << -torque[1][k] / std::max(load[k], 1.0), torque[0][k] / std::max(load[k], 1.0);
  }
  const GaussianFilter filter(kSmoothing, log.period);
  const Eigen::Index margin = track->time.size() > 0 ? static_cast<Eigen::Index>(std::lround(track->time[0] / log.period)) : 0;
  const auto thin = [&](const Eigen::VectorXd& signal, int order) {
    const Eigen::VectorXd smooth = filter.apply(signal, order);
    Eigen::VectorXd out(track->time.size());
    for (Eigen::Index j = 0; j < out.size(); ++j) out[j] = smooth[margin + j * kThinning];
    return out;
  };
  BushTrack& out = track->feet[f];
  for (int a = 0; a < kAxes; ++a) {
    out.angle[a] = thin(angle[a], 0);
    out.rate[a] = thin(angle[a], 1);
    out.torque[a] = thin(torque[a], 0);
    out.arm[a] = thin(arm[a], 0);
    out.angle_gain[a].resize(track->time.size(), kImuErrors);
    out.rate_gain[a].resize(track->time.size(), kImuErrors);
    for (int i = 0; i < kImuErrors; ++i) {
      out.angle_gain[a].col(i) = thin(gain[a][i], 0);
      out.rate_gain[a].col(i) = thin(gain[a][i], 1);
    }
  }
  out.load = thin(load, 0);
  // A second difference of positions is the mean of the acceleration over a triangle of two samples; the accelerometer's
  // is as Numerov takes it, (1 10 1) / 12. Plain second derivatives would be off by 0.2 %, and the slide is a tenth of this.
  const auto difference = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd d = Eigen::VectorXd::Zero(n);
    for (Eigen::Index k = 1; k + 1 < n; ++k) d[k] = (x[k + 1] - 2.0 * x[k] + x[k - 1]) / (log.period * log.period);
    return d;
  };
  const Eigen::VectorXd mean_rise = rise + difference(rise) * (log.period * log.period / 12.0);
  out.rise = thin(mean_rise, 0);
  out.rise_rate = thin(mean_rise, 1);
  out.slide_acceleration = thin(difference(height), 0) - out.rise;
  for (int i = 0; i < 3; ++i) out.load_derivative[i] = thin(difference(load), i);
  out.zmp.resize(2, track->time.size());
  for (int i = 0; i < 2; ++i) out.zmp.row(i) = thin(zmp.row(i).transpose(), 0).transpose();
}

// Closed chain, both soles on the same floor: what their distance and heights say.
void BushObserver::Impl::fill_between(const RobotLog& log, const Chain& chain, const Samples& n_I, MotionTrack* track) const {
  if (feet.size() != 2 || !track->loaded[0] || !track->loaded[1]) return;
  const Eigen::Index n = log.size();
  Samples p(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Transform &X_0I = chain.X_UI[0][static_cast<size_t>(k)], &X_1I = chain.X_UI[1][static_cast<size_t>(k)];
    const Matrix3d R_S0 = make_R_SU(calc_angles(X_0I.R * n_I.col(k))), R_S1 = make_R_SU(calc_angles(X_1I.R * n_I.col(k)));
    const Transform X_01 = X_0I * X_1I.inverse();
    const Vector3d between = R_S0 * (X_01 * feet[1].p_UC - feet[0].p_UC);
    const Matrix3d turn = R_S0 * X_01.R * R_S1.transpose();
    p.col(k) << between.z(), between.head<2>().norm(), std::atan2(turn(1, 0), turn(0, 0));
  }
  const GaussianFilter filter(kSmoothing, log.period);
  for (int i = 0; i < 3; ++i) p.row(i) = filter.apply(p.row(i).transpose(), 0).transpose();
  const Eigen::Index begin = std::min<Eigen::Index>(n / 2, static_cast<Eigen::Index>(std::lround(kSettling / log.period)));
  const Samples settled = p.rightCols(n - begin);
  const Vector3d middle = median_of(settled);
  track->slip = (settled.row(1).array() - middle[1]).abs().maxCoeff();
  track->turn = (settled.row(2).array() - middle[2]).abs().maxCoeff();
  const Eigen::Index margin = static_cast<Eigen::Index>(std::lround(track->time[0] / log.period));
  track->slide.resize(track->time.size());
  // S is below U's bush centre by the slide: a bush that is pressed has its centre lower.
  for (Eigen::Index j = 0; j < track->slide.size(); ++j) track->slide[j] = p(0, margin + j * kThinning);
  track->slide.array() -= track->slide.mean();
}

BushObserver::BushObserver(const Scenario& scenario) : impl_(std::make_unique<Impl>(scenario)) {}
BushObserver::~BushObserver() = default;
BushObserver::BushObserver(BushObserver&&) noexcept = default;

std::vector<Vector3d> BushObserver::bush_centres() const {
  std::vector<Vector3d> centres;
  for (const Impl::Foot& foot : impl_->feet) centres.push_back(foot.p_UC);
  return centres;
}

HangingAngles BushObserver::calc_hanging(size_t f, const double (&K)[kAxes], const double (&O)[kAxes]) const {
  const Impl::Foot& foot = impl_->feet[f];
  const double weight = (foot.mass - foot.upper_mass) * kGravity;
  const Vector3d arm = foot.p_Ucm - foot.p_UC;  // of the sole's centre of mass, before it tilts
  HangingAngles q{};
  for (int round = 0; round < 3; ++round) {     // weight is a tenth of what the bush carries: converges at once
    const Vector3d turned = make_R_SU({q[0], q[1]}).transpose() * arm;
    const Vector3d moment = turned.cross(Vector3d(0.0, 0.0, -weight));  // of the sole's weight on the bush
    // The bush turns the sole back by -K q - O.
    for (int a = 0; a < kAxes; ++a) q[static_cast<size_t>(a)] = (moment[a] - O[a]) / K[a];
  }
  return q;
}

std::vector<SensorZero> BushObserver::calc_zeros(const RobotLog& hanging, const std::vector<HangingAngles>& angles) const {
  const Impl::Chain chain = impl_->calc_chain(hanging);
  const Vector3d gyro_bias = hanging.gyro.rowwise().mean();
  const Samples n_I = impl_->calc_vertical(hanging, chain, gyro_bias, std::vector<bool>(impl_->feet.size(), false)).n_I;
  std::vector<SensorZero> zeros(impl_->feet.size());
  for (size_t f = 0; f < zeros.size(); ++f) {
    // At rest the foot pulls its weight on the sensor, down; that of the sole where it has tilted to.
    const Impl::Foot& foot = impl_->feet[f];
    const double share = 1.0 - foot.upper_mass / foot.mass;
    const Matrix3d R_US = angles.empty() ? Matrix3d::Identity() : make_R_SU({angles[f][0], angles[f][1]}).transpose().eval();
    const Vector3d p_Ucm = foot.p_Ucm + share * (R_US * (foot.p_Ucm - foot.p_UC) - (foot.p_Ucm - foot.p_UC));
    Samples error = hanging.wrenches[f];
    for (Eigen::Index k = 0; k < hanging.size(); ++k) {
      const Vector3d weight = -foot.mass * kGravity * (chain.X_UI[f][static_cast<size_t>(k)].R * n_I.col(k));
      error.col(k).head<3>() -= weight;
      error.col(k).tail<3>() -= p_Ucm.cross(weight);
    }
    zeros[f].gyro_bias = gyro_bias;
    zeros[f].bias = error.rowwise().mean();
    const Samples rest = error.colwise() - Eigen::VectorXd(zeros[f].bias);
    const double n = static_cast<double>(hanging.size());
    zeros[f].covariance = rest * rest.transpose() / (n - 1.0) / n;
  }
  return zeros;
}

MotionTrack BushObserver::observe(const RobotLog& log, const std::vector<SensorZero>& zeros) const {
  const Eigen::Index margin = GaussianFilter(2.0 * kSmoothing, log.period).margin() + 1;
  if (log.size() < 4 * margin) throw std::runtime_error(log.name + ": too short");
  MotionTrack track;
  track.name = log.name;
  track.period = kThinning * log.period;
  track.time.resize((log.size() - 2 * margin - 1) / kThinning + 1);
  for (Eigen::Index j = 0; j < track.time.size(); ++j) {
    track.time[j] = static_cast<double>(margin + j * kThinning) * log.period;
  }
  track.feet.resize(impl_->feet.size());
  for (size_t f = 0; f < impl_->feet.size(); ++f) {
    track.loaded.push_back((log.wrenches[f].row(2).array() - zeros[f].bias[2]).segment(margin, log.size() - 2 * margin).minCoeff() > kAirborne);
  }
  const Impl::Chain chain = impl_->calc_chain(log);
  const Impl::Vertical vertical = impl_->calc_vertical(log, chain, zeros[0].gyro_bias, track.loaded);
  for (size_t f = 0; f < impl_->feet.size(); ++f) impl_->fill_foot(log, chain, vertical, zeros[f], f, &track);
  impl_->fill_between(log, chain, vertical.n_I, &track);
  return track;
}

}  // namespace hrp::identification
