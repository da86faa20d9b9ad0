// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/toss/strikes.h"

#include <algorithm>
#include <cmath>

#include "common/spatial/turn.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis::toss {
namespace {

constexpr size_t kFlight = 5;                  // poses of a flight; a quadratic leaves two to check the fit
constexpr double kImpactSpeed = 0.3;           // [m/s] weaker impacts change the motion too little
constexpr size_t kLeast = 8, kLeastRests = 4;  // least numbers of values for a median with an error

std::optional<Measured> find_median_with_error(const std::vector<double>& values, size_t least) {
  if (values.size() < least) return std::nullopt;
  // The standard error of a median of normal errors is sqrt(pi / 2) times that of a mean.
  const double std = find_deviation_about_median(values) * std::sqrt(M_PI_2 / static_cast<double>(values.size()));
  return Measured{find_median(values), std, values.size()};
}

// A short sequence of poses and its motion at sample `at`.
struct Stretch {
  bool flies = false;
  size_t at = 0;
  LocalMotion motion;
};

Stretch look_at(const TossProblem& problem, const Toss& toss, size_t begin, size_t at) {
  Stretch stretch{false, at, calc_local_motion(problem, toss, begin, begin + kFlight, at)};
  const Vector3d& g = problem.nominal.gravity_W;
  stretch.flies = stretch.motion.misfit < kOutlier && (stretch.motion.a - g).norm() < kMinority * g.norm();
  return stretch;
}

// State of the body `dt` after the pose of a stretch, in free flight.
struct Body {
  Transform X_WB;
  Vector3d p_WBcm, v_WBcm, w_WB;
};

Body fly_on(const TossProblem& problem, const Toss& toss, const Stretch& stretch, double dt) {
  const LocalMotion& m = stretch.motion;
  Body body;
  const Matrix3d R = make_turn(dt * (m.w + 0.5 * dt * m.alpha)) * toss.R[stretch.at].toRotationMatrix();
  const Vector3d p_BBcm_W = R * problem.nominal.body.links[0].inertia.p_LLcm_L;
  body.X_WB = {R, toss.p[stretch.at] + dt * m.v + 0.5 * dt * dt * m.a};
  body.w_WB = m.w + dt * m.alpha;
  body.p_WBcm = body.X_WB.p + p_BBcm_W;
  body.v_WBcm = m.v + dt * m.a + body.w_WB.cross(p_BBcm_W);
  return body;
}

// Index of the lowest point if no other point is nearly as low. Otherwise the impulse may act at several points.
std::optional<size_t> find_lone_point(const TossProblem& problem, const Body& body) {
  const std::vector<Vector3d> points = list_lowest_points(problem, body.X_WB);
  size_t lowest = 0;
  double size = 0.0, next = 1e300;
  for (size_t i = 0; i < points.size(); ++i) {
    size = std::max(size, (points[i] - body.X_WB.p).norm());
    if (points[i].z() < points[lowest].z()) lowest = i;
  }
  for (size_t i = 0; i < points.size(); ++i) {
    if (i != lowest) next = std::min(next, points[i].z() - points[lowest].z());
  }
  if (points.size() < 2 || next < kDetail * size) return std::nullopt;
  return lowest;
}

// Finds the impact between the last pose of one flight and the first of the next: the time at which both predict the
// same height of the point.
std::optional<Strike> find_strike(const TossProblem& problem, size_t toss, const Stretch& before,
                                  const Stretch& after) {
  const Toss& t = problem.tosses[toss];
  const double gap = t.time[after.at] - t.time[before.at];
  const auto point = find_lone_point(problem, fly_on(problem, t, before, 0.5 * gap));
  if (!point) return std::nullopt;
  const auto get_height = [&](const Stretch& s, double dt) {
    return list_lowest_points(problem, fly_on(problem, t, s, dt).X_WB)[*point].z();
  };
  double low = 0.0, high = gap;
  for (int i = 0; i < 20; ++i) {  // to a millionth of the gap
    const double middle = 0.5 * (low + high);
    (get_height(before, middle) > get_height(after, middle - gap) ? low : high) = middle;
  }
  const Body a = fly_on(problem, t, before, low), b = fly_on(problem, t, after, low - gap);
  Strike strike;
  strike.toss = toss;
  strike.p_BcmC_W = list_lowest_points(problem, a.X_WB)[*point] - a.p_WBcm;
  strike.dv_WBcm = b.v_WBcm - a.v_WBcm;
  strike.dw_WB = b.w_WB - a.w_WB;
  strike.I_BBcm_W = a.X_WB.R * problem.nominal.body.links[0].inertia.I_LLcm_L * a.X_WB.R.transpose();
  if (strike.dv_WBcm.dot(-problem.nominal.gravity_W.normalized()) < kImpactSpeed) return std::nullopt;
  return strike;
}

}  // namespace

std::vector<Strike> find_strikes(const TossProblem& problem) {
  std::vector<Strike> strikes;
  for (size_t i = 0; i < problem.tosses.size(); ++i) {
    const Toss& toss = problem.tosses[i];
    for (size_t end = kFlight; end + kFlight < toss.p.size(); ++end) {  // first pose that may be in the impact
      const Stretch before = look_at(problem, toss, end - kFlight, end - 1);
      std::optional<Strike> strike;
      for (size_t begin = end; before.flies && !strike && begin < end + 2 && begin + kFlight <= toss.p.size();
           ++begin) {
        const Stretch after = look_at(problem, toss, begin, begin);
        if (after.flies) strike = find_strike(problem, i, before, after);
      }
      if (strike) {
        strikes.push_back(*strike);
        end += kFlight - 1;
      }
    }
  }
  return strikes;
}

std::optional<Measured> measure_fall(const TossProblem& problem) {
  std::vector<double> values;
  const double g = problem.nominal.gravity_W.norm();
  for (const Toss& toss : problem.tosses) {
    // The longest free fall from the start of a toss. A longer one would contain the end of the flight.
    size_t count = 0;
    LocalMotion fall;
    for (size_t n = 2 * kFlight; n <= toss.p.size(); ++n) {
      const LocalMotion m = calc_local_motion(problem, toss, 0, n, 0);
      if (m.misfit > kOutlier || (m.a - problem.nominal.gravity_W).norm() > kMinority * g) break;
      count = n;
      fall = m;
    }
    if (count > 0) values.push_back(fall.a.dot(problem.nominal.gravity_W) / (g * g));
  }
  return find_median_with_error(values, kLeast);
}

std::optional<Measured> measure_inertia(const TossProblem& problem) {
  std::vector<double> values;
  const double mass = problem.nominal.body.links[0].inertia.mass;
  for (const Strike& s : find_strikes(problem)) {
    const Vector3d moment = mass * s.p_BcmC_W.cross(s.dv_WBcm), turned = s.I_BBcm_W * s.dw_WB;
    values.push_back(moment.dot(turned) / turned.squaredNorm());
  }
  return find_median_with_error(values, kLeast);
}

std::optional<Measured> measure_rest_height(const TossProblem& problem) {
  return find_median_with_error(problem.rest_heights, kLeastRests);
}

}  // namespace hrp::diagnosis::toss
