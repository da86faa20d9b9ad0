// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/low_pass.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

// Bilinear transform of 1 / (s^2 + sqrt(2) s + 1) (Oppenheim and Schafer, Discrete-Time Signal Processing, 7.1.2).
struct Biquad {
  double b0, b1, b2, a1, a2;
};

Biquad make_butterworth(double step, double cutoff) {
  const double k = std::tan(M_PI * cutoff * step), norm = 1.0 / (1.0 + M_SQRT2 * k + k * k);
  return {k * k * norm, 2.0 * k * k * norm, k * k * norm, 2.0 * (k * k - 1.0) * norm,
          (1.0 - M_SQRT2 * k + k * k) * norm};
}

// Transposed direct form II, started in the steady state of the first value.
void run_filter(const Biquad& f, Eigen::VectorXd* x) {
  double s2 = (f.b2 - f.a2) * (*x)[0], s1 = (f.b1 - f.a1) * (*x)[0] + s2;
  for (double& value : *x) {
    const double in = value, out = f.b0 * in + s1;
    s1 = f.b1 * in - f.a1 * out + s2;
    s2 = f.b2 * in - f.a2 * out;
    value = out;
  }
}

}  // namespace

Eigen::VectorXd resample(const std::vector<double>& time, const std::vector<double>& values, double begin, double step,
                         long count) {
  std::vector<size_t> known;
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) known.push_back(i);
  }
  Eigen::VectorXd out = Eigen::VectorXd::Zero(count);
  if (known.empty()) return out;
  size_t at = 0;
  for (long k = 0; k < count; ++k) {
    const double t = begin + step * static_cast<double>(k);
    while (at + 2 < known.size() && time[known[at + 1]] < t) ++at;
    const size_t i = known[at], next = known[std::min(at + 1, known.size() - 1)];
    const double span = time[next] - time[i];
    const double s = span > 0.0 ? std::clamp((t - time[i]) / span, 0.0, 1.0) : 0.0;
    out[k] = values[i] + s * (values[next] - values[i]);
  }
  return out;
}

Eigen::VectorXd low_pass(const Eigen::VectorXd& series, double step, double cutoff) {
  const long n = series.size();
  if (n < 3 || cutoff * step > 0.4) return series;
  const long pad = std::min(n - 1, static_cast<long>(std::ceil(2.0 / (cutoff * step))));
  Eigen::VectorXd x(n + 2 * pad);
  for (long i = 0; i < pad; ++i) {
    x[i] = 2.0 * series[0] - series[pad - i];
    x[pad + n + i] = 2.0 * series[n - 1] - series[n - 2 - i];
  }
  x.segment(pad, n) = series;
  const Biquad filter = make_butterworth(step, cutoff);
  for (int pass = 0; pass < 2; ++pass) {
    run_filter(filter, &x);
    x.reverseInPlace();
  }
  return x.segment(pad, n);
}

Eigen::VectorXd differentiate(const Eigen::VectorXd& series, double step) {
  const long n = series.size();
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(n);
  for (long k = 0; k < n && n > 1; ++k) {
    const long a = std::max(0L, k - 1), b = std::min(n - 1, k + 1);
    rate[k] = (series[b] - series[a]) / (step * static_cast<double>(b - a));
  }
  return rate;
}

}  // namespace hrp::diagnosis
