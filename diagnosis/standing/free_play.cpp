// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/free_play.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/data/noise.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/standing/channels.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kRidge = 1e-6;

// Constants of the positions if every free sample is at its best place. A free sample counts only by the part of its
// equations that no offset changes. The ridge makes the mean of the offsets zero where a constant and a common offset
// cannot be distinguished.
Eigen::VectorXd find_means(const Eigen::MatrixXd& at, const Eigen::MatrixXd& slope, long places,
                           const std::vector<double>& offset, const std::vector<char>& fixed) {
  const long n = at.rows() - places;
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n) * (kRidge * static_cast<double>(at.cols()));
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (long k = 0; k < at.cols(); ++k) {
    const auto i = static_cast<size_t>(k);
    const Eigen::VectorXd s = slope.col(k);
    const double square = s.squaredNorm();
    if (fixed[i]) {
      A.diagonal().array() += 1;
      b += (at.col(k) + s * offset[i]).tail(n);
    } else if (square > 0) {
      A += Eigen::MatrixXd::Identity(n, n) - s.tail(n) * s.tail(n).transpose() / square;
      b += (at.col(k) - s * (s.dot(at.col(k)) / square)).tail(n);
    }
  }
  return A.ldlt().solve(b);
}

std::vector<double> list_torques(const StandBase& base, size_t joint, size_t joints) {
  std::vector<double> out;
  for (size_t at = joint; at < base.states.size(); at += joints) out.push_back(base.states[at].torque);
  return out;
}

}  // namespace

std::vector<double> find_slack(const StandProblem& problem, const std::vector<StandBase>& nominal) {
  const size_t joints = problem.effort.size();
  std::vector<double> out;
  for (size_t j = 0; j < joints; ++j) {
    std::vector<double> found;
    for (const StandBase& base : nominal) found.push_back(estimate_noise(list_torques(base, j, joints)));
    out.push_back(kOutlier * find_median(std::move(found)));
  }
  return out;
}

std::vector<int> find_sides(const std::vector<double>& torque, double slack) {
  const size_t n = torque.size();
  const auto side = [&](size_t k) { return std::abs(torque[k]) > slack ? (torque[k] > 0 ? 1 : -1) : 0; };
  std::vector<int> out(n, 0);
  for (size_t k = 0; k < n; ++k) {
    const size_t before = k > 0 ? k - 1 : k, after = std::min(n - 1, k + 1);
    if (side(before) == side(k) && side(after) == side(k)) out[k] = side(k);
  }
  return out;
}

bool may_be_play(const StandProblem& problem, const std::vector<StandBase>& evaluation, size_t joint, double offset) {
  const int own = offset > 0 ? 1 : -1;
  for (const StandBase& base : evaluation) {
    const std::vector<double> torque = list_torques(base, joint, problem.effort.size());
    const std::vector<int> sides = find_sides(torque, problem.slack[joint]);
    const auto count = [&](int side) { return std::count(sides.begin(), sides.end(), side); };
    if (count(own) == 0 || count(-own) > 0) return false;
  }
  return true;
}

std::vector<double> place_within_play(const PlayRows& rows, const std::vector<double>& noise,
                                      const std::vector<int>& sides, double gap) {
  const size_t n = sides.size();
  const auto size = static_cast<long>(rows.geometry), places = static_cast<long>(rows.places);
  Eigen::MatrixXd at(size, static_cast<long>(n)), slope(size, static_cast<long>(n));  // in units of noise
  for (size_t k = 0; k < n; ++k) {
    for (size_t c = 0; c < rows.geometry; ++c) {
      const size_t i = k * rows.channels + c;
      const bool says = rows.middle[i] != 0 && rows.aside[i] != 0;  // a foot on its edge says nothing
      at(static_cast<long>(c), static_cast<long>(k)) = says ? rows.middle[i] / noise[c] : 0;
      slope(static_cast<long>(c), static_cast<long>(k)) =
          says ? (rows.aside[i] - rows.middle[i]) / (kSlopeStep * noise[c]) : 0;
    }
  }
  for (long c = places; c < size; ++c) at.row(c).array() -= at.row(c).mean();
  std::vector<double> offset(n);
  std::vector<char> fixed(n);
  for (size_t k = 0; k < n; ++k) {
    offset[k] = 0.5 * gap * sides[k];
    fixed[k] = sides[k] != 0;
  }
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(size);
  // Finds which samples are at an end of the gap.
  for (int round = 0; round < kFewRounds; ++round) {
    mean.tail(size - places) = find_means(at, slope, places, offset, fixed);
    for (size_t k = 0; k < n; ++k) {
      const auto i = static_cast<long>(k);
      const double a = slope.col(i).squaredNorm();
      if (sides[k] != 0 || a == 0) continue;
      const double free = -slope.col(i).dot(at.col(i) - mean) / a;
      offset[k] = std::clamp(free, -0.5 * gap, 0.5 * gap);
      fixed[k] = offset[k] != free;
    }
  }
  return offset;
}

}  // namespace hrp::diagnosis::standing
