// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/dependence.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/search/signature.h"

namespace hrp::diagnosis {
namespace {

constexpr int kBins = 16;

struct Sample {
  double y = 0.0;
  double x[6] = {0, 0, 0, 0, 0, 0};  // position, velocity, direction, load, time, history
};

const char* const kNames[] = {"position", "velocity", "direction", "load", "time", "history"};

// Over so long [s], missing efforts are averaged: accelerations carry the noise of two derivatives, which would hide
// what the rest follows; what changes faster than that is no function of slow quantities anyway.
constexpr double kAverage = 0.05;

std::vector<double> average(const MissingEffort& m, int j) {
  std::vector<double> out(m.time.size(), 0.0);
  size_t from = 0, to = 0;
  double sum = 0.0;
  for (size_t k = 0; k < m.time.size(); ++k) {
    while (to < m.time.size() && m.time[to] <= m.time[k] + 0.5 * kAverage) sum += m.missing(static_cast<long>(to++), j);
    while (m.time[from] < m.time[k] - 0.5 * kAverage) sum -= m.missing(static_cast<long>(from++), j);
    out[k] = sum / static_cast<double>(to - from);
  }
  return out;
}

std::vector<Sample> collect(const MissingEffort& m, int j) {
  std::vector<Sample> list;
  const std::vector<double> missing = average(m, j);
  double swing = 0.0;
  for (long k = 0; k < m.q.rows(); ++k) {
    Sample s;
    s.y = missing[static_cast<size_t>(k)];
    if (k > 0) swing = 0.97 * swing + m.q(k, j) - m.q(k - 1, j);
    const double v = m.qd(k, j);
    const double values[] = {
        m.q(k, j), v, v > 0.01 ? 1.0 : v < -0.01 ? -1.0 : 0.0, m.u(k, j), m.time[static_cast<size_t>(k)], swing};
    std::copy(values, values + 6, s.x);
    list.push_back(s);
  }
  return list;
}

// Share of the held-out variance that a free function of quantity f explains.
double judge(const std::vector<Sample>& train, const std::vector<Sample>& test, int f) {
  std::vector<double> sorted;
  for (const Sample& s : train) sorted.push_back(s.x[f]);
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> edges;
  for (int b = 1; b < kBins; ++b) edges.push_back(sorted[sorted.size() * static_cast<size_t>(b) / kBins]);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const auto find_bin = [&](double x) {
    return static_cast<size_t>(std::upper_bound(edges.begin(), edges.end(), x) - edges.begin());
  };
  std::vector<double> sum(edges.size() + 1, 0.0), count(edges.size() + 1, 0.0);
  double mean = 0.0;
  for (const Sample& s : train)
    sum[find_bin(s.x[f])] += s.y, count[find_bin(s.x[f])] += 1.0, mean += s.y / static_cast<double>(train.size());
  double left = 0.0, total = 0.0;
  for (const Sample& s : test) {
    const size_t bin = find_bin(s.x[f]);
    const double guess = count[bin] > 0.0 ? sum[bin] / count[bin] : mean;
    left += (s.y - guess) * (s.y - guess), total += (s.y - mean) * (s.y - mean);
  }
  return total > 0.0 ? 1.0 - left / total : 0.0;
}

// Joints whose readings are missed by a tenth or more of what the worst is missed by, as sums of squares beyond noise.
std::vector<int> list_missed(const Score& left) {
  std::vector<double> beyond(left.signal_chi2.size() / kQuantities, 0.0);
  for (size_t c = 0; c < left.signal_chi2.size(); ++c)
    beyond[c / kQuantities] += std::max(0.0, left.signal_chi2[c] - left.signal_count[c]);
  std::vector<int> joints;
  for (size_t j = 0; j < beyond.size(); ++j) {
    if (beyond[j] >= 0.1 * *std::max_element(beyond.begin(), beyond.end())) joints.push_back(static_cast<int>(j));
  }
  return joints;
}

}  // namespace

std::vector<Dependence> find_dependence(const Problem& problem, const Hypothesis& base, const Score& left) {
  std::vector<MissingEffort> train, test;
  for (int r : problem.train) train.push_back(calc_missing_effort(problem, base, r));
  for (int r : problem.validate.empty() ? problem.train : problem.validate)
    test.push_back(calc_missing_effort(problem, base, r));
  std::vector<std::pair<double, int>> order;
  for (int j : list_missed(left)) {
    double sum = 0.0, count = 0.0;
    for (const MissingEffort& m : train)
      sum += (m.missing.col(j) / m.sigma[static_cast<size_t>(j)]).squaredNorm(),
          count += static_cast<double>(m.missing.rows());
    order.push_back({-sum / std::max(1.0, count), j});
  }
  std::sort(order.begin(), order.end());
  std::vector<Dependence> list;
  for (const auto& item : order) {
    if (list.size() >= 3 || -item.first < 4.0 || item.first > 0.1 * order.front().first) break;
    Dependence d;
    d.joint = item.second;
    std::vector<Sample> a, b;
    for (const MissingEffort& m : train)
      for (const Sample& s : collect(m, d.joint)) a.push_back(s);
    for (const MissingEffort& m : test)
      for (const Sample& s : collect(m, d.joint)) b.push_back(s);
    for (const Sample& s : a) d.effort += s.y * s.y / static_cast<double>(a.size());
    d.effort = std::sqrt(d.effort);
    std::vector<std::pair<double, int>> scores;
    for (int f = 0; f < 6; ++f) scores.push_back({-judge(a, b, f), f});
    std::sort(scores.begin(), scores.end());
    for (const auto& s : scores) {
      if (-s.first > 0.12 && -s.first > 0.45 * -scores.front().first) d.depends_on.push_back(kNames[s.second]);
    }
    list.push_back(d);
  }
  return list;
}

}  // namespace hrp::diagnosis
