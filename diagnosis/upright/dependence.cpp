// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright/dependence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace hrp::diagnosis::upright {
namespace {

constexpr size_t kBins = 12;
constexpr double kNearlyAll = 0.7;  // share of squares; the noise of an effort that is twice its noise has a quarter
constexpr double kRuns = 0.02;      // [rad/s] far from where friction holds a joint
constexpr double kShare = 0.12;     // least share of the held-out remainder; fixed-base dependences use the same

struct Sample {
  double y = 0, position = 0, velocity = 0, load = 0, time = 0;
};
using Samples = std::vector<Sample>;

double get_square(const Samples& samples) {
  double sum = 0;
  for (const Sample& s : samples) sum += s.y * s.y;
  return sum;
}

// Share of the squares of `test` that means of `train` over quantiles of x take away.
template <class Get>
double judge(const Samples& train, const Samples& test, Get x) {
  std::vector<double> values;
  for (const Sample& s : train) values.push_back(x(s));
  std::sort(values.begin(), values.end());
  std::array<double, kBins - 1> edges;
  for (size_t b = 0; b + 1 < kBins; ++b) edges[b] = values[(b + 1) * values.size() / kBins];
  const auto find = [&](const Sample& s) {
    return static_cast<size_t>(std::upper_bound(edges.begin(), edges.end(), x(s)) - edges.begin());
  };
  std::array<double, kBins> mean{}, count{};
  for (const Sample& s : train) mean[find(s)] += s.y, ++count[find(s)];
  double left = 0;
  for (const Sample& s : test) {
    const size_t b = find(s);
    left += std::pow(s.y - (count[b] > 0 ? mean[b] / count[b] : 0), 2);
  }
  return 1 - left / std::max(1e-300, get_square(test));
}

// Share that a sinusoid of time takes away; its frequency is learnt, amplitude and phase are each recording's own.
double judge_frequency(const std::vector<Samples>& train, const std::vector<Samples>& test) {
  const auto calc_share = [](const std::vector<Samples>& all, double f) {
    double taken = 0, total = 0;
    for (const Samples& one : all) {
      double c = 0, s = 0;
      for (const Sample& x : one) {
        c += x.y * std::cos(2 * M_PI * f * x.time), s += x.y * std::sin(2 * M_PI * f * x.time);
      }
      taken += 2 * (c * c + s * s) / static_cast<double>(std::max<size_t>(1, one.size())), total += get_square(one);
    }
    return taken / std::max(1e-300, total);
  };
  double best = 0, at = 0;
  for (double f = 1.0; f < 14; f += 0.03) {  // [Hz] above the robot's own motion
    const double share = calc_share(train, f);
    if (share > best) best = share, at = f;
  }
  return calc_share(test, at);
}

Samples collect(const StandProblem& p, const Channel& channel, size_t index, size_t channels, size_t r,
                const std::vector<double>& residuals) {
  const StandRecording& recording = p.recordings[r];
  const int j = p.tree.find_joint(channel.joint);
  Samples out;
  for (size_t s = 0; s < recording.samples.size(); ++s) {
    const auto k = static_cast<size_t>(recording.samples[s]);
    Sample one;
    one.y = residuals[s * channels + index];
    if (one.y == 0) continue;
    one.time = recording.time[k] - recording.time[0];
    one.load = recording.wrench[2].value[k];
    if (j >= 0) {
      const auto i = static_cast<size_t>(j);
      one.position = recording.position[i].value[k], one.velocity = recording.position[i].rate[k];
      if (!recording.effort[i].value.empty()) one.load = recording.effort[i].value[k];
    }
    out.push_back(one);
  }
  return out;
}

}  // namespace

std::vector<std::string> find_dependence(const StandProblem& p, const Channel& channel, size_t index,
                                         const Evaluation& evaluation) {
  std::vector<Samples> train, test;
  Samples all_train, all_test;
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const size_t channels = evaluation[r].residuals.size() / p.recordings[r].samples.size();
    const Samples one = collect(p, channel, index, channels, r, evaluation[r].residuals);
    (p.recordings[r].train ? train : test).push_back(one);
    Samples& all = p.recordings[r].train ? all_train : all_test;
    all.insert(all.end(), one.begin(), one.end());
  }
  if (test.empty()) test = train, all_test = all_train;
  if (all_train.size() < 4 * kBins || all_test.empty()) return {};
  std::vector<std::pair<double, std::string>> shares;
  if (!channel.joint.empty()) {
    shares.emplace_back(judge(all_train, all_test, [](const Sample& s) { return s.position; }), "position");
    shares.emplace_back(judge(all_train, all_test, [](const Sample& s) { return s.velocity; }), "velocity");
    shares.emplace_back(judge(all_train, all_test, [](const Sample& s) { return s.velocity > 0 ? 1.0 : -1.0; }),
                        "direction");
  }
  shares.emplace_back(judge(all_train, all_test, [](const Sample& s) { return s.load; }), "load");
  const double slow = judge(all_train, all_test, [](const Sample& s) { return s.time; });
  shares.emplace_back(std::max(slow, judge_frequency(train, test)), "time");
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> out;
  for (const auto& [share, name] : shares) {
    if (share > kShare && share > 0.45 * shares[0].first) out.push_back(name);
  }
  return out;
}

bool follows_time(const StandProblem& p, const Channel& channel, size_t index, const Evaluation& evaluation) {
  std::vector<Samples> train, test;
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const size_t channels = evaluation[r].residuals.size() / p.recordings[r].samples.size();
    (p.recordings[r].train ? train : test).push_back(collect(p, channel, index, channels, r, evaluation[r].residuals));
  }
  return !train.empty() && judge_frequency(train, test.empty() ? train : test) > kNearlyAll;
}

bool follows_joint(const StandProblem& p, const Channel& channel, size_t index, const Evaluation& evaluation,
                   int other) {
  const int own = p.tree.find_joint(channel.joint);
  if (own < 0 || own == other) return false;
  std::vector<Eigen::Vector4d> rows;  // 1, own position, other's position, what is left
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const StandRecording& recording = p.recordings[r];
    const size_t channels = evaluation[r].residuals.size() / recording.samples.size();
    for (size_t s = 0; s < recording.samples.size(); ++s) {
      const auto k = static_cast<size_t>(recording.samples[s]);
      rows.emplace_back(1, recording.position[static_cast<size_t>(own)].value[k],
                        recording.position[static_cast<size_t>(other)].value[k],
                        evaluation[r].residuals[s * channels + index]);
    }
  }
  const auto left = [&](long columns) {
    Eigen::MatrixXd A(static_cast<long>(rows.size()), columns);
    Eigen::VectorXd y(A.rows());
    for (long i = 0; i < A.rows(); ++i) {
      A.row(i) = rows[static_cast<size_t>(i)].head(columns).transpose(), y(i) = rows[static_cast<size_t>(i)](3);
    }
    return (y - A * A.colPivHouseholderQr().solve(y)).squaredNorm();
  };
  return left(3) < 0.5 * left(2);
}

double calc_spring_gain(const StandProblem& p, const Evaluation& evaluation, const SpringPair& pair) {
  // Both efforts one below the other; columns: their means, a slope each, one slope of the sum or the difference.
  std::vector<Eigen::Matrix<double, 7, 1>> rows;
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const StandRecording& recording = p.recordings[r];
    const size_t channels = evaluation[r].residuals.size() / recording.samples.size();
    for (size_t s = 0; s < recording.samples.size(); ++s) {
      const auto k = static_cast<size_t>(recording.samples[s]);
      const auto get = [&](int i) { return recording.position[static_cast<size_t>(pair.joints[i])].value[k]; };
      for (int i = 0; i < 2; ++i) {
        const double q = get(i), other = get(1 - i), sign = i == 0 ? 1 : -1;
        const double left = evaluation[r].residuals[s * channels + pair.channels[i]];
        Eigen::Matrix<double, 7, 1> row;
        row << (i == 0), (i == 1), (i == 0 ? q : 0), (i == 1 ? q : 0), q + other, sign * (get(0) - get(1)), left;
        if (left != 0) rows.push_back(row / pair.noise[i]);
      }
    }
  }
  const auto left = [&](const std::vector<long>& columns) {
    Eigen::MatrixXd A(static_cast<long>(rows.size()), static_cast<long>(columns.size()));
    Eigen::VectorXd y(A.rows());
    for (long i = 0; i < A.rows(); ++i) {
      const auto& row = rows[static_cast<size_t>(i)];
      for (size_t c = 0; c < columns.size(); ++c) A(i, static_cast<long>(c)) = row(columns[c]);
      y(i) = row(6);
    }
    return (y - A * A.colPivHouseholderQr().solve(y)).squaredNorm();
  };
  const double one = std::min(left({0, 1, 4}), left({0, 1, 5})), two = left({0, 1, 2, 3});
  return static_cast<double>(rows.size()) * std::log(one / std::max(1e-300, two));
}

namespace {

// What friction lacks in a direction of motion, and the joint's position, where it moves.
Eigen::Matrix<double, Eigen::Dynamic, 4> collect_friction(const StandProblem& p, const Evaluation& evaluation,
                                                          size_t channel, size_t joint, bool train) {
  std::vector<Eigen::Vector4d> rows;
  for (size_t r = 0; r < evaluation.size(); ++r) {
    if (p.recordings[r].train != train) continue;
    const size_t n = p.recordings[r].samples.size(), channels = evaluation[r].residuals.size() / n;
    for (size_t s = 0; s < n; ++s) {
      const DriveState& state = evaluation[r].states[s * p.effort.size() + joint];
      const double left = evaluation[r].residuals[s * channels + channel], q = state.encoder;
      if (left != 0 && std::abs(state.velocity) > kRuns) {
        rows.emplace_back(1, q, q * q, state.velocity > 0 ? left : -left);
      }
    }
  }
  Eigen::Matrix<double, Eigen::Dynamic, 4> out(static_cast<long>(rows.size()), 4);
  for (long i = 0; i < out.rows(); ++i) out.row(i) = rows[static_cast<size_t>(i)].transpose();
  return out;
}

}  // namespace

double calc_uneven_gain(const StandProblem& p, const Evaluation& evaluation, size_t channel, size_t joint) {
  const auto train = collect_friction(p, evaluation, channel, joint, true);
  const auto held = collect_friction(p, evaluation, channel, joint, false);
  if (train.rows() < static_cast<long>(4 * kBins) || held.rows() < static_cast<long>(kBins)) return 0;
  const auto left = [&](long columns) {
    const Eigen::VectorXd x = train.leftCols(columns).colPivHouseholderQr().solve(train.col(3));
    return (held.col(3) - held.leftCols(columns) * x).squaredNorm();
  };
  return static_cast<double>(held.rows()) * std::log(left(1) / std::max(1e-300, left(3)));
}

bool are_equal(const Evaluation& evaluation, size_t channels, size_t a, size_t b, double sense) {
  if (a >= channels || b >= channels) return false;
  double apart = 0, one = 0, other = 0;
  for (const StandBase& base : evaluation) {
    for (size_t k = 0; k < base.residuals.size(); k += channels) {
      const double x = base.residuals[k + a], y = sense * base.residuals[k + b];
      apart += (x - y) * (x - y), one += x * x, other += y * y;
    }
  }
  return apart < 0.3 * std::min(one, other);  // noise adds to the difference, twice
}

}  // namespace hrp::diagnosis::upright
