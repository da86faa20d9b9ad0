// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/motion.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/kept_samples.h"
#include "diagnosis/measurement/torque/effort.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

// Cutoff frequencies to try [Hz], highest first.
constexpr double kCutoffs[] = {40.0, 30.0, 24.0, 19.0, 15.0, 12.0, 10.0, 8.5, 7.0, 6.0, 5.0, 4.0, 3.0};
// Factor on the frequency below which 90 % of the velocity's energy lies. Friction has harmonics of the motion. Above
// them there is only noise, structural vibration and rattling, which no term describes.
constexpr double kOfMotion = 2.5;
constexpr double kLeastLimit = 8.5;                           // [Hz] friction reverses sharply even in slow motion
constexpr double kFastestMotion = 10.0;                       // [Hz] fastest intended motion of a drive
constexpr double kLowestMotion = 0.5, kFrequencyStep = 1.15;  // [Hz], factor
// [s] left out at both ends, where derivatives are one-sided.
constexpr double kTrim = 0.15;
// Speeds below this share of the largest one, or within the noise, have no certain direction.
constexpr double kSlowShare = 0.005;
constexpr double kSlowest = 1e-4;  // [rad/s]
// Cutoffs [Hz] that are tried for speeds, highest first. Dry friction reverses within milliseconds. Its law is
// evaluated before both sides of the equation are filtered, so it needs the sharpest speed that noise allows.
constexpr double kSpeedCutoffs[] = {160.0, 80.0, 40.0, 20.0};

// Standard deviation of a filtered position after `order` derivatives, for white noise up to the cutoff.
double scale_noise(double sigma, double step, double cutoff, int order) {
  const double omega = 2.0 * M_PI * cutoff, share = std::min(1.0, 2.0 * cutoff * step);
  return sigma * std::pow(omega, order) * std::sqrt(share / (2.0 * order + 1.0));
}

// Position as recorded, or from a held foot; empty if unknown.
const std::vector<double>& find_position(const TorqueWork& w, size_t recording, size_t j) {
  const JointColumns& columns = w.e.recordings[recording].joints[j];
  return columns.has(Quantity::kPosition) ? columns.signal[0] : w.closed[recording][j];
}

Eigen::MatrixXd smooth_columns(Eigen::MatrixXd m, double step, double cutoff) {
  for (long j = 0; j < m.cols(); ++j) m.col(j) = low_pass(Eigen::VectorXd(m.col(j)), step, cutoff);
  return m;
}

void differentiate_columns(const Eigen::MatrixXd& q, double step, Eigen::MatrixXd* v, Eigen::MatrixXd* a) {
  *v = *a = q;
  for (long j = 0; j < q.cols(); ++j) {
    v->col(j) = differentiate(Eigen::VectorXd(q.col(j)), step);
    a->col(j) = differentiate(Eigen::VectorXd(v->col(j)), step);
  }
}

Eigen::MatrixXd make_raw(const TorqueWork& w, const Recording& in, const TorqueRecording& out, long rows) {
  Eigen::MatrixXd raw(rows, out.q.cols());
  for (long j = 0; j < raw.cols(); ++j)
    raw.col(j) = resample(in.time, find_position(w, out.index, static_cast<size_t>(j)), out.begin, out.step, rows);
  return raw;
}

const SharpMotion& find_sharp_motion(TorqueWork* w, const Recording& in, const TorqueRecording& out) {
  SharpMotion& sharp = w->sharp[out.index];
  if (sharp.q.size() > 0) return sharp;
  sharp.q = smooth_columns(make_raw(*w, in, out, out.q.rows()), out.step, kCutoffs[0]);
  differentiate_columns(sharp.q, out.step, &sharp.v, &sharp.a);
  sharp.tau = calc_efforts(add_by_hand(w->plant, in.spec), sharp.q, sharp.v, sharp.a);
  return sharp;
}

// Smoothed torque of the sharp motion in place of the torque of the smoothed motion. Both sides of the gap start from
// the sharp motion, so a linear model has none.
void add_filter_gap(TorqueWork* w, const Recording& in, TorqueRecording* out) {
  const SharpMotion& sharp = find_sharp_motion(w, in, *out);
  const Eigen::MatrixXd q = smooth_columns(sharp.q, out->step, w->data.cutoff);
  Eigen::MatrixXd v, a;
  differentiate_columns(q, out->step, &v, &a);
  out->filter_gap =
      smooth_columns(sharp.tau, out->step, w->data.cutoff) - calc_efforts(add_by_hand(w->plant, in.spec), q, v, a);
  out->tau += out->filter_gap;
}

// True if a joint's gap is more of its missing torque than filters leave uncertain anyway. Arms are below a hundredth,
// pendulums that turn over at a half.
bool has_filter_gap(const TorqueWork& w) {
  Eigen::VectorXd gap = Eigen::VectorXd::Zero(w.e.num_joints()), missing = gap;
  for (const TorqueRecording& r : w.data.recordings) {
    const long inner = std::max(0L, r.q.rows() - 2 * r.trim);
    gap += r.filter_gap.middleRows(r.trim, inner).colwise().squaredNorm().transpose();
    missing += (r.effort - r.tau).middleRows(r.trim, inner).colwise().squaredNorm().transpose();
  }
  for (int j = 0; j < w.e.num_joints(); ++j) {
    if (w.data.is_judged(j) && gap[j] > kBlur * kBlur * missing[j]) return true;
  }
  return false;
}

void add_foot_loads(TorqueWork* w, const Recording& in, TorqueRecording* out) {
  Flags& sudden = w->sudden[out->index];
  sudden = Flags::Constant(out->q.rows(), false);
  out->foot_wrench.setZero(out->q.rows(), static_cast<long>(6 * w->data.feet.size()));
  for (size_t f = 0; f < w->data.feet.size(); ++f) {
    const auto columns = find_wrench_columns(in, w->data.feet[f].sensor);
    for (size_t i = 0; i < 6; ++i) {
      if (!columns[i]) continue;
      const Eigen::VectorXd raw = resample(in.time, *columns[i], out->begin, out->step, out->q.rows());
      const Eigen::VectorXd smooth = low_pass(raw, out->step, w->data.cutoff);
      mark_sudden(raw, smooth, std::lround(kFilterReach / w->data.cutoff / out->step), &sudden);
      out->foot_wrench.col(static_cast<long>(6 * f + i)) = smooth;
    }
  }
  const Model& model = *w->plant.model;
  Data data(model);
  State state = make_state(model);
  for (long k = 0; k < out->q.rows(); ++k) {
    state.q = out->q.row(k);
    state.qd = out->v.row(k);
    update_kinematics(model, state, &data);
    out->tau.row(k) -= calc_load_torques(model, data, w->data.feet, out->foot_wrench.row(k));
  }
}

// Where nothing tells a joint's torque, it is taken as the effort, so that nothing is missing.
void leave_out_unknown(TorqueRecording* r) {
  r->known = r->tau.array().isFinite();
  r->tau = r->known.select(r->tau, r->effort);
}

bool is_unlogged(const TorqueWork& w, const Recording& in, size_t j) {
  return w.data.source[j] == EffortSource::kRecorded && w.e.robot.tree.joint(static_cast<int>(j)).actuated &&
         !in.joints[j].has(Quantity::kEffort);
}

// The same where the effort was not logged, but is in another recording.
void leave_out_unlogged(const TorqueWork& w, const Recording& in, TorqueRecording* r) {
  for (size_t j = 0; j < w.data.source.size(); ++j) {
    if (!is_unlogged(w, in, j)) continue;
    const long column = static_cast<long>(j);
    if (r->known.size() == 0) r->known.setConstant(r->q.rows(), r->q.cols(), true);
    r->known.col(column).setConstant(false);
    r->effort.col(column) = r->tau.col(column);
  }
}

// Velocity that the servo uses, at the recording's samples: known, recorded, else of the smoothed position.
std::vector<double> find_rate(const Recording& in, size_t j, const TorqueRecording& out) {
  if (in.has(name_servo_rate(j))) return in.other.at(name_servo_rate(j));
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

bool fill_joint(TorqueWork* w, const Recording& in, long joint, long rows, TorqueRecording* out) {
  const size_t j = static_cast<size_t>(joint);
  const std::vector<double>& position = find_position(*w, out->index, j);
  if (position.empty()) {
    const std::string text = in.spec.name + ": no column " +
                             w->e.signal_name(static_cast<int>(joint), Quantity::kPosition) +
                             ": the recording is left out";
    if (!has(w->data.missing, text)) w->data.missing.push_back(text);
    return false;
  }
  const auto smooth = [&](const std::vector<double>& series) -> Eigen::VectorXd {
    return low_pass(resample(in.time, series, out->begin, out->step, rows), out->step, w->data.cutoff);
  };
  out->q.col(joint) = smooth(position);
  out->v.col(joint) = differentiate(out->q.col(joint), out->step);
  out->a.col(joint) = differentiate(out->v.col(joint), out->step);
  const JointSpec& spec = w->e.robot.tree.joint(static_cast<int>(joint));
  if (!spec.actuated || w->data.source[j] == EffortSource::kNone || is_unlogged(*w, in, j)) return true;
  if (w->data.source[j] == EffortSource::kRecorded) {
    const ServoReading& log = w->data.servo[j];
    out->effort.col(joint) = (smooth(in.joints[j].signal[2]).array() - log.bias) / log.scale;
  } else {
    const ServoSeries servo = calc_servo(in, j, w->plant.laws[j], find_rate(in, j, *out));
    out->effort.col(joint) = smooth(servo.effort);
    out->command_rate.col(joint) = smooth(servo.command_rate);
  }
  out->effort_rate.col(joint) = differentiate(out->effort.col(joint), out->step);
  return true;
}

void add_recording(TorqueWork* w, size_t index) {
  const Recording& in = w->e.recordings[index];
  if (in.size() < 10 || in.duration() < kBlock) return;
  TorqueRecording out;
  out.index = index;
  out.train = in.spec.train;
  out.begin = in.time.front();
  out.step = std::max(1e-3, w->e.sample_time);
  const long rows = static_cast<long>(in.duration() / out.step) + 1, n = w->e.num_joints();
  out.stride = std::max(1L, std::lround(1.0 / (kPerPeriod * w->data.cutoff * out.step)));
  out.trim = std::lround(kTrim / out.step);
  for (Eigen::MatrixXd* m : {&out.q, &out.v, &out.a, &out.effort, &out.effort_rate, &out.command_rate})
    m->setZero(rows, n);
  for (long j = 0; j < n; ++j) {
    if (!fill_joint(w, in, j, rows, &out)) return;
  }
  if (w->still[index].size() == 0) w->still[index] = find_still(make_raw(*w, in, out, rows), w->noise, out.step);
  out.tau =
      w->bodies ? w->bodies(out, w->data.cutoff) : calc_efforts(add_by_hand(w->plant, in.spec), out.q, out.v, out.a);
  if (!out.tau.allFinite()) leave_out_unknown(&out);
  if (w->curved) add_filter_gap(w, in, &out);
  if (!w->data.feet.empty()) add_foot_loads(w, in, &out);
  leave_out_unlogged(*w, in, &out);
  w->data.recordings.push_back(std::move(out));
}

// Computes grids and smoothed motion at the cutoff. Returns the median over joints of the relative noise of inertia x
// acceleration.
double make_motions(TorqueWork* w) {
  w->data.recordings.clear();
  for (size_t r = 0; r < w->e.recordings.size(); ++r) add_recording(w, r);
  std::vector<double> shares;
  const double count = static_cast<double>(w->data.recordings.size());
  for (size_t j = 0; j < w->data.source.size(); ++j) {
    double acceleration = 0.0, effort = 0.0, torque = 0.0;
    for (const TorqueRecording& r : w->data.recordings) {
      const auto centre = [&](const Eigen::MatrixXd& m) {
        return (m.col(static_cast<long>(j)).array() - m.col(static_cast<long>(j)).mean()).square().mean();
      };
      acceleration += centre(r.a);
      effort += centre(r.effort);
      torque += centre(r.tau);
    }
    if (!w->data.is_judged(static_cast<int>(j)) || effort <= 0.0 || acceleration <= 0.0) continue;
    const double step = w->data.recordings[0].step;
    shares.push_back(scale_noise(w->noise[j], step, w->data.cutoff, 2) / std::sqrt(acceleration / count) *
                     std::sqrt(std::min(1.0, torque / effort)));
  }
  return find_median(std::move(shares));
}

// Noise [N m] of every joint: noise of all accelerations through the mass matrix, rms over some poses.
Eigen::VectorXd calc_torque_noise(const TorqueWork& w, const TorqueRecording& r) {
  constexpr long kPoses = 20;  // spread over the motion: a mean over them needs no more
  const long n = r.q.cols(), poses = std::min(kPoses, r.q.rows()), stride = std::max(1L, r.q.rows() / poses);
  Eigen::MatrixXd q(poses, n);
  for (long k = 0; k < poses; ++k) q.row(k) = r.q.row(k * stride);
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(poses, n), weight = calc_efforts(w.plant, q, rest, rest);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
  for (long j = 0; j < n; ++j) {
    Eigen::MatrixXd a = rest;
    a.col(j).setConstant(scale_noise(w.noise[static_cast<size_t>(j)], r.step, w.data.cutoff, 2));
    squares += (calc_efforts(w.plant, q, rest, a) - weight).array().square().colwise().mean().matrix().transpose();
  }
  return squares.cwiseSqrt();
}

// The same noise relative to the missing torque, effort - tau. With a heavy arm and coarse encoders, it may be all of
// it. Median over joints; 0 if the torques are not those of bodies on a fixed base.
double find_missing_share(const TorqueWork& w) {
  if (w.bodies || w.data.recordings.empty()) return 0.0;
  const Eigen::VectorXd noise = calc_torque_noise(w, w.data.recordings[0]);
  std::vector<double> shares;
  for (long j = 0; j < noise.size(); ++j) {
    double missing = 0.0, rows = 0.0;
    for (const TorqueRecording& r : w.data.recordings) {
      const long inner = std::max(0L, r.q.rows() - 2 * r.trim);
      const Eigen::ArrayXd x = (r.effort.col(j) - r.tau.col(j)).segment(r.trim, inner);
      missing += (x - x.mean()).square().sum();
      rows += static_cast<double>(inner);
    }
    if (w.data.is_judged(static_cast<int>(j)) && missing > 0.0) shares.push_back(noise[j] / std::sqrt(missing / rows));
  }
  return find_median(std::move(shares));
}

// [Hz] frequency below which 90 % of the velocity's energy lies; median over joints and recordings.
double find_motion_frequency(const TorqueWork& w) {
  std::vector<double> found;
  for (const TorqueRecording& r : w.data.recordings) {
    for (long j = 0; j < r.v.cols(); ++j) {
      const Eigen::VectorXd v = r.v.col(j).array() - r.v.col(j).mean();
      double f = kLowestMotion;
      while (f < w.data.cutoff && low_pass(v, r.step, f).squaredNorm() < kNearlyAll * v.squaredNorm())
        f *= kFrequencyStep;
      if (v.squaredNorm() > 0.0) found.push_back(f);
    }
  }
  return found.empty() ? w.data.cutoff : find_median(std::move(found));
}

void find_slow(TorqueWork* w) {
  for (size_t j = 0; j < w->data.source.size(); ++j) {
    double fastest = 0.0, noise = 0.0;
    for (const TorqueRecording& r : w->data.recordings) {
      fastest = std::max(fastest, r.v.col(static_cast<long>(j)).cwiseAbs().maxCoeff());
      noise = scale_noise(w->noise[j], r.step, w->data.cutoff, 1);
    }
    w->data.slow.push_back(std::max({kAboveNoise * noise, kSlowShare * fastest, kSlowest}));
  }
}

// Takes the speed from the recorded velocity, else from the position. Keeps the smoothed one if both are too noisy.
void find_speed(const TorqueWork& w, TorqueRecording* r) {
  const Recording& in = w.e.recordings[r->index];
  r->speed = r->v;
  for (long j = 0; j < r->v.cols(); ++j) {
    const size_t joint = static_cast<size_t>(j);
    const bool recorded = in.joints[joint].has(Quantity::kVelocity);
    const double sigma =
        recorded ? w.e.joint_noise[joint][static_cast<size_t>(Quantity::kVelocity)].sigma : w.noise[joint];
    for (double cutoff : kSpeedCutoffs) {
      if (cutoff <= w.data.cutoff || cutoff > 0.5 / r->step) continue;
      if (scale_noise(sigma, r->step, cutoff, recorded ? 0 : 1) > w.data.slow[joint]) continue;
      const std::vector<double>& series = recorded ? in.joints[joint].signal[static_cast<size_t>(Quantity::kVelocity)]
                                                   : find_position(w, r->index, joint);
      const Eigen::VectorXd sharp =
          low_pass(resample(in.time, series, r->begin, r->step, r->q.rows()), r->step, cutoff);
      r->speed.col(j) = recorded ? sharp : differentiate(sharp, r->step);
      break;
    }
  }
}

}  // namespace

double find_position_noise(const Experiment& e, size_t joint) {
  return std::max(e.joint_noise[joint][0].sigma, find_encoder_step(e, joint) / std::sqrt(12.0));
}

void make_torque_motions(TorqueWork* w) {
  w->data.cutoff = kFastestMotion;
  w->curved = !w->bodies;
  make_motions(w);
  w->curved = w->curved && has_filter_gap(*w);
  const double limit = std::max(kLeastLimit, kOfMotion * find_motion_frequency(*w));
  for (double cutoff : kCutoffs) {
    w->data.cutoff = cutoff;
    if (cutoff > limit) continue;
    const double noise_share = make_motions(w);
    // Noise of inertia x acceleration, of the effort's spread and of the missing torque's: above, it hides what is
    // missing.
    if (noise_share <= kDetail && find_missing_share(*w) <= kMuch) break;
  }
  for (TorqueRecording& r : w->data.recordings) {
    if (w->curved) {
      r.sharp_q = w->sharp[r.index].q;
      r.sharp_v = w->sharp[r.index].v;
      r.sharp_a = w->sharp[r.index].a;
    }
  }
}

void make_sharp_speeds(TorqueWork* w) {
  find_slow(w);
  for (TorqueRecording& r : w->data.recordings) find_speed(*w, &r);
}

}  // namespace hrp::diagnosis
