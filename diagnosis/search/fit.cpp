// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/fit_residuals.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/parameters.h"
#include "diagnosis/search/significance.h"

namespace hrp::diagnosis {
namespace {

using FreeParameter = Parameter<EffectParameter>;

// Above the noise a slowly converging fit stops early: it will not reach it. At a hundredth, a fit of all joints of a
// robot with play stops far from it.
constexpr double kFarTolerance = 5e-3;

std::vector<FreeParameter> list_parameters(const Hypothesis& hypothesis, const std::vector<char>& frozen) {
  return flatten<EffectParameter>(
      hypothesis, [](const Effect& e) -> const auto& { return list_infos(e.id); },
      [&](size_t e, const EffectParameter& info) { return !info.scanned && !(e < frozen.size() && frozen[e]); });
}

// Stick-slip makes readings a non-smooth function of friction. Differences over 2 % show its trend.
double find_difference(EffectId id, const EffectParameter& info, double value) {
  return (sticks(id) ? 0.02 : 0.005) * std::max(info.step, std::abs(value));
}

using Residuals = std::vector<double>;  // of one recording
using CalcScore = std::function<Score(const Hypothesis& hypothesis, std::vector<Residuals>* residuals)>;

struct Normal {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  bool ok = true;
  std::vector<Eigen::VectorXd> blocks;  // score vectors summed over stretches of the recordings
};

// J^T J and J^T r of one recording, from its residuals and those with each parameter changed.
Normal make_normal(const Residuals& residuals, const std::vector<Residuals>& moved, const std::vector<double>& deltas,
                   bool blocks) {
  const size_t p = deltas.size(), size = residuals.size();
  Normal normal;
  normal.A.setZero(static_cast<long>(p), static_cast<long>(p));
  normal.b.setZero(static_cast<long>(p));
  Eigen::VectorXd row(static_cast<long>(p)), sum = Eigen::VectorXd::Zero(static_cast<long>(p));
  const size_t stretch = size / kIndependent + 1;
  for (size_t k = 0; k < size; ++k) {
    const double r = residuals[k];
    for (size_t i = 0; i < p; ++i) row[static_cast<long>(i)] = (moved[i][k] - r) / deltas[i];
    for (size_t i = 0; i < p; ++i) {
      const double x = row[static_cast<long>(i)];
      if (x == 0.0) continue;
      normal.b[static_cast<long>(i)] += x * r;
      for (size_t j = 0; j <= i; ++j)
        normal.A(static_cast<long>(i), static_cast<long>(j)) += x * row[static_cast<long>(j)];
    }
    if (!blocks) continue;
    sum += row * r;
    if ((k + 1) % stretch == 0 || k + 1 == size) {
      normal.blocks.push_back(sum);
      sum.setZero();
    }
  }
  normal.A = normal.A.selfadjointView<Eigen::Lower>();
  return normal;
}

void clamp(Hypothesis* hypothesis) {
  for (Effect& effect : *hypothesis) {
    const std::vector<EffectParameter>& infos = list_infos(effect.id);
    for (size_t i = 0; i < effect.p.size(); ++i) {
      effect.p[i] = std::min(infos[i].high, std::max(infos[i].low, effect.p[i]));
      if (infos[i].not_below >= 0)
        effect.p[i] = std::max(effect.p[i], effect.p[static_cast<size_t>(infos[i].not_below)]);
    }
  }
}

class Fitter {
 public:
  Fitter(const CalcResiduals& calc_residuals, const CalcScore& calc_score, int jobs, const Hypothesis& start,
         const std::vector<int>& recordings, const FitOptions& options)
      : calc_residuals_(calc_residuals),
        calc_score_(calc_score),
        jobs_(jobs),
        recordings_(recordings),
        options_(options),
        hypothesis_(start),
        parameters_(list_parameters(start, options.frozen)) {
    clamp(&hypothesis_);
  }

  FitResult run() {
    FitResult result;
    if (!try_hypothesis(hypothesis_, 1e300)) return result;
    double lambda = 1e-3;
    for (int i = 0; i < options_.max_iterations; ++i) {
      result.iterations = i + 1;
      const Normal normal = linearise(false);
      if (!normal.ok) break;
      const double before = score_.chi2;
      bool better = false;
      for (int attempt = 0; attempt < 5 && !better; ++attempt) {
        better = try_hypothesis(take_step(normal, lambda), before);
        lambda = better ? std::max(1e-9, lambda * 0.1) : lambda * 8.0;
      }
      if (!better) break;
      if (i >= 2 && options_.abandon_above > 0.0 && score_.chi2 > options_.abandon_above) break;
      const double tolerance =
          score_.rms() > kAboveNoise ? std::max(kFarTolerance, options_.tolerance) : options_.tolerance;
      if (before - score_.chi2 < tolerance * score_.chi2 + 0.5) break;
    }
    result.hypothesis = hypothesis_;
    result.train = score_;
    result.ok = true;
    if (options_.intervals) add_intervals(&result);
    return result;
  }

 private:
  // Accepts the hypothesis if its chi2 is below `before`.
  bool try_hypothesis(const Hypothesis& hypothesis, double before) {
    std::vector<Residuals> residuals;
    const Score score = calc_score_(hypothesis, &residuals);
    if (!score.ok || !(score.chi2 < before)) return false;
    hypothesis_ = hypothesis;
    score_ = score;
    residuals_ = std::move(residuals);
    return true;
  }

  // Normal equations of all recordings. The rollouts with changed parameters run in parallel.
  Normal linearise(bool blocks) const {
    const size_t p = parameters_.size(), n = recordings_.size();
    const std::vector<Move> moves = list_moves(hypothesis_, options_.frozen);
    std::vector<double> deltas;
    for (const Move& move : moves) deltas.push_back(move.delta);
    std::vector<std::vector<Residuals>> moved(n, std::vector<Residuals>(p));
    std::vector<char> ok(n * p, 1);
    parallel_for(jobs_, static_cast<int>(n * p), [&](int task) {
      const size_t r = static_cast<size_t>(task) / p, v = static_cast<size_t>(task) % p;
      ok[static_cast<size_t>(task)] = calc_residuals_(moves[v].hypothesis, recordings_[r], &moved[r][v]);
    });
    Normal total;
    total.A.setZero(static_cast<long>(p), static_cast<long>(p));
    total.b.setZero(static_cast<long>(p));
    total.ok = std::all_of(ok.begin(), ok.end(), [](char c) { return c != 0; });
    if (!total.ok) return total;
    for (size_t r = 0; r < n; ++r) {
      const Normal one = make_normal(residuals_[r], moved[r], deltas, blocks);
      total.A += one.A;
      total.b += one.b;
      total.blocks.insert(total.blocks.end(), one.blocks.begin(), one.blocks.end());
    }
    return total;
  }

  Hypothesis take_step(const Normal& normal, double lambda) const {
    Eigen::MatrixXd A = normal.A;
    for (long i = 0; i < A.rows(); ++i) {
      const double step = parameters_[static_cast<size_t>(i)].info->step;
      A(i, i) = A(i, i) * (1.0 + lambda) + 1e-6 / (step * step);  // keeps parameters without information
    }
    const Eigen::VectorXd dx = A.ldlt().solve(-normal.b);
    Hypothesis trial = hypothesis_;
    for (size_t i = 0; i < parameters_.size(); ++i) {
      const double d = dx[static_cast<long>(i)];
      if (std::isfinite(d)) trial[parameters_[i].effect].p[parameters_[i].index] += d;
    }
    clamp(&trial);
    return trial;
  }

  // Covariance A^-1 B A^-1 with B from sums over stretches, at least A (times the mean squared residual if above 1).
  void add_intervals(FitResult* result) {
    const Normal normal = linearise(true);
    if (!normal.ok) return;
    const long p = static_cast<long>(parameters_.size());
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(p, p);
    for (const Eigen::VectorXd& s : normal.blocks) B += s * s.transpose();
    const double inflate = std::max(1.0, result->train.chi2 / std::max(1.0, result->train.count));
    Eigen::MatrixXd A = normal.A;
    for (long i = 0; i < p; ++i) {
      const EffectParameter& info = *parameters_[static_cast<size_t>(i)].info;
      A(i, i) += 1e-9 / (info.step * info.step);
      // Prior of the drive's timing: uniform between its bounds, as a variance. Without it, a lag of the servo's rate
      // could not be distinguished from a rotor's inertia.
      if (is_timing(hypothesis_[parameters_[static_cast<size_t>(i)].effect]))
        A(i, i) += 12.0 / std::pow(info.high - info.low, 2);
    }
    const RobustCovariance covariance = make_robust_covariance(A.ldlt().solve(Eigen::MatrixXd::Identity(p, p)), B);
    result->std.clear();
    for (const Effect& effect : result->hypothesis) result->std.emplace_back(effect.p.size(), 0.0);
    for (long i = 0; i < p; ++i) {
      const FreeParameter& parameter = parameters_[static_cast<size_t>(i)];
      const double variance = covariance.find_variance(i, inflate);
      result->std[parameter.effect][parameter.index] = std::sqrt(std::max(0.0, variance));
    }
    for (size_t e = 0; e < result->hypothesis.size(); ++e) result->distance.push_back(calc_distance(A, B, inflate, e));
  }

  // Distance of an effect from zero in standard deviations: along the step that removes it, with the other parameters
  // fitted again. A force may be significant even if none of its components is.
  double calc_distance(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double inflate, size_t effect) const {
    const long p = A.rows();
    Eigen::VectorXd w = Eigen::VectorXd::Zero(p);
    Eigen::MatrixXd others = A;
    for (long i = 0; i < p; ++i) {
      const FreeParameter& parameter = parameters_[static_cast<size_t>(i)];
      if (parameter.effect == effect) w[i] = hypothesis_[effect].p[parameter.index];
    }
    Eigen::VectorXd pull = -A * w;
    for (long i = 0; i < p; ++i) {
      if (parameters_[static_cast<size_t>(i)].effect != effect) continue;
      others.row(i).setZero();
      others.col(i).setZero();
      others(i, i) = 1.0;
      pull[i] = 0.0;
    }
    w += others.ldlt().solve(pull);
    const double information = w.dot(A * w), variance = std::max(inflate * information, w.dot(B * w));
    return variance > 0.0 ? information / std::sqrt(variance) : 0.0;
  }

  const CalcResiduals calc_residuals_;
  const CalcScore calc_score_;
  const int jobs_;
  std::vector<int> recordings_;
  FitOptions options_;
  Hypothesis hypothesis_;
  std::vector<FreeParameter> parameters_;
  Score score_;                       // of hypothesis_
  std::vector<Residuals> residuals_;  // by recording
};

}  // namespace

std::vector<Move> list_moves(const Hypothesis& hypothesis, const std::vector<char>& frozen) {
  std::vector<Move> moves;
  for (const FreeParameter& parameter : list_parameters(hypothesis, frozen)) {
    const double value = hypothesis[parameter.effect].p[parameter.index];
    double delta = find_difference(hypothesis[parameter.effect].id, *parameter.info, value);
    if (value + delta > parameter.info->high) delta = -delta;
    Move move{hypothesis, delta, parameter.effect};
    move.hypothesis[parameter.effect].p[parameter.index] += delta;
    moves.push_back(std::move(move));
  }
  return moves;
}

FitResult fit(const Problem& problem, const Hypothesis& start, const std::vector<int>& recordings,
              const FitOptions& options) {
  const auto residuals = [&](const Hypothesis& h, int recording, Residuals* out) {
    return calc_residuals(problem, h, recording, out);
  };
  const auto score = [&](const Hypothesis& h, std::vector<Residuals>* out) {
    return calc_score(problem, h, recordings, out);
  };
  return Fitter(residuals, score, problem.jobs, start, recordings, options).run();
}

Score calc_score(const CalcResiduals& calc, int jobs, const Hypothesis& hypothesis, const std::vector<int>& recordings,
                 std::vector<std::vector<double>>* all) {
  std::vector<Residuals> own, &residuals = all ? *all : own;
  residuals.assign(recordings.size(), {});
  std::vector<char> ok(recordings.size(), 1);
  parallel_for(jobs, static_cast<int>(recordings.size()), [&](int r) {
    const auto at = static_cast<size_t>(r);
    ok[at] = calc(hypothesis, recordings[at], &residuals[at]);
  });
  Score score;
  score.ok = std::all_of(ok.begin(), ok.end(), [](char c) { return c != 0; });
  for (const Residuals& one : residuals) {
    for (double r : one) {
      score.chi2 += r * r;
      score.count += r != 0.0 ? 1.0 : 0.0;
    }
  }
  return score;
}

FitResult fit(const CalcResiduals& calc, int jobs, const Hypothesis& start, const std::vector<int>& recordings,
              const FitOptions& options) {
  const auto score = [&](const Hypothesis& h, std::vector<Residuals>* out) {
    return calc_score(calc, jobs, h, recordings, out);
  };
  return Fitter(calc, score, jobs, start, recordings, options).run();
}

}  // namespace hrp::diagnosis
