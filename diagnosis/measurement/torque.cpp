// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/smooth.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/torque_flags.h"
#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

// Cutoff frequencies to try [Hz], highest first.
constexpr double kCutoffs[] = {40.0, 30.0, 24.0, 19.0, 15.0, 12.0, 10.0, 8.5, 7.0, 6.0, 5.0, 4.0, 3.0};
// Factor on the frequency below which 90 % of the velocity's energy lies. Friction has harmonics of the motion. Above
// them there is only noise, structural vibration and rattling, which no term describes.
constexpr double kOfMotion = 2.5;
constexpr double kLeastLimit = 8.5;      // [Hz] friction reverses sharply even in slow motion
constexpr double kFastestMotion = 10.0;  // [Hz] fastest intended motion of a drive
constexpr double kLowestMotion = 0.5, kFrequencyStep = 1.15;  // [Hz], factor
// Kept samples per period of the cutoff: enough to lose nothing, and few duplicates.
constexpr double kPerPeriod = 5.0;
// [s] left out at both ends, where derivatives are one-sided.
constexpr double kTrim = 0.15;
// Speeds below this share of the largest one, or within the noise, have no certain direction.
constexpr double kSlowShare = 0.005;
constexpr double kSlowest = 1e-4;  // [rad/s]
// Cutoffs [Hz] that are tried for speeds, highest first. Dry friction reverses within milliseconds. Its law is evaluated
// before both sides of the equation are filtered, so it needs the sharpest speed that noise allows.
constexpr double kSpeedCutoffs[] = {160.0, 80.0, 40.0, 20.0};
// [s] Shorter recordings have no samples between their ends.
constexpr double kShortest = 0.5;

// Standard deviation of a filtered position after `order` derivatives, for white noise up to the cutoff.
double scale_noise(double sigma, double step, double cutoff, int order) {
  const double omega = 2.0 * M_PI * cutoff, share = std::min(1.0, 2.0 * cutoff * step);
  return sigma * std::pow(omega, order) * std::sqrt(share / (2.0 * order + 1.0));
}

// Position noise including the encoder's resolution. A signal that moves less than one step per sample repeats its
// values, so high-pass estimates of its noise give zero.
double find_position_noise(const Experiment& e, size_t joint) {
  return std::max(e.joint_noise[joint][0].sigma, find_encoder_step(e, joint) / std::sqrt(12.0));
}

EffortSource find_source(const Experiment& e, size_t j) {
  const JointSpec& joint = e.robot.tree.joint(static_cast<int>(j));
  if (!joint.actuated) return EffortSource::kRecorded;  // without a drive: y = 0
  bool effort = true, command = true, learnt = false;
  for (const Recording& r : e.recordings) {
    const bool logged = r.joints[j].has(Quantity::kEffort);
    effort = effort && logged, learnt = learnt || (logged && r.spec.train);
    command = command && !r.joints[j].command.empty();
  }
  if (effort) return EffortSource::kRecorded;
  const auto it = e.scenario.servo_joints.find(joint.name);
  const ServoGains& gains = it == e.scenario.servo_joints.end() ? e.scenario.servo_default : it->second;
  if (command && e.scenario.drive == "servo" && gains.kp > 0.0) return EffortSource::kServoLaw;
  return learnt ? EffortSource::kRecorded : EffortSource::kNone;
}

// What is not said of a joint's drive because its effort was not logged, with the files; empty if everything is.
std::string describe_unlogged(const Experiment& e, int joint, EffortSource source) {
  if (source == EffortSource::kServoLaw || !e.robot.tree.joint(joint).actuated) return "";
  std::string files;
  for (const Recording& r : e.recordings) {
    const bool told = source == EffortSource::kRecorded && r.joints[static_cast<size_t>(joint)].has(Quantity::kEffort);
    if (!told) files += (files.empty() ? "" : ", ") + r.spec.name;
  }
  if (files.empty()) return "";
  const std::string what = files + ": no column " + e.signal_name(joint, Quantity::kEffort);
  if (source == EffortSource::kRecorded) return what + ": of this joint's drive the other recordings tell";
  return what + (e.scenario.drive == "servo" ? ", and no command with gains" : "") +
         ": nothing is said of this joint's drive; if nothing drives it, list it under 'unactuated'";
}

// Effort by the servo law at the recording's own samples [N m], and its rate from the commands [N m/s].
struct ServoSeries {
  std::vector<double> effort, command_rate;
};

ServoSeries calc_servo(const Recording& r, size_t j, const JointLaws& laws, const std::vector<double>& rate) {
  const size_t rows = r.size();
  ServoSeries out{std::vector<double>(rows), std::vector<double>(rows, 0.0)};
  std::vector<double> given(rows), speed(rows);
  for (size_t k = 0; k < rows; ++k) read_command(r.time, r.joints[j], r.time[k], k, &given[k], &speed[k]);
  for (size_t k = 0; k < rows; ++k) {
    const double effort = calc_servo_effort(laws, given[k] - r.joints[j].signal[0][k], speed[k] - rate[k], 0.0);
    out.effort[k] = std::clamp(effort, -laws.effort_limit, laws.effort_limit);
    const size_t a = k > 0 ? k - 1 : 0, b = std::min(rows - 1, k + 1);
    if (b > a && std::abs(out.effort[k]) < laws.effort_limit)
      out.command_rate[k] =
          (laws.kp * (given[b] - given[a]) + laws.kd * (speed[b] - speed[a])) / (r.time[b] - r.time[a]);
  }
  return out;
}

bool has_link_encoder(const Recording& recording, const JointSpec& joint) {
  return recording.has(kLinkSide + joint.name + "/position");
}

class Maker {
 public:
  Maker(const Experiment& e, const BodyTorques& bodies) : e_(e), bodies_(bodies), plant_(make_plant(e, {})) {
    data_.experiment = &e;
    data_.behind_gears = bodies != nullptr && !e.scenario.floating_base;
    if (!bodies) data_.feet = list_loaded_feet(e);
    closed_.resize(e.recordings.size()), sudden_.resize(e.recordings.size()), sharp_.resize(e.recordings.size());
    for (size_t r = 0; r < e.recordings.size(); ++r) {
      for (int j = 0; j < e.num_joints(); ++j) {
        const bool known = e.recordings[r].joints[static_cast<size_t>(j)].has(Quantity::kPosition);
        closed_[r].push_back(known ? std::vector<double>{} : close_chain(e, e.recordings[r], j));
      }
    }
  }

  TorqueData make() {
    const size_t n = static_cast<size_t>(e_.num_joints());
    data_.delays = find_servo_delays(e_), data_.servo = find_servo_readings(e_, data_.delays);
    for (size_t j = 0; j < n; ++j) {
      data_.source.push_back(find_source(e_, j));
      noise_.push_back(find_position_noise(e_, j));
      const std::string unlogged = describe_unlogged(e_, static_cast<int>(j), data_.source[j]);
      if (!unlogged.empty()) data_.missing.push_back(unlogged);
    }
    for (const LinkSpec& link : e_.robot.tree.links) data_.load_p_L.push_back(link.inertia.p_LLcm_L);
    data_.cutoff = kFastestMotion;
    curved_ = !bodies_;
    make_motions();
    curved_ = curved_ && has_filter_gap();
    const double limit = std::max(kLeastLimit, kOfMotion * find_motion_frequency());
    for (double cutoff : kCutoffs) {
      data_.cutoff = cutoff;
      if (cutoff > limit) continue;
      const double noise_share = make_motions();
      // Noise of inertia x acceleration, of the effort's spread and of the missing torque's: above, it hides what is missing.
      if (noise_share <= kMinor && find_missing_share() <= kMuch) break;
    }
    for (TorqueRecording& r : data_.recordings) {
      if (curved_) r.sharp_q = sharp_[r.index].q, r.sharp_v = sharp_[r.index].v, r.sharp_a = sharp_[r.index].a;
    }
    find_slow();
    for (TorqueRecording& r : data_.recordings) find_speed(&r), r.load = r.tau;
    choose_encoders();
    data_.loaded_by_drive.assign(data_.source.size(), 0);
    for (int j = 0; j < e_.num_joints(); ++j) {
      if (data_.is_judged(j)) choose_load(j, choose_speed(j));
    }
    for (TorqueRecording& r : data_.recordings) finish(&r);
    for (int j = 0; j < e_.num_joints(); ++j) leave_out_limits(j);
    return std::move(data_);
  }

 private:
  // Computes grids and smoothed motion at the cutoff. Returns the median over joints of the relative noise of inertia x
  // acceleration.
  double make_motions() {
    data_.recordings.clear();
    for (size_t r = 0; r < e_.recordings.size(); ++r) add_recording(r);
    std::vector<double> shares;
    for (size_t j = 0; j < data_.source.size(); ++j) {
      double acceleration = 0.0, effort = 0.0, torque = 0.0;
      for (const TorqueRecording& r : data_.recordings) {
        const auto centre = [&](const Eigen::MatrixXd& m) {
          return (m.col(static_cast<long>(j)).array() - m.col(static_cast<long>(j)).mean()).square().mean();
        };
        acceleration += centre(r.a), effort += centre(r.effort), torque += centre(r.tau);
      }
      if (!data_.is_judged(static_cast<int>(j)) || effort <= 0.0 || acceleration <= 0.0) continue;
      const double step = data_.recordings[0].step;
      shares.push_back(scale_noise(noise_[j], step, data_.cutoff, 2) / std::sqrt(acceleration) *
                       std::sqrt(std::min(1.0, torque / effort)));
    }
    return find_median(std::move(shares));
  }

  // The same noise relative to the missing torque, effort - tau. With a heavy arm and coarse encoders, it may be all of
  // it. Median over joints; 0 if the torques are not those of bodies on a fixed base.
  double find_missing_share() const {
    if (bodies_ || data_.recordings.empty()) return 0.0;
    const Eigen::VectorXd noise = calc_torque_noise(data_.recordings[0]);
    std::vector<double> shares;
    for (long j = 0; j < noise.size(); ++j) {
      double missing = 0.0, rows = 0.0;
      for (const TorqueRecording& r : data_.recordings) {
        const long inner = std::max(0L, r.q.rows() - 2 * r.trim);
        const Eigen::ArrayXd x = (r.effort.col(j) - r.tau.col(j)).segment(r.trim, inner);
        missing += (x - x.mean()).square().sum(), rows += static_cast<double>(inner);
      }
      if (data_.is_judged(static_cast<int>(j)) && missing > 0.0) shares.push_back(noise[j] / std::sqrt(missing / rows));
    }
    return find_median(std::move(shares));
  }

  // Noise [N m] of every joint: noise of all accelerations through the mass matrix, rms over some poses.
  Eigen::VectorXd calc_torque_noise(const TorqueRecording& r) const {
    constexpr long kPoses = 20;
    const long n = r.q.cols(), poses = std::min(kPoses, r.q.rows()), stride = std::max(1L, r.q.rows() / poses);
    Eigen::MatrixXd q(poses, n);
    for (long k = 0; k < poses; ++k) q.row(k) = r.q.row(k * stride);
    const Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(poses, n), weight = calc_efforts(plant_, q, rest, rest);
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
    for (long j = 0; j < n; ++j) {
      Eigen::MatrixXd a = rest;
      a.col(j).setConstant(scale_noise(noise_[static_cast<size_t>(j)], r.step, data_.cutoff, 2));
      squares += (calc_efforts(plant_, q, rest, a) - weight).array().square().colwise().mean().matrix().transpose();
    }
    return squares.cwiseSqrt();
  }

  // [Hz] frequency below which 90 % of the velocity's energy lies; median over joints and recordings.
  double find_motion_frequency() const {
    std::vector<double> found;
    for (const TorqueRecording& r : data_.recordings) {
      for (long j = 0; j < r.v.cols(); ++j) {
        const Eigen::VectorXd v = r.v.col(j).array() - r.v.col(j).mean();
        double f = kLowestMotion;
        while (f < data_.cutoff && low_pass(v, r.step, f).squaredNorm() < kNearlyAll * v.squaredNorm()) f *= kFrequencyStep;
        if (v.squaredNorm() > 0.0) found.push_back(f);
      }
    }
    return found.empty() ? data_.cutoff : find_median(std::move(found));
  }

  // Position as recorded, or from a held foot; empty if unknown.
  const std::vector<double>& find_position(size_t recording, size_t j) const {
    const JointColumns& columns = e_.recordings[recording].joints[j];
    return columns.has(Quantity::kPosition) ? columns.signal[0] : closed_[recording][j];
  }

  void add_recording(size_t index) {
    const Recording& in = e_.recordings[index];
    if (in.size() < 10 || in.duration() < kShortest) return;
    TorqueRecording out;
    out.index = index, out.train = in.spec.train;
    out.begin = in.time.front(), out.step = std::max(1e-3, e_.sample_time);
    const long rows = static_cast<long>(in.duration() / out.step) + 1, n = e_.num_joints();
    out.stride = std::max(1L, std::lround(1.0 / (kPerPeriod * data_.cutoff * out.step)));
    out.trim = std::lround(kTrim / out.step);
    for (Eigen::MatrixXd* m : {&out.q, &out.v, &out.a, &out.effort, &out.effort_rate, &out.command_rate})
      m->setZero(rows, n);
    for (long j = 0; j < n; ++j) {
      if (!fill_joint(in, j, rows, &out)) return;
    }
    if (still_.empty()) still_.resize(e_.recordings.size());
    if (still_[index].size() == 0) still_[index] = find_still(make_raw(in, out, rows), noise_, out.step);
    out.tau = bodies_ ? bodies_(out, data_.cutoff) : calc_efforts(add_by_hand(plant_, in.spec), out.q, out.v, out.a);
    if (!out.tau.allFinite()) leave_out_unknown(&out);
    if (curved_) add_filter_gap(in, &out);
    if (!data_.feet.empty()) add_foot_loads(in, &out);
    leave_out_unlogged(in, &out);
    data_.recordings.push_back(std::move(out));
  }

  // Where nothing tells a joint's torque, it is taken as the effort, so that nothing is missing.
  void leave_out_unknown(TorqueRecording* r) const {
    r->known = r->tau.array().isFinite();
    r->tau = r->known.select(r->tau, r->effort);
  }

  bool is_unlogged(const Recording& in, size_t j) const {
    return data_.source[j] == EffortSource::kRecorded && e_.robot.tree.joint(static_cast<int>(j)).actuated && !in.joints[j].has(Quantity::kEffort);
  }

  // The same where the effort was not logged, but is in another recording.
  void leave_out_unlogged(const Recording& in, TorqueRecording* r) const {
    for (size_t j = 0; j < data_.source.size(); ++j) {
      if (!is_unlogged(in, j)) continue;
      const long column = static_cast<long>(j);
      if (r->known.size() == 0) r->known.setConstant(r->q.rows(), r->q.cols(), true);
      r->known.col(column).setConstant(false), r->effort.col(column) = r->tau.col(column);
    }
  }

  Eigen::MatrixXd smooth_columns(Eigen::MatrixXd m, double step, double cutoff) const {
    for (long j = 0; j < m.cols(); ++j) m.col(j) = low_pass(Eigen::VectorXd(m.col(j)), step, cutoff);
    return m;
  }

  // Motion with the sharpest filter and its nominal torque, full grid.
  struct SharpMotion {
    Eigen::MatrixXd q, v, a, tau;
  };

  void differentiate_columns(const Eigen::MatrixXd& q, double step, Eigen::MatrixXd* v, Eigen::MatrixXd* a) const {
    *v = *a = q;
    for (long j = 0; j < q.cols(); ++j) {
      v->col(j) = differentiate(Eigen::VectorXd(q.col(j)), step);
      a->col(j) = differentiate(Eigen::VectorXd(v->col(j)), step);
    }
  }

  const SharpMotion& find_sharp_motion(const Recording& in, const TorqueRecording& out) {
    SharpMotion& sharp = sharp_[out.index];
    if (sharp.q.size() > 0) return sharp;
    sharp.q = smooth_columns(make_raw(in, out, out.q.rows()), out.step, kCutoffs[0]);
    differentiate_columns(sharp.q, out.step, &sharp.v, &sharp.a);
    sharp.tau = calc_efforts(add_by_hand(plant_, in.spec), sharp.q, sharp.v, sharp.a);
    return sharp;
  }

  // Smoothed torque of the sharp motion in place of the torque of the smoothed motion. Both sides of the gap start from the
  // sharp motion, so a linear model has none.
  void add_filter_gap(const Recording& in, TorqueRecording* out) {
    const SharpMotion& sharp = find_sharp_motion(in, *out);
    const Eigen::MatrixXd q = smooth_columns(sharp.q, out->step, data_.cutoff);
    Eigen::MatrixXd v, a;
    differentiate_columns(q, out->step, &v, &a);
    out->filter_gap = smooth_columns(sharp.tau, out->step, data_.cutoff) - calc_efforts(add_by_hand(plant_, in.spec), q, v, a);
    out->tau += out->filter_gap;
  }

  // True if a joint's gap is more of its missing torque than filters leave uncertain anyway. Arms are below a hundredth,
  // pendulums that turn over at a half.
  bool has_filter_gap() const {
    Eigen::VectorXd gap = Eigen::VectorXd::Zero(e_.num_joints()), missing = gap;
    for (const TorqueRecording& r : data_.recordings) {
      const long inner = std::max(0L, r.q.rows() - 2 * r.trim);
      gap += r.filter_gap.middleRows(r.trim, inner).colwise().squaredNorm().transpose();
      missing += (r.effort - r.tau).middleRows(r.trim, inner).colwise().squaredNorm().transpose();
    }
    for (int j = 0; j < e_.num_joints(); ++j) {
      if (data_.is_judged(j) && gap[j] > kBlur * kBlur * missing[j]) return true;
    }
    return false;
  }

  void add_foot_loads(const Recording& in, TorqueRecording* out) {
    Flags& sudden = sudden_[out->index];
    sudden = Flags::Constant(out->q.rows(), false);
    out->foot_wrench.setZero(out->q.rows(), static_cast<long>(6 * data_.feet.size()));
    for (size_t f = 0; f < data_.feet.size(); ++f) {
      const auto columns = find_wrench_columns(in, data_.feet[f].sensor);
      for (size_t i = 0; i < 6; ++i) {
        if (!columns[i]) continue;
        const Eigen::VectorXd raw = resample(in.time, *columns[i], out->begin, out->step, out->q.rows());
        const Eigen::VectorXd smooth = low_pass(raw, out->step, data_.cutoff);
        mark_sudden(raw, smooth, std::lround(kFilterReach / data_.cutoff / out->step), &sudden);
        out->foot_wrench.col(static_cast<long>(6 * f + i)) = smooth;
      }
    }
    const Model& model = *plant_.model;
    Data data(model);
    State state = make_state(model);
    for (long k = 0; k < out->q.rows(); ++k) {
      state.q = out->q.row(k), state.qd = out->v.row(k);
      update_kinematics(model, state, &data);
      out->tau.row(k) -= calc_load_torques(model, data, data_.feet, out->foot_wrench.row(k));
    }
  }

  Eigen::MatrixXd make_raw(const Recording& in, const TorqueRecording& out, long rows) const {
    Eigen::MatrixXd raw(rows, out.q.cols());
    for (long j = 0; j < raw.cols(); ++j)
      raw.col(j) = resample(in.time, find_position(out.index, static_cast<size_t>(j)), out.begin, out.step, rows);
    return raw;
  }

  bool fill_joint(const Recording& in, long joint, long rows, TorqueRecording* out) {
    const size_t j = static_cast<size_t>(joint);
    const std::vector<double>& position = find_position(out->index, j);
    if (position.empty()) {
      const std::string text = in.spec.name + ": no column " + e_.signal_name(static_cast<int>(joint), Quantity::kPosition) +
                               ": the recording is left out";
      if (std::find(data_.missing.begin(), data_.missing.end(), text) == data_.missing.end())
        data_.missing.push_back(text);
      return false;
    }
    const auto smooth = [&](const std::vector<double>& series) -> Eigen::VectorXd {
      return low_pass(resample(in.time, series, out->begin, out->step, rows), out->step, data_.cutoff);
    };
    out->q.col(joint) = smooth(position);
    out->v.col(joint) = differentiate(out->q.col(joint), out->step);
    out->a.col(joint) = differentiate(out->v.col(joint), out->step);
    const JointSpec& spec = e_.robot.tree.joint(static_cast<int>(joint));
    if (!spec.actuated || data_.source[j] == EffortSource::kNone || is_unlogged(in, j)) return true;
    if (data_.source[j] == EffortSource::kRecorded) {
      const ServoReading& log = data_.servo[j];
      out->effort.col(joint) = (smooth(in.joints[j].signal[2]).array() - log.bias) / log.scale;
    } else {
      const ServoSeries servo = calc_servo(in, j, plant_.laws[j], find_rate(in, j, *out));
      out->effort.col(joint) = smooth(servo.effort);
      out->command_rate.col(joint) = smooth(servo.command_rate);
    }
    out->effort_rate.col(joint) = differentiate(out->effort.col(joint), out->step);
    return true;
  }

  // Velocity that the servo uses, at the recording's samples: recorded, else of the smoothed position.
  std::vector<double> find_rate(const Recording& in, size_t j, const TorqueRecording& out) const {
    if (in.joints[j].has(Quantity::kVelocity)) return in.joints[j].signal[1];
    std::vector<double> grid(static_cast<size_t>(out.v.rows())), rate(in.size());
    std::vector<double> values(grid.size());
    for (size_t k = 0; k < grid.size(); ++k) {
      grid[k] = out.begin + out.step * static_cast<double>(k);
      values[k] = out.v(static_cast<long>(k), static_cast<long>(j));
    }
    for (size_t k = 0; k < rate.size(); ++k)
      rate[k] = interpolate(grid, values, in.time[k], std::min(k, grid.size() - 1));
    return rate;
  }

  void find_slow() {
    for (size_t j = 0; j < data_.source.size(); ++j) {
      double fastest = 0.0, noise = 0.0;
      for (const TorqueRecording& r : data_.recordings) {
        fastest = std::max(fastest, r.v.col(static_cast<long>(j)).cwiseAbs().maxCoeff());
        noise = scale_noise(noise_[j], r.step, data_.cutoff, 1);
      }
      data_.slow.push_back(std::max({kAboveNoise * noise, kSlowShare * fastest, kSlowest}));
    }
  }

  // Takes the speed from the recorded velocity, else from the position. Keeps the smoothed one if both are too noisy.
  void find_speed(TorqueRecording* r) const {
    const Recording& in = e_.recordings[r->index];
    r->speed = r->v;
    for (long j = 0; j < r->v.cols(); ++j) {
      const size_t joint = static_cast<size_t>(j);
      const bool recorded = in.joints[joint].has(Quantity::kVelocity);
      const double sigma = recorded ? e_.joint_noise[joint][static_cast<size_t>(Quantity::kVelocity)].sigma : noise_[joint];
      for (double cutoff : kSpeedCutoffs) {
        if (cutoff <= data_.cutoff || cutoff > 0.5 / r->step) continue;
        if (scale_noise(sigma, r->step, cutoff, recorded ? 0 : 1) > data_.slow[joint]) continue;
        const std::vector<double>& series = recorded ? in.joints[joint].signal[static_cast<size_t>(Quantity::kVelocity)] : find_position(r->index, joint);
        const Eigen::VectorXd sharp = low_pass(resample(in.time, series, r->begin, r->step, r->q.rows()), r->step, cutoff);
        r->speed.col(j) = recorded ? sharp : differentiate(sharp, r->step);
        break;
      }
    }
  }

  // Regressors of a drive's effort beside the bodies' torque, on the full grid: acceleration, speed, direction,
  // direction x |load|, 1.
  Eigen::MatrixXd make_load_columns(const TorqueRecording& r, int j) const {
    const Eigen::VectorXd sign = data_.calc_sign(r, j);
    Eigen::MatrixXd x(r.q.rows(), 5);
    x << r.a.col(j), r.v.col(j), low_pass(sign, r.step, data_.cutoff), low_pass(sign.cwiseProduct(r.load.col(j).cwiseAbs()), r.step, data_.cutoff),
        Eigen::VectorXd::Ones(r.q.rows());
    return x;
  }

  struct LoadFit {
    Eigen::VectorXd theta;  // of the columns
    double left = 0.0;      // [(N m)^2] sum of squares
  };

  // Least squares of effort - tau on the training recordings, with the present r.load.
  LoadFit fit_loads(int j) const {
    Eigen::MatrixXd xx = Eigen::MatrixXd::Zero(5, 5);
    LoadFit fit{Eigen::VectorXd::Zero(5), 0.0};
    Eigen::VectorXd xy = fit.theta;
    for (const TorqueRecording& r : data_.recordings) {
      const long inner = r.q.rows() - 2 * r.trim;
      if (!r.train || inner <= 0) continue;
      Eigen::MatrixXd x = make_load_columns(r, j).middleRows(r.trim, inner);
      Eigen::VectorXd y = (r.effort.col(j) - r.tau.col(j)).segment(r.trim, inner);
      if (r.known.size() > 0) {
        const Eigen::ArrayXd known = r.known.col(j).segment(r.trim, inner).cast<double>();
        x.array().colwise() *= known, y.array() *= known;
      }
      xx += x.transpose() * x, xy += x.transpose() * y, fit.left += y.squaredNorm();
    }
    fit.theta = xx.completeOrthogonalDecomposition().solve(xy);
    fit.left -= xy.dot(fit.theta);
    return fit;
  }

  // Squares that fit_loads leaves, each joint's over the squares of its effort.
  double calc_all_left() const {
    double left = 0.0;
    for (int j = 0; j < e_.num_joints(); ++j) {
      double efforts = 0.0;
      for (const TorqueRecording& r : data_.recordings) efforts += r.train ? r.effort.col(j).squaredNorm() : 0.0;
      if (data_.is_judged(j) && efforts > 0.0) left += fit_loads(j).left / efforts;
    }
    return left;
  }

  void read_link_motion(TorqueRecording* r) const {
    const Recording& in = e_.recordings[r->index];
    r->link_q = r->q, r->link_v = r->v, r->link_a = r->a;
    for (int j = 0; j < e_.num_joints(); ++j) {
      if (!has_link_encoder(in, e_.robot.tree.joint(j))) continue;
      r->link_q.col(j) = read_link_angle(e_, j, *r, data_.cutoff);
      r->link_v.col(j) = differentiate(r->link_q.col(j), r->step);
      r->link_a.col(j) = differentiate(r->link_v.col(j), r->step);
    }
    for (Eigen::MatrixXd* m : {&r->filter_gap, &r->sharp_q, &r->sharp_v, &r->sharp_a}) m->resize(0, 0);
    r->tau = r->load = calc_efforts(add_by_hand(plant_, in.spec), r->link_q, r->link_v, r->link_a);
  }

  // Takes the links' motion from their own encoders. The training recordings decide, because an encoder may be faulty.
  void choose_encoders() {
    const auto has_any = [&](const Recording& r) {
      return std::any_of(e_.robot.tree.links.begin() + 1, e_.robot.tree.links.end(), [&](const LinkSpec& link) { return has_link_encoder(r, link.joint); });
    };
    if (bodies_ || !data_.feet.empty() || !std::all_of(e_.recordings.begin(), e_.recordings.end(), has_any)) return;
    const double by_drives = calc_all_left();
    std::vector<TorqueRecording> of_drives = data_.recordings;
    for (TorqueRecording& r : data_.recordings) read_link_motion(&r);
    if (calc_all_left() > (1.0 - kMinor) * by_drives) data_.recordings = std::move(of_drives);
  }

  // Friction that bends before it slips reverses slowly. For such a joint the smoothed speed predicts the effort better.
  // Returns the fit with the chosen speed.
  LoadFit choose_speed(int j) {
    std::vector<Eigen::VectorXd> sharp;
    const LoadFit with_sharp = fit_loads(j);
    for (TorqueRecording& r : data_.recordings) sharp.push_back(r.speed.col(j)), r.speed.col(j) = r.v.col(j);
    const LoadFit with_smooth = fit_loads(j);
    if (with_smooth.left < kNearlyAll * with_sharp.left) return with_smooth;
    for (size_t r = 0; r < sharp.size(); ++r) data_.recordings[r].speed.col(j) = sharp[r];
    return with_sharp;
  }

  // Chooses the load of a joint, see TorqueData::loaded_by_drive; `bodies`: the fit with the bodies' torque. The load of a
  // drive is its effort as the regressors predict it. The recorded effort is the left side of the equation; as a regressor
  // it would explain its own errors.
  void choose_load(int j, const LoadFit& bodies) {
    if (!e_.robot.tree.joint(j).actuated) return;
    for (TorqueRecording& r : data_.recordings) r.load.col(j) += make_load_columns(r, j) * bodies.theta;
    // A smaller difference decides nothing.
    const bool by_drive = fit_loads(j).left < (1.0 - kKnown) * bodies.left;
    data_.loaded_by_drive[static_cast<size_t>(j)] = by_drive;
    for (TorqueRecording& r : data_.recordings) {
      if (!by_drive) r.load.col(j) = r.tau.col(j);
    }
  }

  // Torque of the joint's laws, from its description and the experiment, at the kept samples [N m].
  Eigen::VectorXd calc_stated(const TorqueRecording& r, int j) const {
    const JointLaws& laws = plant_.laws[static_cast<size_t>(j)];
    const Eigen::VectorXd sign = data_.calc_sign(r, j);
    Eigen::VectorXd friction = Eigen::VectorXd::Zero(r.v.rows());
    for (long k = 0; k < friction.size() && laws.has_friction(); ++k)
      friction[k] = sign[k] * calc_friction_level(laws, std::abs(r.speed(k, j)), r.load(k, j), sign[k] > 0.0 ? 1.0 : -1.0);
    Eigen::VectorXd stated = data_.condition(r, friction);
    for (long k = 0; k < stated.size(); ++k) {
      const long row = r.full_row(k);
      stated[k] += calc_taken_torque(laws, r.q(row, j) - laws.joint_offset, r.v(row, j), r.a(row, j));
    }
    return stated;
  }

  // Full grid: true where all torques on the joint are known.
  Flags find_known(const TorqueRecording& r, long j) const {
    const RecordingSpec& spec = e_.recordings[r.index].spec;
    const JointSpec& joint = e_.robot.tree.joint(static_cast<int>(j));
    const bool pushed = std::find(spec.unknown_force.begin(), spec.unknown_force.end(), joint.name) != spec.unknown_force.end();
    // from the equation of a foot, not measured
    const bool followed = !closed_[r.index][static_cast<size_t>(j)].empty();
    if (pushed || followed) return Flags::Constant(r.q.rows(), false);
    Flags known = find_read(r, static_cast<size_t>(j));
    if (r.known.size() > 0) known = known && r.known.col(j);
    if (data_.feet.empty()) return known;
    known = known && !sudden_[r.index];
    return joint.actuated ? Flags(known && !find_clipped(r.effort.col(j))) : known;
  }

  // Full grid: true where every joint's position and this joint's effort were recorded.
  Flags find_read(const TorqueRecording& r, size_t joint) const {
    const Recording& in = e_.recordings[r.index];
    Flags read = Flags::Constant(r.q.rows(), true);
    for (size_t j = 0; j < in.joints.size(); ++j) {
      const std::vector<double>& effort = in.joints[j].signal[static_cast<int>(Quantity::kEffort)];
      if (in.joints[j].has(Quantity::kPosition)) mark_gaps(in.time, in.joints[j].signal[0], r, e_.sample_time, data_.cutoff, &read);
      if (j == joint && data_.source[j] == EffortSource::kRecorded) mark_gaps(in.time, effort, r, e_.sample_time, data_.cutoff, &read);
    }
    return read;
  }

  // Kept samples within the filter's reach of a recorded effort at its limit.
  Flags find_limited(const TorqueRecording& r, int j) const {
    const Recording& in = e_.recordings[r.index];
    const std::vector<double>& log = in.joints[static_cast<size_t>(j)].signal[static_cast<int>(Quantity::kEffort)];
    const double limit = (1.0 - kMinor) * plant_.laws[static_cast<size_t>(j)].effort_limit;
    Flags limited = Flags::Constant(r.kept(), false);
    if (log.empty() || !std::isfinite(limit)) return limited;
    const Flags high = resample(in.time, log, r.begin, r.step, r.q.rows()).array().abs() > limit;
    const long reach = std::lround(kFilterReach / data_.cutoff / r.step);
    for (long k = 0; k < limited.size(); ++k) {
      const long from = std::max(0L, r.full_row(k) - reach), to = std::min(high.size(), r.full_row(k) + reach + 1);
      limited[k] = high.segment(from, to - from).any();
    }
    return limited;
  }

  // A servo that oscillates between its limits jumps by twice the limit within a sample. The filtered error of half a
  // sample is then larger than friction. Such stretches are left out if enough others remain.
  void leave_out_limits(int j) {
    if (data_.source[static_cast<size_t>(j)] != EffortSource::kRecorded) return;
    std::vector<Flags> limited;
    double used = 0.0, left = 0.0;
    for (const TorqueRecording& r : data_.recordings) {
      limited.push_back(find_limited(r, j));
      if (!r.train) continue;
      used += static_cast<double>(r.use.col(j).count());
      left += static_cast<double>((r.use.col(j) && !limited.back()).count());
    }
    for (size_t r = 0; r < limited.size() && left > kPart * used; ++r)
      data_.recordings[r].use.col(j) = data_.recordings[r].use.col(j) && !limited[r];
  }

  // Missing torque at the kept samples: effort minus bodies minus the joint's own laws.
  void finish(TorqueRecording* r) {
    const long kept = std::max(0L, (r->q.rows() - 2 * r->trim + r->stride - 1) / r->stride), n = r->q.cols();
    r->missing.setZero(kept, n);
    r->use.setConstant(kept, n, false);
    const Flags frozen = data_.feet.empty() ? find_frozen(*r, still_[r->index]) : Flags::Constant(r->q.rows(), false);
    if (frozen.any()) {
      long first = 0;
      while (!frozen[first]) ++first;
      data_.frozen.push_back(r->index);
      data_.warnings.push_back(e_.recordings[r->index].spec.name + ": no joint moves although efforts change, from about " +
                               number(r->begin + r->step * static_cast<double>(first), 3) +
                               " s: this stretch is left out");
    }
    for (long j = 0; j < n; ++j) {
      const Eigen::VectorXd stated = calc_stated(*r, static_cast<int>(j));
      const Flags moving = find_moving(r->v.col(j), data_.slow[static_cast<size_t>(j)], r->step, data_.cutoff);
      const Flags known = find_known(*r, j);
      for (long k = 0; k < kept; ++k) {
        const long row = r->full_row(k);
        r->missing(k, j) = r->effort(row, j) - r->tau(row, j) - stated[k];
        r->use(k, j) = data_.is_judged(static_cast<int>(j)) && !frozen[row] && moving[row] && known[row];
      }
    }
  }

  const Experiment& e_;
  const BodyTorques& bodies_;
  const Plant plant_;
  TorqueData data_;
  std::vector<double> noise_;  // [rad] by joint
  std::vector<Flags> still_;   // by recording of the experiment, full grid
  std::vector<Flags> sudden_;  // the same; of robots with loaded feet
  std::vector<SharpMotion> sharp_;  // by recording of the experiment
  bool curved_ = false;             // the torque of the smoothed motion is not the smoothed torque
  std::vector<std::vector<std::vector<double>>> closed_;  // by recording, by joint: positions from a held foot
};

}  // namespace

Eigen::VectorXd TorqueData::condition(const TorqueRecording& r, const Eigen::VectorXd& full) const {
  const Eigen::VectorXd filtered = low_pass(full, r.step, cutoff);
  const long kept = std::max(0L, (full.size() - 2 * r.trim + r.stride - 1) / r.stride);
  Eigen::VectorXd out(kept);
  for (long k = 0; k < kept; ++k) out[k] = filtered[r.full_row(k)];
  return out;
}

Eigen::VectorXd TorqueData::calc_sign(const TorqueRecording& r, int joint) const {
  return (r.speed.col(joint).array() / slow[static_cast<size_t>(joint)]).tanh().matrix();
}

Eigen::VectorXd TorqueData::calc_direction(const TorqueRecording& r, int joint) const {
  return condition(r, calc_sign(r, joint));
}

Eigen::VectorXd read_link_angle(const Experiment& experiment, int joint, const TorqueRecording& r, double cutoff) {
  const Recording& in = experiment.recordings[r.index];
  const std::vector<double>& angle = in.other.at(kLinkSide + experiment.robot.tree.joint(joint).name + "/position");
  return low_pass(resample(in.time, angle, r.begin, r.step, r.q.rows()), r.step, cutoff);
}

TorqueData make_torque_data(const Experiment& experiment) { return make_torque_data(experiment, nullptr); }

TorqueData make_torque_data(const Experiment& experiment, const BodyTorques& bodies) {
  const std::vector<VelocityReading> velocity = find_velocity_readings(experiment);
  const bool faulty = std::any_of(velocity.begin(), velocity.end(), [](const VelocityReading& log) { return log.is_faulty(); });
  TorqueData data = faulty ? Maker(correct_joint_logs(experiment, velocity), bodies).make() : Maker(experiment, bodies).make();
  data.experiment = &experiment, data.velocity = velocity;
  return data;
}

}  // namespace hrp::diagnosis
