// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/noise.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/range.h"

namespace hrp::diagnosis {
namespace {

// Step of a quantised signal: the smallest change if most changes are integer multiples of it; else 0.
double find_step(const std::vector<double>& signal) {
  std::vector<double> changes;
  double largest = 0.0;
  for (size_t k = 1; k < signal.size(); ++k) {
    const double d = std::abs(signal[k] - signal[k - 1]);
    if (std::isfinite(d)) largest = std::max(largest, std::abs(signal[k]));
    if (std::isfinite(d) && d > 0.0) changes.push_back(d);
  }
  if (changes.size() < 8) return 0.0;
  std::sort(changes.begin(), changes.end());
  const double step = changes[changes.size() / 50];
  if (step < 1e-5 * largest) return 0.0;  // the resolution of the file's digits
  size_t whole = 0;
  for (double d : changes) {
    const double ratio = d / step;
    whole += std::abs(ratio - std::round(ratio)) < 0.05 * std::max(1.0, 0.02 * ratio) ? 1 : 0;
  }
  return whole * 10 > changes.size() * 8 ? step : 0.0;
}

}  // namespace

double estimate_noise(const std::vector<double>& signal) {
  std::vector<double> third;
  size_t zeros = 0;
  for (size_t k = 3; k < signal.size(); ++k) {
    const double d = signal[k] - 3.0 * signal[k - 1] + 3.0 * signal[k - 2] - signal[k - 3];
    if (!std::isfinite(d)) continue;
    if (d == 0.0) ++zeros;
    third.push_back(std::abs(d));
  }
  if (third.size() < 8) return 0.0;
  double value = find_median(third);
  if (zeros * 4 > third.size()) {  // quantised or held: the median is useless, the mean square is not
    double sum = 0.0;
    for (double d : third) sum += d * d;
    value = 0.6745 * std::sqrt(sum / static_cast<double>(third.size()));
  }
  // A quantised reading is not better than its step.
  // 1 + 9 + 9 + 1: variance of the third difference of white noise
  return std::max(find_step(signal) / std::sqrt(12.0), value / (0.6745 * std::sqrt(20.0)));
}

namespace {

double get_stated(const Experiment& e, const std::string& signal, const std::string& quantity) {
  for (const std::string& key : {signal, quantity}) {
    const auto it = e.keys.noise.find(key);
    if (it != e.keys.noise.end()) return it->second;
  }
  return 0.0;
}

void find_signal_noise(Experiment* e) {
  e->joint_noise.assign(static_cast<size_t>(e->num_joints()), std::vector<Noise>(kQuantities));
  for (int j = 0; j < e->num_joints(); ++j) {
    for (int q = 0; q < kQuantities; ++q) {
      Noise& noise = e->joint_noise[static_cast<size_t>(j)][static_cast<size_t>(q)];
      noise.sigma =
          get_stated(*e, e->signal_name(j, static_cast<Quantity>(q)), get_quantity_name(static_cast<Quantity>(q)));
      noise.stated = noise.sigma > 0.0;
      if (noise.stated) continue;
      std::vector<double> found;
      for (const Recording& r : e->recordings) {
        const auto& column = r.joints[static_cast<size_t>(j)].signal[q];
        if (!column.empty()) found.push_back(estimate_noise(column));
      }
      noise.sigma = find_median(found);
    }
  }
  for (const Recording& r : e->recordings) {
    for (const auto& item : r.other) {
      Noise& noise = e->other_noise[item.first];
      if (noise.sigma > 0.0) continue;
      const size_t cut = item.first.rfind('/');
      noise.sigma = get_stated(*e, item.first.substr(0, cut), "");
      noise.stated = noise.sigma > 0.0;
      if (!noise.stated) noise.sigma = estimate_noise(item.second);
    }
  }
}

// A signal that varies by rounding only has no measurable noise. It gets the median of the other joints, to avoid a
// division by zero.
void floor_noise(Experiment* e) {
  for (int q = 0; q < kQuantities; ++q) {
    std::vector<double> others;
    for (auto& joint : e->joint_noise) {
      if (joint[static_cast<size_t>(q)].sigma > 0.0) others.push_back(joint[static_cast<size_t>(q)].sigma);
    }
    const double middle = find_median(others);
    for (auto& joint : e->joint_noise) {
      double& sigma = joint[static_cast<size_t>(q)].sigma;
      if (sigma < 1e-3 * middle || sigma <= 0.0) sigma = middle > 0.0 ? middle : 1e-6;
    }
  }
  for (auto& item : e->other_noise) {
    if (item.second.sigma <= 0.0) item.second.sigma = 1e-9;
  }
}

double calc_largest_change(const Experiment& e, size_t j, size_t q) {
  double largest = 0.0;
  for (const Recording& r : e.recordings) largest = std::max(largest, calc_range(r.joints[j].signal[q]));
  return largest;
}

// Warns if the stated noise exceeds all changes of a signal.
void warn_of_large_noise(Experiment* e) {
  for (size_t j = 0; j < e->joint_noise.size(); ++j) {
    for (size_t q = 0; q < kQuantities; ++q) {
      const Noise& noise = e->joint_noise[j][q];
      const double change = calc_largest_change(*e, j, q);
      if (!noise.stated || change <= 0.0 || noise.sigma < change) continue;
      e->warnings.push_back(e->signal_name(static_cast<int>(j), static_cast<Quantity>(q)) + ": the stated noise of " +
                            number(noise.sigma, 3) + " is more than all its changes, " + number(change, 3) +
                            ": it shows nothing");
    }
  }
}

// Warns of names in 'noise:' that no recording has.
void warn_of_strange_noise(Experiment* e) {
  for (const auto& [key, sigma] : e->keys.noise) {
    bool known = key[0] != '/' || e->other_noise.count(key) > 0;
    for (const auto& [column, noise] : e->other_noise) known = known || column.rfind(key + "/", 0) == 0;
    for (int j = 0; j < e->num_joints(); ++j) {
      for (int q = 0; q < kQuantities; ++q) known = known || key == e->signal_name(j, static_cast<Quantity>(q));
    }
    if (!known) e->warnings.push_back("noise." + key + ": no recording has such a column or sensor");
  }
}

}  // namespace

double find_encoder_step(const Experiment& e, size_t joint) {
  double quantum = 0.0;
  for (const Recording& r : e.recordings) {
    std::vector<double> steps;
    const std::vector<double>& q = r.joints[joint].signal[0];
    for (size_t k = 1; k < q.size(); ++k) {
      const double d = std::abs(q[k] - q[k - 1]);
      if (std::isfinite(d) && d > 1e-9) steps.push_back(d);
    }
    if (steps.size() < 10) continue;
    std::nth_element(steps.begin(), steps.begin() + static_cast<long>(steps.size() / 10), steps.end());
    const double low = steps[steps.size() / 10];
    quantum = quantum == 0.0 ? low : std::min(quantum, low);
  }
  return quantum;
}

void find_noise(Experiment* experiment) {
  find_signal_noise(experiment);
  warn_of_large_noise(experiment);
  warn_of_strange_noise(experiment);
  floor_noise(experiment);
}

}  // namespace hrp::diagnosis
