// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/bush_fit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "diagnosis/identification/bush_rows.h"

namespace hrp::identification {

const char* const kLawNames[kLaws] = {"linear", "hardening", "hysteresis"};

namespace {

constexpr double kBlock = 0.5;    // [s] scores are summed over blocks before their correlation is looked at
constexpr int kRounds = 5;        // K times bias: bilinear, K is known to 1 % after the first round
constexpr int kYieldRounds = 12;  // the yield angle is not linear at all
// What is known beforehand: a bad accelerometer, a slow gyroscope, rubber of at least 1e5 N/m.
constexpr double kBiasPrior = 0.1;         // [m/s^2]
constexpr double kDelayPrior = 5e-3;       // [s]
constexpr double kCompliancePrior = 1e-5;  // [m/N]
constexpr double kInertiaPrior = 0.01;     // [kg m^2] a whole foot of 1.6 kg about its bush
// Systematic errors, which no residual shows (docs/identification.md, runs without noise): 1e-6 rad of the vertical are
// left; the floor under a sole 0.136 m wide on 1e9 N/m is in series with the bush, 1e-4 of K and twice that of C.
constexpr double kVerticalFloor = 2e-6;                            // [rad]
constexpr double kScaleFloor = 1e-4;                               // of K and C
constexpr double kYields[] = {0.002, 0.004, 0.008, 0.016, 0.032};  // [rad] where the search for a yield angle starts
constexpr double kYieldPrior = 1.5;                                // of its logarithm, about the start

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

struct Prior {
  Vector mean, precision;
};

Prior make_prior(const Layout& layout, const FitOptions& options, double gyro_std, double yield) {
  Prior prior{Vector::Zero(layout.size()), Vector::Zero(layout.size())};
  const auto set = [&](Eigen::Index i, double mean, double std) {
    prior.mean[i] = mean;
    prior.precision[i] = 1.0 / (std * std);
  };
  for (size_t f = 0; f < layout.feet; ++f) {
    for (int a = 0; a < kAxes; ++a) set(layout.first(f, a) + 3, 0.0, kInertiaPrior);
    const bool known = f < options.compliance.size() && options.compliance[f].std > 0.0;
    set(layout.compliance(f), known ? options.compliance[f].value : 0.0,
        known ? options.compliance[f].std : kCompliancePrior);
  }
  for (int i = 0; i < kDelay; ++i) set(layout.imu() + i, 0.0, kBiasPrior);
  set(layout.imu() + kDelay, 0.0, kDelayPrior);
  for (int i = 0; i < 2; ++i) set(layout.imu() + kGyroBias + i, 0.0, gyro_std);
  if (layout.law == BushLaw::kHysteresis) set(layout.yield(), std::log(yield), kYieldPrior);
  return prior;
}

struct Normal {
  Matrix A;                   // X^T W X
  Vector b;                   // X^T W y
  std::vector<double> count;  // rows by foot and axis
};

// One fit: what stays the same from round to round.
struct Problem {
  const std::vector<MotionTrack>& tracks;
  const FitOptions& options;
  Layout layout;
  Prior prior;

  // All rows, motion by motion [M14 eq. 7].
  template <class Visit>
  void visit(const Vector& theta, Visit&& what) const {
    Rows rows;
    for (size_t m = 0; m < tracks.size(); ++m) {
      for (size_t f = 0; f < layout.feet; ++f) {
        for (int a = 0; a < kAxes; ++a) {
          make_rows(tracks[m], f, a, layout, theta, options.skip, &rows);
          if (rows.count > 0.0) what(m, f * kAxes + static_cast<size_t>(a), rows);
        }
      }
    }
  }
};

// What is measured of the regressors besides the motion itself.
void subtract_noise(const Problem& p, const std::vector<double>& weight, Normal* normal) {
  if (p.options.noise.empty()) return;
  for (size_t f = 0; f < p.layout.feet; ++f) {
    for (int a = 0; a < kAxes; ++a) {
      const size_t i = f * kAxes + static_cast<size_t>(a);
      const Eigen::Index at = p.layout.first(f, a);
      const Eigen::Index columns[3] = {at, at + 1, at + 3};  // angle, rate, acceleration
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          normal->A(columns[r], columns[c]) -=
              normal->count[i] * weight[i] * p.options.noise[f][static_cast<size_t>(a)](r, c);
        }
      }
    }
  }
}

Normal sum_up(const Problem& p, const Vector& theta, const std::vector<double>& weight) {
  Normal normal{Matrix::Zero(p.layout.size(), p.layout.size()), Vector::Zero(p.layout.size()),
                std::vector<double>(weight.size(), 0.0)};
  p.visit(theta, [&](size_t, size_t unit, const Rows& rows) {
    normal.A.noalias() += weight[unit] * rows.X.transpose() * rows.X;
    normal.b.noalias() += weight[unit] * rows.X.transpose() * rows.y;
    normal.count[unit] += rows.count;
  });
  if (*std::min_element(normal.count.begin(), normal.count.end()) < 50) {
    throw std::runtime_error("a foot never stands without slipping: nothing can be identified");
  }
  return normal;
}

void add_prior(const Prior& prior, Normal* normal) {
  normal->A.diagonal() += prior.precision;
  normal->b += prior.precision.cwiseProduct(prior.mean);
}

// Offsets and apparent inertias may have either sign, and so may all that is not of one bush.
std::vector<bool> find_signs(const Layout& layout) {
  std::vector<bool> may_be_negative(static_cast<size_t>(layout.size()), true);
  for (Eigen::Index i = 0; i < layout.compliance(0); ++i) {
    may_be_negative[static_cast<size_t>(i)] = i % layout.each() == 2 || i % layout.each() == 3;  // O, J
  }
  return may_be_negative;
}

// Covariance that allows for residuals that are alike over some seconds (the vertical wanders slowly), and across feet
// and axes: sums of scores over blocks.
Matrix calc_covariance(const Problem& p, const Vector& theta, const std::vector<double>& weight, const Normal& normal) {
  std::vector<Matrix> scores(p.tracks.size());
  p.visit(theta, [&](size_t m, size_t unit, const Rows& rows) {
    const auto block = static_cast<Eigen::Index>(std::lround(kBlock / p.tracks[m].period));
    const Eigen::Index count = (rows.y.size() + block - 1) / block;
    if (scores[m].size() == 0) scores[m] = Matrix::Zero(p.layout.size(), count);
    const Vector e = weight[unit] * (rows.y - rows.X * theta);
    for (Eigen::Index j = 0; j < count; ++j) {
      const Eigen::Index first = j * block, size = std::min(block, rows.y.size() - first);
      scores[m].col(j) += rows.X.middleRows(first, size).transpose() * e.segment(first, size);
    }
  });
  const int lags = std::max(1, static_cast<int>(std::ceil(p.options.error_memory / kBlock)));
  Matrix S = Matrix::Zero(p.layout.size(), p.layout.size());
  double blocks = 0.0;
  for (const Matrix& s : scores) {
    if (s.size() == 0) continue;  // slipped
    blocks += static_cast<double>(s.cols());
    S += sum_scores(s, lags);
  }
  // Few independent blocks fit their own residuals: as many as parameters are lost.
  const double effective = std::max(1.0, blocks * kBlock / p.options.error_memory);
  S *= 1.0 + static_cast<double>(p.layout.each()) / effective;
  S.diagonal() += p.prior.precision;
  const Matrix inverse = invert_scaled(normal.A);
  return inverse * S * inverse;
}

std::vector<double> calc_weights(const Problem& p, const Vector& theta,
                                 std::vector<std::array<double, kAxes>>* residual) {
  std::vector<double> sum(p.layout.feet * kAxes, 0.0), count(p.layout.feet * kAxes, 0.0), weight;
  p.visit(theta, [&](size_t, size_t unit, const Rows& rows) {
    sum[unit] += (rows.y - rows.X * theta).squaredNorm();
    count[unit] += rows.count;
  });
  residual->assign(p.layout.feet, {});
  for (size_t i = 0; i < sum.size(); ++i) {
    const double variance = sum[i] / std::max(1.0, count[i]);
    (*residual)[i / kAxes][i % kAxes] = std::sqrt(variance);
    weight.push_back(1.0 / std::max(variance, 1e-12));
  }
  return weight;
}

double calc_condition(const Normal& normal, const Layout& layout) {
  const Eigen::Index n = layout.compliance(0);
  const Matrix A = normal.A.topLeftCorner(n, n);
  const Vector scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const Vector values =
      Eigen::SelfAdjointEigenSolver<Matrix>(scale.asDiagonal() * A * scale.asDiagonal()).eigenvalues();
  return std::sqrt(values[n - 1] / std::max(values[0], 1e-300));
}

// Error of the sensor's zero: the same in all motions, so no residual shows it; all of it goes into the offset.
double calc_zero_variance(const SensorZero& zero, const Vector3d& p_UC, int axis) {
  Vector6d gain = Vector6d::Zero();
  Vector3d direction = Vector3d::Zero();
  direction[axis] = 1.0;
  gain << -direction.cross(p_UC), direction;  // direction . (M - p x F)
  return gain.dot(zero.covariance * gain);
}

void name_held(const std::vector<Eigen::Index>& held, const Layout& layout, BushFit* fit) {
  const char* const names[] = {"K", "C", "O", "J", layout.law == BushLaw::kHardening ? "B" : "H"};
  for (Eigen::Index i : held) {
    const Eigen::Index unit = i / layout.each();
    fit->constrained.push_back(std::string(names[i % layout.each()]) + " of foot " + std::to_string(unit / kAxes) +
                               " " + kAxisNames[unit % kAxes]);
  }
}

void fill_result(const Problem& p, const Vector& theta, const Matrix& covariance, const std::vector<SensorZero>& zeros,
                 const std::vector<Vector3d>& arms, BushFit* fit) {
  const auto get = [&](Eigen::Index i, double more) {
    return Estimate{theta[i], std::sqrt(std::max(0.0, covariance(i, i)) + more)};
  };
  fit->feet.resize(p.layout.feet);
  for (size_t f = 0; f < p.layout.feet; ++f) {
    for (int a = 0; a < kAxes; ++a) {
      const Eigen::Index at = p.layout.first(f, a);
      BushParameters& out = fit->feet[f][static_cast<size_t>(a)];
      out.K = get(at, std::pow(kScaleFloor * theta[at], 2));
      out.C = get(at + 1, std::pow(kScaleFloor * theta[at + 1], 2));
      out.O = get(at + 2, calc_zero_variance(zeros[f], arms[f], a) + std::pow(kVerticalFloor * theta[at], 2));
      out.J = get(at + 3, 0.0);
      if (p.layout.law == BushLaw::kHardening) out.cubic = get(at + 4, 0.0);
      if (p.layout.law == BushLaw::kHysteresis) out.hysteresis = get(at + 4, 0.0);
    }
    fit->compliance.push_back(get(p.layout.compliance(f), 0.0));
  }
  for (int i = 0; i < kDelay; ++i) fit->accelerometer_bias[i] = get(p.layout.imu() + i, 0.0);
  fit->delay = get(p.layout.imu() + kDelay, 0.0);
  for (int i = 0; i < 2; ++i) fit->gyro_bias[i] = get(p.layout.imu() + kGyroBias + i, 0.0);
  if (p.layout.law == BushLaw::kHysteresis) {
    const Estimate log_yield = get(p.layout.yield(), 0.0);
    fit->yield = {std::exp(log_yield.value), std::exp(log_yield.value) * log_yield.std};
  }
  fit->theta = theta;
}

// Sum of squares over variances of the first round's residuals, as if each were independent: to compare starts.
double calc_loss(const BushFit& fit) {
  double loss = 0.0;
  for (const auto& foot : fit.residual) {
    for (double r : foot) loss += std::log(std::max(r, 1e-9));
  }
  return loss;
}

BushFit fit_from(const Problem& p, Vector theta, const std::vector<SensorZero>& zeros,
                 const std::vector<Vector3d>& arms) {
  BushFit fit;
  fit.law = p.layout.law;
  fit.skip = p.options.skip;
  std::vector<double> weight(p.layout.feet * kAxes, 1.0);
  std::vector<Eigen::Index> held;
  Normal normal;
  for (int round = 0; round < (p.layout.law == BushLaw::kHysteresis ? kYieldRounds : kRounds); ++round) {
    normal = sum_up(p, theta, weight);
    subtract_noise(p, weight, &normal);
    add_prior(p.prior, &normal);
    const Vector before = theta;
    theta = solve_signed(normal.A, normal.b, find_signs(p.layout), &held);
    if (!theta.allFinite()) throw std::runtime_error("the motions do not tell the parameters");
    if (p.layout.law == BushLaw::kHysteresis) {  // by at most a third a round
      const Eigen::Index i = p.layout.yield();
      theta[i] = std::clamp(theta[i], before[i] - 0.3, before[i] + 0.3);
    }
    weight = calc_weights(p, theta, &fit.residual);
  }
  normal = sum_up(p, theta, weight);
  fit.condition = calc_condition(normal, p.layout);
  subtract_noise(p, weight, &normal);
  add_prior(p.prior, &normal);
  fill_result(p, theta, calc_covariance(p, theta, weight, normal), zeros, arms, &fit);
  name_held(held, p.layout, &fit);
  return fit;
}

}  // namespace

BushFit fit_bush(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                 const std::vector<Vector3d>& arms, const FitOptions& options) {
  if (tracks.empty()) throw std::runtime_error("no motion to identify from");
  const Layout layout{tracks[0].feet.size(), options.law};
  if (options.law != BushLaw::kHysteresis) {
    return fit_from({tracks, options, layout, make_prior(layout, options, zeros[0].gyro_std, 0.0)},
                    Vector::Zero(layout.size()), zeros, arms);
  }
  BushFit best;
  std::vector<double> starts(std::begin(kYields), std::end(kYields));
  if (options.yield > 0.0) starts = {options.yield};
  for (double yield : starts) {
    const Problem problem{tracks, options, layout, make_prior(layout, options, zeros[0].gyro_std, yield)};
    BushFit fit = fit_from(problem, problem.prior.mean, zeros, arms);
    if (best.feet.empty() || calc_loss(fit) < calc_loss(best)) best = fit;
  }
  return best;
}

Eigen::VectorXd predict_torque(const BushFit& fit, const MotionTrack& track, size_t foot, int axis) {
  return calc_torque(track, foot, axis, {fit.feet.size(), fit.law}, fit.theta);
}

std::vector<std::array<Matrix3d, kAxes>> calc_angle_noise(const MotionTrack& resting) {
  std::vector<std::array<Matrix3d, kAxes>> noise(resting.feet.size());
  for (size_t f = 0; f < noise.size(); ++f) {
    for (int a = 0; a < kAxes; ++a) {
      Matrix values(resting.time.size(), 3);
      values << resting.feet[f].angle[a], resting.feet[f].rate[a], resting.feet[f].acceleration[a];
      values.rowwise() -= values.colwise().mean().eval();
      noise[f][static_cast<size_t>(a)] = values.transpose() * values / static_cast<double>(values.rows() - 1);
    }
  }
  return noise;
}

}  // namespace hrp::identification
