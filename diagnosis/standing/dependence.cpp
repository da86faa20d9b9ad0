// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/dependence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kOwnMotion = 1.0;  // [Hz] a robot's own sway is slower

// Quantities that the residual of a joint may depend on, or that of another channel (joint -1).
std::vector<Regressor> list_quantities(const StandProblem& p, int joint) {
  if (joint < 0) return {{"load", "the vertical force", "N"}, {"time", "time", "s"}};
  std::vector<Regressor> list{{"load", "the effort that its motion takes", "N m"},
                              {"time", "time", "s"},
                              {"position", "its position", "rad"},
                              {"velocity", "its velocity", "rad/s"},
                              {"direction", "the direction of its motion", ""}};
  for (int other = 0; other < p.tree.num_joints(); ++other) {
    if (other != joint) list.push_back({"position", "the position of " + p.tree.joint(other).name, ""});
  }
  return list;
}

// The residual of a channel in one recording, with the quantities of list_quantities.
Observed observe(const StandProblem& p, const Channel& channel, size_t index, size_t r, const StandBase& base) {
  const StandRecording& recording = p.recordings[r];
  const size_t channels = base.residuals.size() / recording.samples.size();
  const int j = p.tree.find_joint(channel.joint);
  Observed out;
  out.x.resize(list_quantities(p, j).size());
  for (size_t s = 0; s < recording.samples.size(); ++s) {
    const auto k = static_cast<size_t>(recording.samples[s]);
    const double y = base.residuals[s * channels + index];
    if (y == 0) continue;
    std::vector<double> x{recording.wrench[2].value[k], recording.time[k] - recording.time[0]};
    if (j >= 0) {
      const auto i = static_cast<size_t>(j);
      const double velocity = recording.position[i].rate[k];
      // The given effort minus the residual is the effort of the motion.
      if (!recording.effort[i].value.empty()) x[0] = recording.effort[i].value[k] - y;
      x.insert(x.end(), {recording.position[i].value[k], velocity, velocity > 0 ? 1.0 : -1.0});
      for (int other = 0; other < p.tree.num_joints(); ++other) {
        if (other != j) x.push_back(recording.position[static_cast<size_t>(other)].value[k]);
      }
    }
    out.time.push_back(x[1]);
    out.y.push_back(y);
    for (size_t i = 0; i < x.size(); ++i) out.x[i].push_back(x[i]);
  }
  return out;
}

struct Halves {
  std::vector<Observed> train, test;
};

Halves observe_all(const StandProblem& p, const Channel& channel, size_t index, const Evaluation& evaluation) {
  Halves all;
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const Observed one = observe(p, channel, index, r, evaluation[r]);
    if (one.y.size() >= kFewestToTell) (p.recordings[r].train ? all.train : all.test).push_back(one);
  }
  if (all.test.empty()) all.test = all.train;
  return all;
}

}  // namespace

Relation find_dependence(const StandProblem& p, const Channel& channel, size_t index, const Evaluation& evaluation) {
  const Halves all = observe_all(p, channel, index, evaluation);
  if (all.train.empty()) return {};
  return find_relation(list_quantities(p, p.tree.find_joint(channel.joint)), all.train, all.test);
}

bool follows_time(const StandProblem& p, const Channel& channel, size_t index, const Evaluation& evaluation) {
  const Halves all = observe_all(p, channel, index, evaluation);
  // Noise of half the signal's rms leaves a quarter.
  return !all.train.empty() && find_oscillation(all.train, all.test, kOwnMotion).share > kLargely;
}

namespace {

using Row = Eigen::VectorXd;  // regressors, then what they are to explain

// Calls visit(recording, sample, residuals by channel) for every sample.
template <typename Visit>
void for_each_sample(const StandProblem& p, const Evaluation& evaluation, const Visit& visit) {
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const StandRecording& recording = p.recordings[r];
    const size_t channels = evaluation[r].residuals.size() / recording.samples.size();
    for (size_t s = 0; s < recording.samples.size(); ++s) {
      visit(recording, static_cast<size_t>(recording.samples[s]), &evaluation[r].residuals[s * channels]);
    }
  }
}

// Squares that these regressors leave.
double calc_left(const std::vector<Row>& rows, const std::vector<long>& columns) {
  Eigen::MatrixXd A(static_cast<long>(rows.size()), static_cast<long>(columns.size()));
  Eigen::VectorXd y(A.rows());
  for (long i = 0; i < A.rows(); ++i) {
    const Row& row = rows[static_cast<size_t>(i)];
    for (size_t c = 0; c < columns.size(); ++c) A(i, static_cast<long>(c)) = row(columns[c]);
    y(i) = row(row.size() - 1);
  }
  return (y - A * A.colPivHouseholderQr().solve(y)).squaredNorm();
}

}  // namespace

bool follows_joint(const StandProblem& p, const Channel& channel, size_t index, const Evaluation& evaluation,
                   int other) {
  const int own = p.tree.find_joint(channel.joint);
  if (own < 0 || own == other) return false;
  std::vector<Row> rows;  // 1, own position, other's position
  for_each_sample(p, evaluation, [&](const StandRecording& recording, size_t k, const double* residuals) {
    const auto get = [&](int joint) { return recording.position[static_cast<size_t>(joint)].value[k]; };
    rows.push_back(Eigen::Vector4d(1, get(own), get(other), residuals[index]));
  });
  return calc_left(rows, {0, 1, 2}) < 0.5 * calc_left(rows, {0, 1});
}

double calc_spring_gain(const StandProblem& p, const Evaluation& evaluation, const SpringPair& pair) {
  std::vector<Row> rows;  // of both efforts: their means, one slope each, one slope of the sum, one of the difference
  for_each_sample(p, evaluation, [&](const StandRecording& recording, size_t k, const double* residuals) {
    const auto get = [&](int i) { return recording.position[static_cast<size_t>(pair.joints[i])].value[k]; };
    for (int i = 0; i < 2; ++i) {
      const double q = get(i), other = get(1 - i), sign = i == 0 ? 1 : -1, left = residuals[pair.channels[i]];
      Row row(7);
      row << (i == 0), (i == 1), (i == 0 ? q : 0), (i == 1 ? q : 0), q + other, sign * (get(0) - get(1)), left;
      if (left != 0) rows.push_back(row / pair.noise[i]);
    }
  });
  const double one = std::min(calc_left(rows, {0, 1, 4}), calc_left(rows, {0, 1, 5})),
               two = calc_left(rows, {0, 1, 2, 3});
  return static_cast<double>(rows.size()) * std::log(one / std::max(1e-300, two));
}

namespace {

// Rows of a moving joint: 1, position, its square, residual along the direction of motion.
Eigen::Matrix<double, Eigen::Dynamic, 4> collect_friction(const StandProblem& p, const Evaluation& evaluation,
                                                          size_t channel, size_t joint, bool train) {
  std::vector<Eigen::Vector4d> rows;
  for (size_t r = 0; r < evaluation.size(); ++r) {
    if (p.recordings[r].train != train) continue;
    const size_t n = p.recordings[r].samples.size(), channels = evaluation[r].residuals.size() / n;
    for (size_t s = 0; s < n; ++s) {
      const DriveState& state = evaluation[r].states[s * p.effort.size() + joint];
      const double left = evaluation[r].residuals[s * channels + channel], q = state.encoder;
      if (left != 0 && std::abs(state.velocity) > kSlips) {
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
  if (train.rows() < static_cast<long>(4 * kFewestToTell) || held.rows() < static_cast<long>(kFewestToTell)) return 0;
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
      apart += (x - y) * (x - y);
      one += x * x;
      other += y * y;
    }
  }
  return apart < 0.3 * std::min(one, other);  // noise counts twice in the difference
}

}  // namespace hrp::diagnosis::standing
