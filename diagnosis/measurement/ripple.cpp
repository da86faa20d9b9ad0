// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/ripple.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/law_rest.h"

namespace hrp::diagnosis {
namespace {

constexpr double kStep = 0.25;  // periods per step within the travel: four points on half of the main lobe
constexpr long kMostRows = 4000, kLeastRows = 50;  // of a joint: one of several is enough; fewer tell no ripple

// Samples of a joint in which a ripple may be: position, a rest of torque, and the recording they are of.
struct Samples {
  Eigen::VectorXd q, torque;
  std::vector<size_t> recording;
};

// Training samples: speed, and the residual of friction, rotor, load and a constant.
struct Rest : Samples {
  Eigen::VectorXd speed;
  double travel() const { return q.maxCoeff() - q.minCoeff(); }
};

Rest find_rest(const TorqueData& data, int joint) {
  long rows = 0;
  for (const TorqueRecording& r : data.recordings) rows += r.train ? r.use.col(joint).count() : 0;
  const long stride = std::max(1L, rows / kMostRows), n = rows / stride;
  Rest rest;
  if (n < kLeastRows) return rest;
  Eigen::MatrixXd columns(n, 6);
  rest.q.resize(n);
  rest.speed.resize(n);
  rest.torque.resize(n);
  long seen = 0, at = 0;
  for (const TorqueRecording& r : data.recordings) {
    const Eigen::VectorXd sign = data.calc_sign(r, joint);
    for (long k = 0; k < r.kept() && r.train; ++k) {
      if (!r.use(k, joint) || seen++ % stride != 0 || at == n) continue;
      const long row = r.full_row(k);
      const double v = r.v(row, joint), load = r.tau(row, joint);
      columns.row(at) << v, sign[row], r.a(row, joint), load, std::abs(load) * sign[row], 1.0;
      rest.q[at] = r.q(row, joint);
      rest.speed[at] = std::abs(v);
      rest.torque[at++] = r.missing(k, joint);
      rest.recording.push_back(r.index);
    }
  }
  rest.torque -= columns * columns.colPivHouseholderQr().solve(rest.torque).eval();
  return rest;
}

// Share of the residual that a ripple explains, and the agreement of its phase between stretches. The latter is the
// squared sum of the stretches over the sum of their squares (Rayleigh's test), from 1 by chance to kFolds.
struct Peak {
  double share = 0.0, coherence = 0.0, periods = 0.0;
};

// A ripple with wave number `periods` [1/rad]. Its frequency is that times the speed, so the filter of all signals
// (low_pass.h) leaves a share of it: half at `cutoff` [rad/s].
Peak calc_peak(const Rest& rest, double periods, double cutoff) {
  double n = 0.0, squares = 0.0;
  std::complex<double> sum = 0.0, stretch = 0.0;
  const long rows = rest.q.size();
  for (long k = 0; k < rows; ++k) {
    const double passed = 1.0 / (1.0 + std::pow(rest.speed[k] * periods / cutoff, 4));
    stretch += std::polar(passed * rest.torque[k], periods * rest.q[k]);
    n += passed * passed;
    if (k + 1 < rows && k * kFolds / rows == (k + 1) * kFolds / rows) continue;
    sum += stretch;
    squares += std::norm(stretch);
    stretch = 0.0;
  }
  if (!(n > 0.0) || !(squares > 0.0)) return {};
  return {2.0 * std::norm(sum) / n / rest.torque.squaredNorm(), std::norm(sum) / squares, periods};
}

// a and b of the ripple a cos(N q) + b sin(N q) [N m], and the share of the torque's squares that it takes.
struct Fitted {
  Eigen::Vector2d amplitude = Eigen::Vector2d::Zero();
  double share = 0.0;
};

// By least squares, beside a constant of each recording: a joint that rests shows no ripple, only what its encoder's
// rounding makes of the servo's law there.
Fitted fit_ripple(const Samples& s, double periods) {
  const long rows = s.q.size();
  Eigen::MatrixXd columns(rows, 3);
  columns << (periods * s.q.array()).cos(), (periods * s.q.array()).sin(), s.torque;
  for (long begin = 0, end = 0; begin < rows; begin = end) {
    while (end < rows && s.recording[static_cast<size_t>(end)] == s.recording[static_cast<size_t>(begin)]) ++end;
    auto own = columns.middleRows(begin, end - begin);
    own.rowwise() -= own.colwise().mean().eval();
  }
  const Eigen::Matrix3d sums = columns.transpose() * columns;
  const Eigen::Vector2d x =
      sums.topLeftCorner<2, 2>().completeOrthogonalDecomposition().solve(sums.topRightCorner<2, 1>());
  return {x, x.dot(sums.topRightCorner<2, 1>()) / std::max(1e-300, sums(2, 2))};
}

// One of `stride` samples of the log.
Samples take_samples(const LawRest& log, size_t stride) {
  const size_t rows = (log.position.size() + stride - 1) / stride;
  Samples out{Eigen::VectorXd(static_cast<long>(rows)), Eigen::VectorXd(static_cast<long>(rows)), {}};
  for (size_t k = 0; k < rows; ++k) {
    out.q[static_cast<long>(k)] = log.position[k * stride];
    out.torque[static_cast<long>(k)] = log.torque[k * stride];
    out.recording.push_back(log.recording[k * stride]);
  }
  return out;
}

// Wave numbers [1/rad] that may be tried: from `first` to `last`.
struct Tried {
  double first = 0.0, last = 0.0, step = 0.0;
};

Tried find_tried(const TorqueData& data, const Rest& rest) {
  if (rest.q.size() == 0 || !(rest.travel() > 0.0)) return {};
  const double cutoff = 2.0 * M_PI * data.cutoff, period = 2.0 * M_PI / rest.travel();
  // In much of the samples the fastest ripple is slow enough to pass the filter.
  // Clearly more than one period is within the travel.
  return {kClearlyMore * period, cutoff / std::max(1e-9, find_quantile({rest.speed.begin(), rest.speed.end()}, kMuch)),
          kStep * period};
}

}  // namespace

std::vector<double> find_ripples(const TorqueData& data, int joint) {
  const Rest rest = find_rest(data, joint);
  const Tried range = find_tried(data, rest);
  std::vector<Peak> tried;
  for (double periods = range.first; periods < range.last; periods += range.step)
    tried.push_back(calc_peak(rest, periods, 2.0 * M_PI * data.cutoff));
  std::vector<Peak> peaks;
  // Coherence of stretches: chance exceeds a with e^-a, for each period that is tried. Full agreement has 16.
  const double agree = std::log(static_cast<double>(tried.size()) / (1.0 - kSurest));
  for (size_t i = 1; i + 1 < tried.size(); ++i) {
    const double before = tried[i - 1].share, here = tried[i].share, after = tried[i + 1].share;
    // Share of what friction, rotor and load leave; a repeated motion explains less.
    if (here < kPart || here < before || here <= after || tried[i].coherence < agree) continue;
    peaks.push_back(tried[i]);
    peaks.back().periods += range.step * calc_vertex(before, here, after);
  }
  std::sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.share > b.share; });
  std::vector<double> found;
  for (size_t i = 0; i < std::min(peaks.size(), kLookedAt); ++i) found.push_back(peaks[i].periods);
  return found;
}

std::optional<LogRipple> find_log_ripple(const TorqueData& data, int joint) {
  const LawRest log = list_law_rest(*data.experiment, joint, data.delays);
  const long rows = static_cast<long>(log.position.size());
  if (rows < kLeastRows) return std::nullopt;
  const Samples all = take_samples(log, 1),
                thin = take_samples(log, static_cast<size_t>(std::max(1L, rows / kMostRows)));
  const Rest rest = find_rest(data, joint);
  const Tried range = find_tried(data, rest);
  Fitted best;
  double periods = 0.0;
  for (double tried = range.first; tried < range.last; tried += range.step) {
    const Fitted fitted = fit_ripple(thin, tried);
    if (fitted.share > best.share) {
      best = fitted;
      periods = tried;
    }
  }
  if (best.share < kPart) return std::nullopt;
  LogRipple ripple{periods, fit_ripple(all, periods).amplitude, 0.0};
  const Eigen::Vector2d missing = fit_ripple(rest, periods).amplitude;
  const Eigen::VectorXd part = ripple.calc(all.q);
  ripple.mean = part.mean();
  const bool same = (missing - ripple.amplitude).norm() < kHalf * missing.norm();
  return same && log.follows_but_for(part.array() - ripple.mean) ? std::optional<LogRipple>(ripple) : std::nullopt;
}

}  // namespace hrp::diagnosis
