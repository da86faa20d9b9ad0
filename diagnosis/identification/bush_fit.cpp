// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/bush_fit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hrp::identification {
namespace {

constexpr double kBlock = 0.5;      // [s] scores are summed over blocks before their correlation is looked at
constexpr int kBiases = 2;          // accelerometer x, y
constexpr int kRounds = 5;          // K times bias: bilinear, K is known to 1 % after the first round

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

// Where parameters stand: by foot and axis [K, C, O (, cubic)], then the biases.
struct Layout {
  size_t feet;
  int each;
  Eigen::Index first(size_t foot, int axis) const { return static_cast<Eigen::Index>(foot * kAxes + static_cast<size_t>(axis)) * each; }
  Eigen::Index biases() const { return static_cast<Eigen::Index>(feet) * kAxes * each; }
  Eigen::Index size() const { return biases() + kBiases; }
};

bool is_usable(const MotionTrack& track, size_t foot) { return track.loaded[foot] && !has_slipped(track); }

// Rows of one foot and axis [M14 eq. 5], linearised at theta; the target has the nonlinear rest.
void make_rows(const MotionTrack& track, size_t foot, int axis, const Layout& layout, const Vector& theta, Matrix* X, Vector* y) {
  const BushTrack& t = track.feet[foot];
  const Eigen::Index at = layout.first(foot, axis), n = track.time.size();
  const Eigen::Vector2d b = theta.tail<kBiases>();
  const Vector shift = t.bias_gain[axis].leftCols<kBiases>() * b;
  X->setZero(n, layout.size());
  const Vector angle = t.angle[axis] - shift;
  Vector slope = Vector::Constant(n, theta[at]);  // d torque / d angle
  if (layout.each > 3) slope += 3.0 * theta[at + 3] * angle.cwiseAbs2();
  X->col(at) = angle;
  X->col(at + 1) = t.rate[axis];
  X->col(at + 2).setOnes();
  if (layout.each > 3) X->col(at + 3) = angle.array().cube();
  X->middleCols<kBiases>(layout.biases()) = (-slope).asDiagonal() * t.bias_gain[axis].leftCols<kBiases>();
  *y = t.torque[axis] - slope.cwiseProduct(shift);
}

struct Normal {
  Matrix A;                    // X^T W X
  Vector b;                    // X^T W y
  std::vector<double> count;   // rows by foot and axis
};

// What is measured of the regressors besides the motion itself.
void subtract_noise(const FitOptions& options, const Layout& layout, const std::vector<double>& weight, Normal* normal) {
  if (options.noise.empty()) return;
  for (size_t f = 0; f < layout.feet; ++f) {
    for (int a = 0; a < kAxes; ++a) {
      const size_t i = f * kAxes + static_cast<size_t>(a);
      normal->A.block<2, 2>(layout.first(f, a), layout.first(f, a)) -= normal->count[i] * weight[i] * options.noise[f][static_cast<size_t>(a)];
    }
  }
}

Normal sum_up(const std::vector<MotionTrack>& tracks, const Layout& layout, const Vector& theta, const std::vector<double>& weight) {
  Normal normal{Matrix::Zero(layout.size(), layout.size()), Vector::Zero(layout.size()),
                std::vector<double>(weight.size(), 0.0)};
  Matrix X;
  Vector y;
  for (const MotionTrack& track : tracks) {  // [M14 eq. 7]
    for (size_t f = 0; f < layout.feet; ++f) {
      if (!is_usable(track, f)) continue;
      for (int a = 0; a < kAxes; ++a) {
        const size_t i = f * kAxes + static_cast<size_t>(a);
        make_rows(track, f, a, layout, theta, &X, &y);
        normal.A.noalias() += weight[i] * X.transpose() * X;
        normal.b.noalias() += weight[i] * X.transpose() * y;
        normal.count[i] += static_cast<double>(y.size());
      }
    }
  }
  return normal;
}

// A bias only shows if the chest turns against the feet; what does not show stays near zero: 0.1 m/s^2 is a bad sensor.
void add_prior(const Layout& layout, Normal* normal) {
  for (Eigen::Index i = layout.biases(); i < layout.size(); ++i) normal->A(i, i) += 1.0 / (0.1 * 0.1);
}

// Solves, with parameters that would be negative but must not held at zero (an active set; few parameters, few rounds).
Vector solve_constrained(const Normal& normal, const Layout& layout, std::vector<Eigen::Index>* held) {
  held->clear();
  for (int round = 0; round <= layout.size(); ++round) {
    Matrix A = normal.A;
    Vector b = normal.b;
    for (Eigen::Index i : *held) {
      A.row(i).setZero();
      A.col(i).setZero();
      A(i, i) = 1.0;
      b[i] = 0.0;
    }
    const Vector scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Vector theta = scale.asDiagonal() * Matrix(scale.asDiagonal() * A * scale.asDiagonal()).ldlt().solve(scale.cwiseProduct(b));
    bool again = false;
    for (size_t f = 0; f < layout.feet; ++f) {
      for (int a = 0; a < kAxes; ++a) {
        for (int p : {0, 1, 3}) {
          const Eigen::Index i = layout.first(f, a) + p;
          if (p >= layout.each || theta[i] >= 0.0 || std::count(held->begin(), held->end(), i)) continue;
          held->push_back(i);
          again = true;
        }
      }
    }
    if (!again) return theta;
  }
  return Vector::Zero(layout.size());
}

// Covariance that allows for residuals that are alike over some seconds (the vertical wanders slowly), and across feet
// and axes: sums of scores over blocks, correlated with a triangular window (Newey and West 1987).
Matrix calc_covariance(const std::vector<MotionTrack>& tracks, const Layout& layout, const Vector& theta,
                       const std::vector<double>& weight, const Normal& normal, double memory) {
  const int lags = std::max(1, static_cast<int>(std::ceil(memory / kBlock)));
  Matrix S = Matrix::Zero(layout.size(), layout.size()), X;
  Vector y;
  double blocks = 0.0;
  for (const MotionTrack& track : tracks) {
    const auto block = static_cast<Eigen::Index>(std::lround(kBlock / track.period));
    const Eigen::Index count = (track.time.size() + block - 1) / block;
    Matrix scores = Matrix::Zero(layout.size(), count);
    for (size_t f = 0; f < layout.feet; ++f) {
      if (!is_usable(track, f)) continue;
      for (int a = 0; a < kAxes; ++a) {
        make_rows(track, f, a, layout, theta, &X, &y);
        const Vector e = weight[f * kAxes + static_cast<size_t>(a)] * (y - X * theta);
        for (Eigen::Index j = 0; j < count; ++j) {
          const Eigen::Index first = j * block, size = std::min(block, y.size() - first);
          scores.col(j) += X.middleRows(first, size).transpose() * e.segment(first, size);
        }
      }
    }
    blocks += static_cast<double>(count);
    S += scores * scores.transpose();
    for (int lag = 1; lag <= lags && lag < count; ++lag) {
      const Matrix cross = scores.rightCols(count - lag) * scores.leftCols(count - lag).transpose();
      S += (1.0 - static_cast<double>(lag) / (lags + 1)) * (cross + cross.transpose());
    }
  }
  const Matrix inverse = normal.A.ldlt().solve(Matrix::Identity(layout.size(), layout.size()));
  // Few independent blocks fit their own residuals: as many as parameters are lost.
  const double effective = std::max(1.0, blocks * kBlock / memory);
  return inverse * S * inverse * (1.0 + static_cast<double>(layout.each) / effective);
}

std::vector<double> calc_weights(const std::vector<MotionTrack>& tracks, const Layout& layout, const Vector& theta,
                                 std::vector<std::array<double, kAxes>>* residual) {
  std::vector<double> sum(layout.feet * kAxes, 0.0), count(layout.feet * kAxes, 0.0), weight;
  Matrix X;
  Vector y;
  for (const MotionTrack& track : tracks) {
    for (size_t f = 0; f < layout.feet; ++f) {
      if (!is_usable(track, f)) continue;
      for (int a = 0; a < kAxes; ++a) {
        make_rows(track, f, a, layout, theta, &X, &y);
        sum[f * kAxes + static_cast<size_t>(a)] += (y - X * theta).squaredNorm();
        count[f * kAxes + static_cast<size_t>(a)] += static_cast<double>(y.size());
      }
    }
  }
  residual->assign(layout.feet, {});
  for (size_t i = 0; i < sum.size(); ++i) {
    const double variance = sum[i] / std::max(1.0, count[i]);
    (*residual)[i / kAxes][i % kAxes] = std::sqrt(variance);
    weight.push_back(1.0 / std::max(variance, 1e-12));
  }
  return weight;
}

double calc_condition(const Normal& normal, const Layout& layout) {
  const Eigen::Index n = layout.biases();
  const Matrix A = normal.A.topLeftCorner(n, n);
  const Vector scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const Vector values = Eigen::SelfAdjointEigenSolver<Matrix>(scale.asDiagonal() * A * scale.asDiagonal()).eigenvalues();
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
  static const char* const names[] = {"K", "C", "O", "cubic"};
  for (Eigen::Index i : held) {
    const Eigen::Index unit = i / layout.each;
    fit->constrained.push_back(std::string(names[i % layout.each]) + " of foot " + std::to_string(unit / kAxes) + " " + kAxisNames[unit % kAxes]);
  }
}

void fill_result(const Vector& theta, const Matrix& covariance, const Layout& layout, const std::vector<SensorZero>& zeros,
                 const std::vector<Vector3d>& arms, BushFit* fit) {
  const auto get = [&](Eigen::Index i, double more) { return Estimate{theta[i], std::sqrt(std::max(0.0, covariance(i, i)) + more)}; };
  fit->feet.resize(layout.feet);
  for (size_t f = 0; f < layout.feet; ++f) {
    for (int a = 0; a < kAxes; ++a) {
      const Eigen::Index at = layout.first(f, a);
      BushParameters& out = fit->feet[f][static_cast<size_t>(a)];
      out.K = get(at, 0.0);
      out.C = get(at + 1, 0.0);
      out.O = get(at + 2, calc_zero_variance(zeros[f], arms[f], a));
      if (layout.each > 3) out.cubic = get(at + 3, 0.0);
    }
  }
  for (int i = 0; i < kBiases; ++i) {
    fit->accelerometer_bias[i] = theta[layout.biases() + i];
    fit->accelerometer_bias_std[i] = get(layout.biases() + i, 0.0).std;
  }
}

}  // namespace

bool has_slipped(const MotionTrack& track) { return track.slip > kSlipDistance || track.turn > kSlipTurn; }

BushFit fit_bush(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                 const std::vector<Vector3d>& arms, const FitOptions& options) {
  if (tracks.empty()) throw std::runtime_error("no motion to identify from");
  const Layout layout{tracks[0].feet.size(), options.law == BushLaw::kHardening ? 4 : 3};
  BushFit fit;
  fit.law = options.law;
  Vector theta = Vector::Zero(layout.size());
  std::vector<double> weight(layout.feet * kAxes, 1.0);
  std::vector<Eigen::Index> held;
  Normal normal;
  for (int round = 0; round < kRounds; ++round) {
    normal = sum_up(tracks, layout, theta, weight);
    if (*std::min_element(normal.count.begin(), normal.count.end()) < 50) {
      throw std::runtime_error("a foot never carries load without slipping: nothing can be identified");
    }
    subtract_noise(options, layout, weight, &normal);
    add_prior(layout, &normal);
    theta = solve_constrained(normal, layout, &held);
    if (!theta.allFinite()) throw std::runtime_error("the motions do not tell the parameters");
    weight = calc_weights(tracks, layout, theta, &fit.residual);
  }
  normal = sum_up(tracks, layout, theta, weight);
  fit.condition = calc_condition(normal, layout);
  subtract_noise(options, layout, weight, &normal);
  add_prior(layout, &normal);
  fill_result(theta, calc_covariance(tracks, layout, theta, weight, normal, options.error_memory), layout, zeros, arms, &fit);
  name_held(held, layout, &fit);
  return fit;
}

Eigen::VectorXd predict_torque(const BushFit& fit, const MotionTrack& track, size_t foot, int axis) {
  const BushTrack& t = track.feet[foot];
  const BushParameters& p = fit.feet[foot][static_cast<size_t>(axis)];
  const Vector angle = t.angle[axis] - t.bias_gain[axis].leftCols<kBiases>() * fit.accelerometer_bias.head<kBiases>();
  return (p.K.value * angle + p.cubic.value * angle.array().cube().matrix() + p.C.value * t.rate[axis]).array() + p.O.value;  // [M14 eq. 4]
}

std::vector<std::array<Eigen::Matrix2d, kAxes>> calc_angle_noise(const MotionTrack& resting) {
  std::vector<std::array<Eigen::Matrix2d, kAxes>> noise(resting.feet.size());
  for (size_t f = 0; f < noise.size(); ++f) {
    for (int a = 0; a < kAxes; ++a) {
      Matrix values(resting.time.size(), 2);
      values << resting.feet[f].angle[a], resting.feet[f].rate[a];
      values.rowwise() -= values.colwise().mean().eval();
      noise[f][static_cast<size_t>(a)] = values.transpose() * values / static_cast<double>(values.rows() - 1);
    }
  }
  return noise;
}

std::vector<ValidationError> validate(const BushFit& fit, const std::vector<MotionTrack>& tracks) {
  std::vector<ValidationError> errors;
  for (const MotionTrack& track : tracks) {
    for (size_t f = 0; f < track.feet.size(); ++f) {
      if (!track.loaded[f]) continue;
      for (int a = 0; a < kAxes; ++a) {
        const Vector& torque = track.feet[f].torque[a];
        errors.push_back({track.name, f, a, (torque - predict_torque(fit, track, f, a)).cwiseAbs().mean(), torque.cwiseAbs().maxCoeff()});
      }
    }
  }
  return errors;
}

LawChoice choose_law(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                     const std::vector<Vector3d>& arms) {
  LawChoice choice;
  for (BushLaw law : {BushLaw::kLinear, BushLaw::kHardening}) {
    FitOptions options;
    options.law = law;
    double sum = 0.0, count = 0.0;
    for (size_t out = 0; out < tracks.size(); ++out) {
      std::vector<MotionTrack> others = tracks;
      others.erase(others.begin() + static_cast<long>(out));
      if (others.empty() || has_slipped(tracks[out])) continue;
      const BushFit fit = fit_bush(others, zeros, arms, options);
      for (size_t f = 0; f < tracks[out].feet.size(); ++f) {
        if (!tracks[out].loaded[f]) continue;
        for (int a = 0; a < kAxes; ++a) {
          sum += (tracks[out].feet[f].torque[a] - predict_torque(fit, tracks[out], f, a)).squaredNorm();
          count += static_cast<double>(tracks[out].time.size());
        }
      }
    }
    (law == BushLaw::kLinear ? choice.linear_error : choice.hardening_error) = std::sqrt(sum / std::max(1.0, count));
  }
  FitOptions options;
  options.law = BushLaw::kHardening;
  for (const auto& foot : fit_bush(tracks, zeros, arms, options).feet) {
    for (const BushParameters& p : foot) {
      if (p.cubic.std > 0.0) choice.significance = std::max(choice.significance, p.cubic.value / p.cubic.std);
    }
  }
  if (choice.hardening_error < 0.9 * choice.linear_error && choice.significance > 4.0) choice.law = BushLaw::kHardening;
  return choice;
}

std::vector<Estimate> fit_vertical_compliance(const std::vector<MotionTrack>& tracks) {
  Matrix A = Matrix::Zero(2, 2);
  Vector b = Vector::Zero(2);
  double square = 0.0, count = 0.0;
  for (const MotionTrack& track : tracks) {
    if (track.slide.size() == 0 || has_slipped(track)) continue;
    Matrix X(track.slide.size(), 2);
    X << track.feet[0].load, -track.feet[1].load;
    X.rowwise() -= X.colwise().mean().eval();
    A += X.transpose() * X;
    b += X.transpose() * track.slide;
    square += track.slide.squaredNorm();
    count += static_cast<double>(track.slide.size());
  }
  if (count < 50) return {};
  const Vector c = A.ldlt().solve(b);
  // Residuals are alike over about a second: one independent sample in fifty.
  const Matrix covariance = A.inverse() * std::max(0.0, square - b.dot(c)) / count * 50.0;
  return {{c[0], std::sqrt(covariance(0, 0))}, {c[1], std::sqrt(covariance(1, 1))}};
}

}  // namespace hrp::identification
