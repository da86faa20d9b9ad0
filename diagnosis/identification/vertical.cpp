// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/vertical.h"

#include <algorithm>
#include <cmath>

namespace hrp::identification {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr int kParameters = 4;                            // s, s T, scale error and delay of the accelerometer
constexpr double kScalePrior = 0.01, kDelayPrior = 5e-3;  // [1], [s]
constexpr int kRounds = 4;                                // T^2 terms from the last round
// [s] force sensor, encoders and accelerometer are not read at one instant: without noise cz / kz comes out 0.2 ms
// high.
constexpr double kClockFloor = 2e-4;
constexpr double kMemory = 0.5;        // [s] over which residuals are alike: encoder noise, differentiated
constexpr double kSignificance = 4.0;  // standard deviations

using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Covariance = Eigen::Matrix<double, kParameters, kParameters>;

// Rows of one foot and motion: slide'' = s L2 - s T L3 + s T^2 L4 - (scale error) a + (delay) a' + constant (what is
// left of the accelerometer's bias). Zero where the foot does not stand. Returns the number of the others.
double make_vertical_rows(const BushTrack& t, const Mask& stands, double squared, Matrix* X, Vector* y) {
  X->resize(t.load.size(), kParameters);
  *X << t.load_derivative[0], -t.load_derivative[1], -t.rise, t.rise_rate;
  *y = t.slide_acceleration - squared * t.load_derivative[2];
  const Vector usable = stands.cast<double>();
  const double count = usable.sum();
  if (!(count > 0.0)) return 0.0;
  X->rowwise() -= usable.transpose() * *X / count;
  y->array() -= usable.dot(*y) / count;
  *X = usable.asDiagonal() * *X;
  *y = usable.cwiseProduct(*y);
  return count;
}

// Of one foot: parameters of the rows (make_vertical_rows), and their covariance.
struct FootFit {
  Parameters theta = Parameters::Zero();
  Covariance covariance = Covariance::Zero();
};

// Normal equations of one foot over all tracks, and the scores of blocks of `last`.
struct VerticalSums {
  Covariance A = Covariance::Zero(), S = Covariance::Zero();
  Parameters b = Parameters::Zero();
  double squares = 0.0, count = 0.0;
};

VerticalSums sum_vertical(const std::vector<MotionTrack>& tracks, size_t foot, double squared, const Parameters& last) {
  VerticalSums sums;
  Matrix X;
  Vector y;
  for (const MotionTrack& track : tracks) {
    const double rows = make_vertical_rows(track.feet[foot], track.stands[foot], squared, &X, &y);
    if (!(rows > 0.0)) continue;
    sums.A += X.transpose() * X;
    sums.b += X.transpose() * y;
    const auto block = static_cast<Eigen::Index>(std::lround(kMemory / track.period));
    const Vector e = y - X * last;
    sums.squares += e.squaredNorm();
    sums.count += rows;
    for (Eigen::Index first = 0; first < e.size(); first += block) {
      const Eigen::Index size = std::min(block, e.size() - first);
      const Parameters score = X.middleRows(first, size).transpose() * e.segment(first, size);
      sums.S += score * score.transpose();
    }
  }
  return sums;
}

// One round of the fit: s T^2 is taken from the last one, as (s T)^2 / s. False without rows.
bool refine(const std::vector<MotionTrack>& tracks, const std::optional<MotionTrack>& hanging, size_t foot,
            FootFit* fit) {
  const Parameters last = fit->theta;
  const double squared = last[0] > 0.0 ? last[1] * last[1] / last[0] : 0.0;
  VerticalSums sums = sum_vertical(tracks, foot, squared, last);
  if (!(sums.count > 0.0)) return false;
  if (hanging) {  // at 0.3 N of noise in the force 2 % of the stiffness
    Matrix X;
    Vector y;
    const Mask all = Mask::Constant(hanging->time.size(), true);
    const double share = sums.count / make_vertical_rows(hanging->feet[foot], all, squared, &X, &y);
    sums.A -= share * X.transpose() * X;
    sums.b -= share * X.transpose() * y;
  }
  const double variance = sums.squares / sums.count;
  sums.A(2, 2) += variance / (kScalePrior * kScalePrior);
  sums.A(3, 3) += variance / (kDelayPrior * kDelayPrior);
  const Parameters scale = sums.A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Covariance inverse =
      scale.asDiagonal() * (scale.asDiagonal() * sums.A * scale.asDiagonal()).inverse() * scale.asDiagonal();
  fit->theta = inverse * sums.b;
  fit->covariance = inverse * sums.S * inverse;
  return true;
}

// Adds one foot's stiffness and damping. False where its compliance does not differ from none.
bool add_foot(const FootFit& foot, VerticalFit* fit) {
  const Parameters& theta = foot.theta;
  if (!theta.allFinite()) return false;
  const Estimate s{theta[0], std::sqrt(foot.covariance(0, 0))};
  if (!(s.value > kSignificance * s.std)) return false;
  const double k = 1.0 / s.value, c = theta[1] / (s.value * s.value);
  // c = sT / s^2: by the gradient (-2 c / s, 1 / s^2).
  const Eigen::Vector2d gradient(-2.0 * c / s.value, 1.0 / (s.value * s.value));
  fit->compliance.push_back(s);
  fit->stiffness.push_back({k, s.std * k * k});
  const double variance = gradient.dot(foot.covariance.topLeftCorner<2, 2>() * gradient);
  fit->damping.push_back({c, std::sqrt(variance + std::pow(kClockFloor * k, 2))});
  return true;
}

}  // namespace

VerticalFit fit_vertical(const std::vector<MotionTrack>& tracks, const std::optional<MotionTrack>& hanging) {
  VerticalFit fit;
  const size_t feet = tracks.empty() ? 0 : tracks[0].feet.size();
  for (size_t f = 0; f < feet; ++f) {
    FootFit foot;
    for (int round = 0; round < kRounds; ++round) {
      if (!refine(tracks, hanging, f, &foot)) return {};
    }
    if (!add_foot(foot, &fit)) return {};
  }
  return fit;
}

Eigen::VectorXd calc_slide(const VerticalFit& fit, const MotionTrack& track, size_t foot) {
  return fit.compliance[foot].value * track.feet[foot].load;
}

}  // namespace hrp::identification
