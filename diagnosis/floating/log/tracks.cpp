// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/log/tracks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis::floating {
namespace {

std::vector<double> make_kernel(double step, double sigma) {
  std::vector<double> kernel;
  if (sigma <= 0) return {1.0};
  const auto reach = static_cast<int>(std::ceil(4 * sigma / step));
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    kernel.push_back(std::exp(-0.5 * std::pow(i * step / sigma, 2)));
    sum += kernel.back();
  }
  for (double& k : kernel) k /= sum;
  return kernel;
}

// The ends are held.
std::vector<double> convolve(const std::vector<double>& kernel, const std::vector<double>& raw) {
  const auto n = static_cast<long>(raw.size()), half = static_cast<long>(kernel.size() / 2);
  std::vector<double> out(raw.size());
  for (long i = 0; i < n; ++i) {
    double sum = 0;
    for (long k = -half; k <= half; ++k) {
      sum += kernel[static_cast<size_t>(k + half)] * raw[static_cast<size_t>(std::clamp(i + k, 0L, n - 1))];
    }
    out[static_cast<size_t>(i)] = sum;
  }
  return out;
}

}  // namespace

Vector3d get_values(const Track* xyz, size_t k) {
  Vector3d v = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) v(i) = xyz[i].empty() ? 0.0 : xyz[i].value[k];
  return v;
}

Vector3d get_rates(const Track* xyz, size_t k) {
  Vector3d v = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) v(i) = xyz[i].empty() ? 0.0 : xyz[i].rate[k];
  return v;
}

Eigen::Quaterniond get_quaternion(const Track* wxyz, size_t k) {
  return Eigen::Quaterniond(wxyz[0].value[k], wxyz[1].value[k], wxyz[2].value[k], wxyz[3].value[k]).normalized();
}

std::vector<double> smooth_evenly(const std::vector<double>& raw, double step, double sigma) {
  return convolve(make_kernel(step, sigma), raw);
}

std::vector<char> find_new_samples(const std::vector<const std::vector<double>*>& columns) {
  const size_t size = columns.empty() ? 0 : columns[0]->size();
  std::vector<char> fresh(size, 0);
  for (size_t k = 0; k < size; ++k) {
    for (const std::vector<double>* c : columns) {
      const double v = (*c)[k];
      fresh[k] |= std::isfinite(v) && (k == 0 || v != (*c)[k - 1]);
    }
  }
  return fresh;
}

namespace {

// Samples from one change of a sensor's reading to the next, and the reading.
struct Run {
  size_t begin = 0, end = 0;
  std::vector<double> reading;
};

std::vector<Run> list_runs(const std::vector<const std::vector<double>*>& columns, const std::vector<char>& fresh) {
  std::vector<Run> runs;
  for (size_t k = 0; k < fresh.size(); ++k) {
    if (!fresh[k]) continue;
    if (!runs.empty()) runs.back().end = k;
    runs.push_back({k, fresh.size(), {}});
    for (const std::vector<double>* c : columns) runs.back().reading.push_back((*c)[k]);
  }
  return runs;
}

}  // namespace

std::vector<char> find_readings(const std::vector<const std::vector<double>*>& columns,
                                const std::vector<char>& fresh) {
  const std::vector<Run> runs = list_runs(columns, fresh);
  std::map<std::vector<double>, int> count;
  std::vector<double> lengths, before;
  for (const Run& run : runs) {
    const bool whole = std::all_of(run.reading.begin(), run.reading.end(), [](double v) { return std::isfinite(v); });
    if (!whole || run.reading == before) continue;  // a blank within a held reading begins no other one
    ++count[run.reading];
    lengths.push_back(static_cast<double>(run.end - run.begin));
    before = run.reading;
  }
  std::vector<char> out = fresh;
  if (lengths.empty()) return out;
  // The quickest changes are the sensor's period.
  const auto period = static_cast<size_t>(std::max(1.0, std::round(find_quantile(lengths, kMinor))));
  for (const Run& run : runs) {
    const auto at = count.find(run.reading);
    if (at == count.end() || at->second < 2) continue;
    for (size_t k = run.begin; k < run.end; k += period) out[k] = 1;
  }
  return out;
}

std::vector<Span> find_spans(const std::vector<double>& time, const std::vector<char>& fresh, double longest,
                             std::vector<Gap>* gaps) {
  std::vector<Span> spans;
  size_t begin = 0, last = 0;  // of the span; the last fresh sample
  for (size_t k = 1; k < time.size(); ++k) {
    if (!fresh.empty() && !fresh[k]) continue;
    if (time[k] - time[last] > longest) {
      gaps->push_back({time[last], time[k]});
      spans.push_back({begin, last + 1});
      begin = k;
    }
    last = k;
  }
  spans.push_back({begin, last + 1});
  return spans;
}

Resampler::Resampler(const std::vector<double>& time, Span span, double step, double sigma, Half half)
    : time_(time), span_(span), step_(step), half_(half) {
  const double begin = time[span.begin], end = time[span.end - 1];
  for (size_t i = 0; begin + static_cast<double>(i) * step <= end + 1e-9; ++i) {
    grid_.push_back(begin + static_cast<double>(i) * step);
  }
  kernel_ = make_kernel(step, sigma);
}

std::vector<double> Resampler::interpolate_samples(const std::vector<double>& values,
                                                   const std::vector<char>& fresh) const {
  // Fresh samples are told apart by their own count: every second of what was held would be all or none of them.
  std::vector<size_t> good;
  const size_t every = half_ == Half::kAll ? 1 : 2, first = half_ == Half::kOdd ? 1 : 0;
  size_t count = 0;
  for (size_t k = span_.begin; k < span_.end; ++k) {
    const bool edge = k == span_.begin || k + 1 == span_.end;
    const bool is_new = std::isfinite(values[k]) && (fresh.empty() || fresh[k] || edge);
    if (is_new && (count++ % every == first || edge)) good.push_back(k);
  }
  std::vector<double> out(grid_.size(), 0.0);
  if (good.empty()) return out;
  size_t at = 0;
  for (size_t i = 0; i < grid_.size(); ++i) {
    while (at + 1 < good.size() && time_[good[at + 1]] <= grid_[i]) ++at;
    const size_t a = good[at], b = good[std::min(at + 1, good.size() - 1)];
    const double share = b > a ? std::clamp((grid_[i] - time_[a]) / (time_[b] - time_[a]), 0.0, 1.0) : 0.0;
    out[i] = values[a] + share * (values[b] - values[a]);
  }
  return out;
}

Track Resampler::run(const std::vector<double>& values, const std::vector<char>& fresh) const {
  const std::vector<double> raw = interpolate_samples(values, fresh);
  Track out;
  out.value = convolve(kernel_, raw);
  out.rate.resize(raw.size());
  out.second.resize(raw.size());
  for (size_t i = 0; i < raw.size(); ++i) {
    const size_t a = i > 0 ? i - 1 : 0, b = std::min(i + 1, raw.size() - 1);
    if (b == a) continue;
    out.rate[i] = (out.value[b] - out.value[a]) / (static_cast<double>(b - a) * step_);
    if (b == a + 2) out.second[i] = (out.value[b] - 2 * out.value[i] + out.value[a]) / (step_ * step_);
  }
  return out;
}

std::vector<double> Resampler::calc_roughness(const std::vector<double>& values, const Track& smooth) const {
  const std::vector<double> raw = interpolate_samples(values, {});
  const auto n = static_cast<long>(raw.size()), half = static_cast<long>(kernel_.size() / 2);
  std::vector<double> out(raw.size());
  for (long i = 0; i < n; ++i) {
    double sum = 0;
    for (long k = -half; k <= half; ++k) {
      const auto at = static_cast<size_t>(std::clamp(i + k, 0L, n - 1));
      sum += kernel_[static_cast<size_t>(k + half)] * std::pow(raw[at] - smooth.value[at], 2);
    }
    out[static_cast<size_t>(i)] = std::sqrt(sum);
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
