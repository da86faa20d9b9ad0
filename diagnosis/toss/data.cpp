// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/toss/data.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/quantile.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/toss/strikes.h"

namespace hrp::diagnosis::toss {
namespace {

// [s] Length of a window: it shows about half of the motion before and after an impact, but not the chaos after many
// impacts.
constexpr double kHorizon = 0.06;    // [s]
constexpr size_t kLeastSamples = 8;  // per window: 6 values per sample, 12 unknowns of the start state
// A twist counts as derived from the poses if it differs from their difference quotient by less than this fraction of
// the quotient's own noise.
constexpr double kDerived = 0.65;

bool read_three(const Recording& recording, const std::string& base, std::vector<double> out[3]) {
  const char* const axes[] = {"/x", "/y", "/z"};
  for (int i = 0; i < 3; ++i) {
    const auto at = recording.other.find(base + axes[i]);
    if (at == recording.other.end()) return false;
    out[i] = at->second;
  }
  return true;
}

bool read_toss(const Recording& recording, Toss* toss) {
  toss->file = recording.spec.name;
  toss->train = recording.spec.train;
  std::vector<double> p[3], q[3], v[3], w[3];
  const auto real = recording.other.find("/base/pose/orientation/w");
  if (!read_three(recording, "/base/pose/position", p) || !read_three(recording, "/base/pose/orientation", q))
    return false;
  if (real == recording.other.end()) return false;
  const bool linear = read_three(recording, "/base/twist/linear", v),
             angular = read_three(recording, "/base/twist/angular", w);
  for (size_t k = 0; k < recording.size(); ++k) {
    Eigen::Quaterniond R(real->second[k], q[0][k], q[1][k], q[2][k]);
    const Vector3d at(p[0][k], p[1][k], p[2][k]);
    if (!at.allFinite() || !R.coeffs().allFinite() || R.norm() < 0.5) continue;
    R.normalize();
    toss->time.push_back(recording.time[k]);
    toss->p.push_back(at);
    toss->R.push_back(R);
    if (linear) toss->v.emplace_back(v[0][k], v[1][k], v[2][k]);
    if (angular) toss->w.emplace_back(w[0][k], w[1][k], w[2][k]);
  }
  return toss->time.size() >= kLeastSamples;
}

// Rms residual [m], [rad] of cubics fitted to the positions and rotations of one window.
void calc_roughness(const Toss& toss, const Window& window, double* p, double* R) {
  const auto n = static_cast<long>(window.count);
  const size_t centre = window.first + window.count / 2;
  Eigen::MatrixXd A(n, 4), y(n, 6);
  for (long i = 0; i < n; ++i) {
    const size_t k = window.first + static_cast<size_t>(i);
    const double t = (toss.time[k] - toss.time[centre]) / (toss.time[centre] - toss.time[window.first]);
    A.row(i) << 1.0, t, t * t, t * t * t;
    y.row(i) << (toss.p[k] - toss.p[centre]).transpose(), calc_turn(toss.R[centre], toss.R[k]).transpose();
  }
  const Eigen::MatrixXd N = A.transpose() * A, x = N.ldlt().solve(A.transpose() * y), left = y - A * x;
  const double degrees = static_cast<double>(3 * (n - 4));
  *p = std::sqrt(left.leftCols<3>().squaredNorm() / degrees);
  *R = std::sqrt(left.rightCols<3>().squaredNorm() / degrees);
}

// Noise of positions and attitudes: median over the windows of the residual of cubics. Most windows contain no impact.
void find_noise(const Experiment& e, TossProblem* problem) {
  std::vector<double> p, R;
  for (const Window& window : problem->windows) {
    p.push_back(0.0);
    R.push_back(0.0);
    calc_roughness(problem->tosses[window.toss], window, &p.back(), &R.back());
  }
  problem->sigma_p = find_median(p);
  problem->sigma_R = find_median(R);
  double stated = 0.0;
  for (const char* axis : {"/x", "/y", "/z"}) {
    const auto at = e.other_noise.find(std::string("/base/pose/position") + axis);
    if (at != e.other_noise.end() && at->second.stated) stated = std::max(stated, at->second.sigma);
  }
  if (stated > 0.0) {
    problem->sigma_p = stated;
    problem->stated = true;
  }
  problem->sigma_p = std::max(problem->sigma_p, 1e-6);
  problem->sigma_R = std::max(problem->sigma_R, 1e-5);
}

// Plane through the lowest points of a body at rest, as the tracker measures it: height [m] above the model's ground
// and slopes [1].
struct RestPlane {
  bool ok = false;
  double height = 0.0, slope_x = 0.0, slope_y = 0.0;
};

RestPlane find_rest_plane(const TossProblem& problem, const Toss& toss) {
  RestPlane out;
  const size_t n = toss.p.size(), from = n - std::min(n, kLeastSamples);
  if ((toss.p[n - 1] - toss.p[from]).norm() > 6.0 * problem.sigma_p) return out;
  const Transform X{toss.R[n - 1].toRotationMatrix(), toss.p[n - 1]};
  const std::vector<Vector3d> points = list_lowest_points(problem, X);
  // A face that lies flat is tilted by the tracker's error only, so points within a tenth of the body's size belong to
  // it.
  double size = 0.0, lowest = 1e300;
  for (const Vector3d& p : points) {
    size = std::max(size, (p - X.p).norm());
    lowest = std::min(lowest, p.z());
  }
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  int count = 0;
  for (const Vector3d& p : points) {
    if (p.z() > lowest + 0.1 * size) continue;
    const Vector3d row(1.0, p.x() - X.p.x(), p.y() - X.p.y());
    A += row * row.transpose();
    b += row * p.z();
    ++count;
  }
  if (count < 3 || A.determinant() < 1e-3 * std::pow(size, 4)) return out;
  const Vector3d x = A.ldlt().solve(b);
  const GroundPlane ground = make_ground_plane(problem.nominal.ground);
  const double modelled = (ground.offset - ground.n_W.x() * X.p.x() - ground.n_W.y() * X.p.y()) / ground.n_W.z();
  return {true, x[0] - modelled, x[1], x[2]};
}

// Spread of height and tilt between tosses, from bodies at rest: tracker errors that are no white noise.
void find_slow_errors(TossProblem* problem) {
  std::vector<double> height, tilt;
  std::vector<RestPlane> planes;
  for (const Toss& toss : problem->tosses) {
    const RestPlane plane = find_rest_plane(*problem, toss);
    if (plane.ok) {
      planes.push_back(plane);
      problem->rest_heights.push_back(plane.height);
    }
  }
  problem->slow_p = problem->sigma_p;
  problem->slow_R = problem->sigma_R;
  if (planes.size() < 4) return;
  const auto spread = [&](double RestPlane::*field) {
    std::vector<double> values;
    for (const RestPlane& p : planes) values.push_back(p.*field);
    return find_deviation_about_median(std::move(values));
  };
  problem->slow_p = std::max(problem->sigma_p, spread(&RestPlane::height));
  problem->slow_R = std::max(problem->sigma_R, 0.5 * (spread(&RestPlane::slope_x) + spread(&RestPlane::slope_y)));
}

// Smallest median distance of a twist, in the axes of the body or of the world, from a difference quotient of the
// poses, in units of its noise.
double calc_distance_from_quotients(const TossProblem& problem, bool angular) {
  std::vector<double> quotient[3];
  const double sigma = (angular ? problem.sigma_R : problem.sigma_p) * std::sqrt(2.0);
  for (const Toss& t : problem.tosses) {
    const std::vector<Vector3d>& read = angular ? t.w : t.v;
    for (size_t k = 1; k + 1 < t.p.size(); ++k) {
      if (!read[k].allFinite()) continue;
      const auto rate = [&](size_t a, size_t b) -> Vector3d {
        const double dt = t.time[b] - t.time[a];
        return angular ? Vector3d(calc_turn(t.R[a], t.R[b]) / dt) : Vector3d((t.p[b] - t.p[a]) / dt);
      };
      const Vector3d turned = t.R[k] * read[k];
      const size_t ends[3][2] = {{k - 1, k}, {k - 1, k + 1}, {k, k + 1}};
      for (int i = 0; i < 3; ++i) {
        const Vector3d d = rate(ends[i][0], ends[i][1]);
        const double scale = sigma / (t.time[ends[i][1]] - t.time[ends[i][0]]);
        quotient[i].push_back(std::min((read[k] - d).norm(), (turned - d).norm()) / scale);
      }
    }
  }
  return std::min({find_median(quotient[0]), find_median(quotient[1]), find_median(quotient[2])});
}

void judge_twist(TossProblem* problem) {
  for (const bool angular : {false, true}) {
    bool everywhere = true;
    for (const Toss& t : problem->tosses) everywhere = everywhere && !(angular ? t.w : t.v).empty();
    if (!everywhere) continue;
    const std::string name = angular ? "/base/twist/angular" : "/base/twist/linear";
    // 1.54 is the median length of a vector of three unit normal errors.
    const bool own = calc_distance_from_quotients(*problem, angular) > kDerived * 1.54;
    (angular ? problem->has_angular : problem->has_linear) = own;
    if (!own) {
      problem->notes.push_back(
          name +
          " repeats the difference quotient of the recorded poses: it is no measurement of its own "
          "and was left out");
    }
  }
}

// Consecutive windows from the start of each toss.
std::vector<Window> cut_windows(const TossProblem& problem) {
  std::vector<Window> windows;
  const double dt = problem.experiment->sample_time;
  const auto count = std::max(kLeastSamples, static_cast<size_t>(std::lround(kHorizon / dt)));
  for (size_t i = 0; i < problem.tosses.size(); ++i) {
    const Toss& t = problem.tosses[i];
    for (size_t first = 0; first + kLeastSamples <= t.p.size(); first += count) {
      const size_t n = std::min(count, t.p.size() - first);
      const double span = t.time[first + n - 1] - t.time[first];
      if (span < 2.0 * dt * static_cast<double>(n)) windows.push_back({i, first, n});  // else samples are missing
    }
  }
  return windows;
}

void note_unused(TossProblem* problem) {
  std::vector<char> used(problem->tosses.size(), 0);
  for (const Window& w : problem->windows) used[w.toss] = 1;
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i])
      problem->notes.push_back(problem->tosses[i].file + ": not used, as it has no " + std::to_string(kLeastSamples) +
                               " poses in a row without a gap");
  }
}

// Keeps only the first window at rest of each toss; further ones repeat it.
void drop_rest(TossProblem* problem) {
  std::vector<Window> kept;
  bool rested = false;
  for (const Window& w : problem->windows) {
    const Toss& t = problem->tosses[w.toss];
    const size_t last = w.first + w.count - 1;
    const bool rests = (t.p[last] - t.p[w.first]).norm() < 6.0 * problem->sigma_p &&
                       calc_turn(t.R[w.first], t.R[last]).norm() < 6.0 * problem->sigma_R;
    if (!rests || !rested || kept.back().toss != w.toss) kept.push_back(w);
    rested = rests;
    problem->horizon = std::max(problem->horizon, t.time[last] - t.time[w.first]);
  }
  problem->windows = kept;
}

}  // namespace

std::vector<Vector3d> list_lowest_points(const TossProblem& problem, const Transform& X_WB) {
  std::vector<Vector3d> points;
  for (const Sole& sole : problem.soles) {
    for (const SolePoint& q : sole.points) points.push_back(X_WB * q.p_LQ - Vector3d(0, 0, q.radius));
  }
  return points;
}

Vector3d calc_turn(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  Eigen::Quaterniond d = to * from.conjugate();
  if (d.w() < 0.0) d.coeffs() *= -1.0;
  const double s = d.vec().norm();
  return s < 1e-12 ? Vector3d(2.0 * d.vec()) : Vector3d(2.0 * std::atan2(s, d.w()) / s * d.vec());
}

LocalMotion calc_local_motion(const TossProblem& problem, const Toss& toss, size_t begin, size_t end, size_t at) {
  const auto n = static_cast<long>(end - begin);
  Eigen::MatrixXd A(n, 3), y(n, 6);
  for (long i = 0; i < n; ++i) {
    const size_t k = begin + static_cast<size_t>(i);
    const double t = toss.time[k] - toss.time[at];
    A.row(i) << 1.0, t, 0.5 * t * t;
    y.row(i) << (toss.p[k] - toss.p[at]).transpose() / problem.sigma_p,
        calc_turn(toss.R[at], toss.R[k]).transpose() / problem.sigma_R;
  }
  const Eigen::MatrixXd N = A.transpose() * A, x = N.ldlt().solve(A.transpose() * y);
  LocalMotion out;
  out.v = problem.sigma_p * x.block<1, 3>(1, 0).transpose();
  out.a = problem.sigma_p * x.block<1, 3>(2, 0).transpose();
  out.w = problem.sigma_R * x.block<1, 3>(1, 3).transpose(),
  out.alpha = problem.sigma_R * x.block<1, 3>(2, 3).transpose();
  out.misfit = n > 3 ? std::sqrt((y - A * x).squaredNorm() / static_cast<double>(6 * (n - 3))) : 0.0;
  return out;
}

bool make_toss_problem(const Experiment& e, TossProblem* problem, std::string* why) {
  problem->experiment = &e;
  if (!e.scenario.floating_base) {
    *why = "the base is fixed";
    return false;
  }
  if (e.num_joints() > 0) {
    *why = "the body has joints";
    return false;
  }
  if (!e.scenario.ground.present) {
    *why = "there is no ground";
    return false;
  }
  problem->soles = make_soles(e.robot);
  for (const Recording& recording : e.recordings) {
    Toss toss;
    if (!read_toss(recording, &toss)) {
      *why = recording.spec.name + " has no pose of the base (/base/pose/...)";
      return false;
    }
    problem->tosses.push_back(std::move(toss));
  }
  if (problem->soles.empty()) {
    *why = "no link that may touch the ground (`feet`) has a shape";
    return false;
  }
  World& w = problem->nominal;
  w.body = make_nominal(e).tree;
  w.ground = e.scenario.ground;
  w.gravity_W = e.scenario.gravity_W;
  w.restitution = e.scenario.contact.restitution;
  problem->windows = cut_windows(*problem);
  if (problem->windows.empty()) {
    *why = "no stretch is long enough";
    return false;
  }
  note_unused(problem);
  find_noise(e, problem);
  drop_rest(problem);
  find_slow_errors(problem);
  judge_twist(problem);
  problem->fall = measure_fall(*problem);
  problem->inertia = measure_inertia(*problem);
  problem->rest_height = measure_rest_height(*problem);
  return true;
}

}  // namespace hrp::diagnosis::toss
