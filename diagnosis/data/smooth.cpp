// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/smooth.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

// Samples around the k-th, with time scaled to [-1, 1].
struct Window {
  Window(const std::vector<double>& all, size_t k, size_t reach)
      : begin(k >= reach ? k - reach : 0),
        end(std::min(all.size(), k + reach + 1)),
        time(all),
        center(all[k]),
        scale(std::max(1e-9, 0.5 * (all[end - 1] - all[begin]))) {}
  double find_place(size_t i) const { return (time[i] - center) / scale; }

  size_t begin, end;
  const std::vector<double>& time;
  double center, scale;
};

Eigen::Vector4d make_cubic(double s) { return {1.0, s, s * s, s * s * s}; }

// Keeps the matrix regular with few samples, or with all at one time.
void regularise(Eigen::Matrix4d* N) { N->diagonal().array() += 1e-12 * N->trace(); }

struct Source {
  const std::vector<double>* values;
  double weight;  // 1 / sigma
  int order;      // 0: values, 1: first derivative
};

struct LocalFit {
  Eigen::Vector4d c = Eigen::Vector4d::Zero();  // value, rate, acceleration / 2, third / 6, in scaled time
  double chi2 = 0.0;
  int count = 0;
  double second_variance = 0.0;
};

LocalFit fit_local(const std::vector<double>& time, const std::vector<Source>& sources, size_t k, int half,
                   bool want_chi) {
  const Window window(time, k, static_cast<size_t>(half));
  const double scale = window.scale;
  Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  LocalFit fit;
  for (size_t i = window.begin; i < window.end; ++i) {
    const double s = window.find_place(i);
    for (const Source& source : sources) {
      const double y = (*source.values)[i];
      if (!std::isfinite(y)) continue;
      Eigen::Vector4d row = make_cubic(s);
      if (source.order > 0) row << 0.0, 1.0 / scale, 2.0 * s / scale, 3.0 * s * s / scale;
      N.noalias() += source.weight * source.weight * row * row.transpose();
      b += source.weight * source.weight * y * row;
      ++fit.count;
    }
  }
  regularise(&N);
  const Eigen::LDLT<Eigen::Matrix4d> factor(N);
  fit.c = factor.solve(b);
  if (want_chi) {
    for (size_t i = window.begin; i < window.end; ++i) {
      const double s = window.find_place(i);
      for (const Source& source : sources) {
        const double y = (*source.values)[i];
        if (!std::isfinite(y)) continue;
        const double f = source.order == 0 ? fit.c[0] + s * (fit.c[1] + s * (fit.c[2] + s * fit.c[3]))
                                           : (fit.c[1] + s * (2.0 * fit.c[2] + 3.0 * s * fit.c[3])) / scale;
        fit.chi2 += source.weight * source.weight * (y - f) * (y - f);
      }
    }
    fit.second_variance = 4.0 * factor.solve(Eigen::Vector4d::Unit(2))[2] / std::pow(scale, 4);
  }
  fit.c[1] /= scale;
  fit.c[2] /= scale * scale;
  return fit;
}

// Widest window whose cubics fit the samples about as well as the narrowest window.
int choose_window(const std::vector<double>& time, const std::vector<Source>& sources, double* second_sigma) {
  const int windows[] = {3, 4, 6, 8, 11, 15, 20};
  double first = 0.0;
  int chosen = windows[0];
  for (int half : windows) {
    if (4 * static_cast<size_t>(half) > time.size()) break;
    double chi2 = 0.0, dof = 0.0, variance = 0.0, n = 0.0;
    for (size_t k = static_cast<size_t>(half); k + static_cast<size_t>(half) < time.size(); k += 7) {
      const LocalFit fit = fit_local(time, sources, k, half, true);
      chi2 += fit.chi2;
      dof += std::max(0, fit.count - 4);
      variance += fit.second_variance;
      n += 1.0;
    }
    const double ratio = dof > 0.0 ? chi2 / dof : 0.0;
    if (half == windows[0]) first = std::max(ratio, 1e-12);
    if (half != windows[0] && ratio > 1.25 * std::max(first, 0.8)) break;
    chosen = half;
    *second_sigma = n > 0.0 ? std::sqrt(variance / n * std::max(ratio, 1e-3)) : 0.0;
  }
  return chosen;
}

}  // namespace

void smooth_series(const std::vector<double>& time, const std::vector<double>& values, int half_window,
                   std::vector<double>* value, std::vector<double>* rate, std::vector<double>* second) {
  const std::vector<Source> sources{{&values, 1.0, 0}};
  for (std::vector<double>* out : {value, rate, second}) {
    if (out) out->resize(time.size());
  }
  for (size_t k = 0; k < time.size(); ++k) {
    const LocalFit fit = fit_local(time, sources, k, half_window, false);
    if (value) (*value)[k] = fit.c[0];
    if (rate) (*rate)[k] = fit.c[1];
    if (second) (*second)[k] = 2.0 * fit.c[2];
  }
}

std::vector<double> fill_gaps(const std::vector<double>& values) {
  const auto first = std::find_if(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  double last = first == values.end() ? 0.0 : *first;
  std::vector<double> out = values;
  for (double& v : out) last = v = std::isfinite(v) ? v : last;
  return out;
}

Smoother::Smoother(const std::vector<double>& time, int half, Parity parity) : kernels_(time.size()), half_(half) {
  // Every second sample: a window twice as wide in samples has the same duration, and always enough samples for a
  // cubic.
  const auto reach = static_cast<size_t>(parity == Parity::kAll ? half : std::max(half, 6));
  for (size_t k = 0; k < time.size(); ++k) {
    const Window window(time, k, reach);
    Kernel& kernel = kernels_[k];
    kernel.begin = window.begin;
    Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
    std::vector<Eigen::Vector4d> rows;
    for (size_t i = window.begin; i < window.end; ++i) {
      const bool seen = parity == Parity::kAll || (i % 2 == 0) == (parity == Parity::kEven);
      const Eigen::Vector4d row = seen ? make_cubic(window.find_place(i)) : Eigen::Vector4d::Zero();
      N.noalias() += row * row.transpose();
      rows.push_back(row);
    }
    regularise(&N);
    const Eigen::Matrix4d inverse = N.inverse();
    for (const Eigen::Vector4d& row : rows) {
      const Eigen::Vector4d c = inverse * row;
      kernel.value.push_back(c[0]);
      kernel.rate.push_back(c[1] / window.scale);
      kernel.second.push_back(2 * c[2] / (window.scale * window.scale));
    }
  }
}

SmoothSeries Smoother::run(const std::vector<double>& values) const {
  SmoothSeries out;
  for (const Kernel& kernel : kernels_) {
    double value = 0, rate = 0, second = 0;
    for (size_t i = 0; i < kernel.value.size(); ++i) {
      const double y = values[kernel.begin + i];
      value += kernel.value[i] * y;
      rate += kernel.rate[i] * y;
      second += kernel.second[i] * y;
    }
    out.value.push_back(value);
    out.rate.push_back(rate);
    out.second.push_back(second);
  }
  return out;
}

SmoothRecording smooth_recording(const Experiment& e, const Recording& recording) {
  SmoothRecording smooth;
  const size_t rows = recording.size();
  smooth.joints.resize(recording.joints.size());
  smooth.effort.resize(recording.joints.size());
  for (size_t j = 0; j < recording.joints.size(); ++j) {
    const JointColumns& columns = recording.joints[j];
    SmoothJoint& out = smooth.joints[j];
    out.q.assign(rows, 0.0);
    out.qd.assign(rows, 0.0);
    out.qdd.assign(rows, 0.0);
    std::vector<Source> sources;
    if (columns.has(Quantity::kPosition)) sources.push_back({&columns.signal[0], 1.0 / e.joint_noise[j][0].sigma, 0});
    if (columns.has(Quantity::kVelocity) && !sources.empty())
      sources.push_back({&columns.signal[1], 1.0 / e.joint_noise[j][1].sigma, 1});
    if (!sources.empty()) {
      out.half_window = choose_window(recording.time, sources, &out.sigma_qdd);
      for (size_t k = 0; k < rows; ++k) {
        const LocalFit fit = fit_local(recording.time, sources, k, out.half_window, false);
        out.q[k] = fit.c[0];
        out.qd[k] = fit.c[1];
        out.qdd[k] = 2.0 * fit.c[2];
      }
    }
    if (columns.has(Quantity::kEffort)) {
      smooth_series(recording.time, columns.signal[2], std::max(3, out.half_window), &smooth.effort[j], nullptr,
                    nullptr);
    }
  }
  for (const SmoothJoint& joint : smooth.joints)
    smooth.start = std::max(smooth.start, static_cast<size_t>(joint.half_window));
  smooth.start = std::min(smooth.start, rows / 4);
  const double settled = recording.time[smooth.start] + std::min(kSettling, 0.1 * recording.duration());
  const auto judged = std::lower_bound(recording.time.begin(), recording.time.end(), settled);
  smooth.judged = static_cast<size_t>(judged - recording.time.begin());
  return smooth;
}

}  // namespace hrp::diagnosis
