// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/dependence.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/missing.h"

namespace hrp::diagnosis {
namespace {

// Missing efforts, averaged over a moment. Accelerations contain the noise of two derivatives, which would hide a
// relation. Anything faster is no function of slow quantities.
std::vector<double> average(const MissingEffort& m, int j) {
  std::vector<double> out(m.time.size(), 0.0);
  size_t from = 0, to = 0;
  double sum = 0.0;
  for (size_t k = 0; k < m.time.size(); ++k) {
    while (to < m.time.size() && m.time[to] <= m.time[k] + 0.5 * kMoment) sum += m.missing(static_cast<long>(to++), j);
    while (m.time[from] < m.time[k] - 0.5 * kMoment) sum -= m.missing(static_cast<long>(from++), j);
    out[k] = sum / static_cast<double>(to - from);
  }
  return out;
}

// Quantities of joint j, then the positions of the other joints.
std::vector<Regressor> list_quantities(const Experiment& e, int j) {
  std::vector<Regressor> list{{"position", "its position", "rad"},
                              {"velocity", "its velocity", "rad/s"},
                              {"direction", "the direction of its motion", ""},
                              {"load", "the effort that its motion takes", "N m"},
                              {"time", "time", "s"},
                              {"history", "where it has been shortly before", "", false}};
  for (int other = 0; other < e.num_joints(); ++other) {
    if (other != j) list.push_back({"position", "the position of " + e.robot.tree.joint(other).name, ""});
  }
  return list;
}

Observed observe(const MissingEffort& m, int j) {
  Observed o;
  o.time = m.time;
  o.y = average(m, j);
  o.x.resize(6);
  double swing = 0.0;
  for (long k = 0; k < m.q.rows(); ++k) {
    if (k > 0) swing = 0.97 * swing + m.q(k, j) - m.q(k - 1, j);
    const double v = m.qd(k, j);
    // The given effort minus the missing effort is the effort of the motion.
    const double values[] = {m.q(k, j),
                             v,
                             v > kMoving    ? 1.0
                             : v < -kMoving ? -1.0
                                            : 0.0,
                             m.u(k, j) - m.missing(k, j),
                             m.time[static_cast<size_t>(k)],
                             swing};
    for (size_t i = 0; i < 6; ++i) o.x[i].push_back(values[i]);
  }
  for (int other = 0; other < static_cast<int>(m.q.cols()); ++other) {
    if (other == j) continue;
    const Eigen::VectorXd q = m.q.col(other);
    o.x.emplace_back(q.data(), q.data() + q.size());
  }
  return o;
}

// Joints whose squared error beyond noise is at least a tenth of the worst joint's; the worst first.
std::vector<int> list_missed(const Score& left) {
  std::vector<double> beyond(left.signal_chi2.size() / kQuantities, 0.0);
  for (size_t c = 0; c < left.signal_chi2.size(); ++c)
    beyond[c / kQuantities] += std::max(0.0, left.signal_chi2[c] - left.signal_count[c]);
  std::vector<int> joints;
  for (size_t j = 0; j < beyond.size(); ++j) {
    if (beyond[j] >= 0.1 * *std::max_element(beyond.begin(), beyond.end())) joints.push_back(static_cast<int>(j));
  }
  std::stable_sort(joints.begin(), joints.end(),
                   [&](int a, int b) { return beyond[static_cast<size_t>(a)] > beyond[static_cast<size_t>(b)]; });
  return joints;
}

// Mean square of the missing effort in units of its noise.
double calc_missed(const std::vector<MissingEffort>& recordings, int j) {
  double sum = 0.0, count = 0.0;
  for (const MissingEffort& m : recordings) {
    sum += (m.missing.col(j) / m.sigma[static_cast<size_t>(j)]).squaredNorm();
    count += static_cast<double>(m.missing.rows());
  }
  return sum / std::max(1.0, count);
}

// Joints to report, strongest first.
std::vector<int> choose_joints(const std::vector<MissingEffort>& recordings, const Score& left) {
  std::vector<std::pair<double, int>> missed;
  for (int j : list_missed(left)) missed.push_back({calc_missed(recordings, j), j});
  if (missed.empty()) return {};
  const int worst = missed.front().second;
  std::stable_sort(missed.begin(), missed.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  // If the noise of accelerations hides the efforts, the worst joint is still known from its readings.
  if (missed.front().first < kAboveNoise * kAboveNoise) return {worst};
  std::vector<int> joints;
  for (const auto& [square, j] : missed) {
    const bool speaks = square >= kAboveNoise * kAboveNoise && square >= kDetail * missed.front().first;
    if (speaks && joints.size() < kMostInSentence) joints.push_back(j);
  }
  return joints;
}

}  // namespace

std::vector<Dependence> find_dependence(const Problem& problem, const Hypothesis& base, const Score& left) {
  std::vector<MissingEffort> train, test;
  for (int r : problem.train) train.push_back(calc_missing_effort(problem, base, r));
  for (int r : get_judged(problem)) test.push_back(calc_missing_effort(problem, base, r));
  std::vector<Dependence> list;
  for (int j : choose_joints(train, left)) {
    Dependence d;
    d.joint = j;
    std::vector<Observed> a, b;
    for (const MissingEffort& m : train) a.push_back(observe(m, j));
    for (const MissingEffort& m : test) b.push_back(observe(m, j));
    double squares = 0.0, count = 0.0;
    for (const Observed& o : a) {
      squares += std::inner_product(o.y.begin(), o.y.end(), o.y.begin(), 0.0);
      count += static_cast<double>(o.y.size());
    }
    d.effort = std::sqrt(squares / std::max(1.0, count));
    d.relation = find_relation(list_quantities(*problem.experiment, j), a, b);
    list.push_back(d);
  }
  return list;
}

}  // namespace hrp::diagnosis
