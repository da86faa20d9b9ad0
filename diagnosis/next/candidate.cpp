// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/candidate.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/search/starts.h"

namespace hrp::diagnosis {
namespace {

using Residuals = std::vector<double>;

// An effect at a joint that leaves links where they are changes that joint's readings only.
bool is_local(const Effect& effect) { return find_joint(effect) >= 0 && !moves_link(effect); }

bool is_local(const Hypothesis& hypothesis) {
  return std::all_of(hypothesis.begin(), hypothesis.end(), [](const Effect& e) { return is_local(e); });
}

// Whitened residuals of one recording along its path.
bool calc_along(Problem problem, const Hypothesis& hypothesis, int recording, Residuals* residuals) {
  problem.view = {true, is_local(hypothesis) ? &problem.nominal_paths : nullptr, -1};
  return calc_residuals(problem, hypothesis, recording, residuals);
}

struct Slopes {
  Residuals at;
  std::vector<Residuals> columns;  // d prediction / d parameter, over the noise
};

bool calc_slopes(const Problem& problem, const Hypothesis& hypothesis, int recording, Slopes* slopes) {
  if (!calc_along(problem, hypothesis, recording, &slopes->at)) return false;
  for (const Move& move : list_moves(hypothesis)) {
    Residuals moved;
    if (!calc_along(problem, move.hypothesis, recording, &moved)) return false;
    for (size_t k = 0; k < moved.size(); ++k) moved[k] = (slopes->at[k] - moved[k]) / move.delta;
    slopes->columns.push_back(std::move(moved));
  }
  return true;
}

double dot(const Residuals& a, const Residuals& b) {
  double sum = 0.0;
  for (size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

Eigen::MatrixXd make_fisher(const Slopes& slopes) {
  const long p = static_cast<long>(slopes.columns.size());
  Eigen::MatrixXd F(p, p);
  for (long i = 0; i < p; ++i) {
    for (long j = 0; j <= i; ++j) F(i, j) = F(j, i) = dot(slopes.columns[static_cast<size_t>(i)], slopes.columns[static_cast<size_t>(j)]);
  }
  return F;
}

double count_judged(const Problem& problem, int recording) {
  const Recording& r = problem.experiment->recordings[static_cast<size_t>(recording)];
  double signals = 0.0;
  for (const JointColumns& joint : r.joints) {
    for (const auto& signal : joint.signal) signals += signal.empty() ? 0.0 : 1.0;
  }
  return signals * static_cast<double>(r.size() - problem.smooth[static_cast<size_t>(recording)].judged);
}

}  // namespace

Eigen::MatrixXd calc_fisher(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings, double discrepancy) {
  const long p = static_cast<long>(list_moves(hypothesis).size());
  Eigen::MatrixXd total = Eigen::MatrixXd::Zero(p, p);
  for (int r : recordings) {
    Slopes slopes;
    if (p == 0 || !calc_slopes(problem, hypothesis, r, &slopes)) continue;
    const double samples = static_cast<double>(problem.experiment->recordings[static_cast<size_t>(r)].size());
    total += make_fisher(slopes) * calc_information_factor(discrepancy, samples, kIndependent);
  }
  return total;
}

void compare(const Problem& problem, const Explanations& explanations, double rate, Candidate* candidate) {
  Slopes best;
  if (!calc_slopes(problem, explanations.list[0].hypothesis, 0, &best)) return;
  const double count = count_judged(problem, 0);
  candidate->comparisons.assign(explanations.list.size(), {});
  for (size_t i = 0; i < explanations.list.size(); ++i) {
    Slopes rival;
    if (i > 0 && !calc_slopes(problem, explanations.list[i].hypothesis, 0, &rival)) return;
    const Slopes& slopes = i == 0 ? best : rival;
    Residuals difference(best.at.size());
    for (size_t k = 0; k < difference.size(); ++k) difference[k] = slopes.at[k] - best.at[k];
    Comparison& c = candidate->comparisons[i];
    c.power = rate * dot(difference, difference), c.count = rate * count;
    c.fisher = rate * make_fisher(slopes);
    c.along.resize(static_cast<long>(slopes.columns.size()));
    for (size_t p = 0; p < slopes.columns.size(); ++p) c.along[static_cast<long>(p)] = rate * dot(slopes.columns[p], difference);
  }
  candidate->ok = true;
}

}  // namespace hrp::diagnosis
