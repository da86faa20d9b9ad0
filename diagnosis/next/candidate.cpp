// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/candidate.h"

#include <algorithm>

#include "diagnosis/search/starts.h"

namespace hrp::diagnosis {
namespace {

using Residuals = std::vector<double>;

// True for an effect at a joint that changes only the readings of that joint, because links follow their recorded
// paths.
bool is_local(const Effect& effect) { return find_joint(effect) >= 0 && !moves_link(effect); }

bool is_local(const Hypothesis& hypothesis) {
  return std::all_of(hypothesis.begin(), hypothesis.end(), [](const Effect& e) { return is_local(e); });
}

struct Slopes {
  Residuals at;
  std::vector<Residuals> columns;  // derivatives of the prediction, in units of noise
};

// Whitened residuals along the paths under one hypothesis, and their derivatives with respect to its parameters.
class Along {
 public:
  Along(const Problem& problem, const Hypothesis& hypothesis) : problem_(problem), hypothesis_(hypothesis) {
    problem_.jobs = 1;
    paths_ = is_local(hypothesis) ? problem_.nominal_paths : make_paths(problem_, hypothesis);
  }

  bool calc_slopes(int recording, Slopes* slopes) {
    problem_.view = {true, &paths_, -1};
    if (!calc_residuals(problem_, hypothesis_, recording, &slopes->at)) return false;
    for (const Move& move : list_moves(hypothesis_)) {
      Residuals moved;
      if (!calc_moved(move, recording, slopes->at, &moved)) return false;
      for (size_t k = 0; k < moved.size(); ++k) moved[k] = (slopes->at[k] - moved[k]) / move.delta;
      slopes->columns.push_back(std::move(moved));
    }
    return true;
  }

 private:
  // Residuals with one parameter changed. A law of a joint without an elastic or loose transmission changes that
  // joint's readings only. On robots with friction everywhere, nearly all effects are of this kind.
  bool calc_moved(const Move& move, int recording, const Residuals& at, Residuals* moved) {
    const int joint = find_joint(move.hypothesis[move.effect]);
    const bool alone = joint >= 0 && std::none_of(hypothesis_.begin(), hypothesis_.end(), [&](const Effect& e) {
                         return find_joint(e) == joint && moves_link(e);
                       });
    problem_.view = {true, alone ? &paths_ : nullptr, alone ? joint : -1};
    if (!alone) return calc_residuals(problem_, move.hypothesis, recording, moved);
    Residuals own;
    if (!calc_residuals(problem_, move.hypothesis, recording, &own)) return false;
    *moved = at;
    const size_t width = problem_.weights.size(), first = static_cast<size_t>(joint) * kQuantities;
    for (size_t k = 0; k < own.size(); ++k) (*moved)[k / kQuantities * width + first + k % kQuantities] = own[k];
    return true;
  }

  Problem problem_;
  const Hypothesis& hypothesis_;
  Paths paths_;
};

Eigen::MatrixXd make_fisher(const Slopes& slopes) {
  const long p = static_cast<long>(slopes.columns.size());
  Eigen::MatrixXd F(p, p);
  for (long i = 0; i < p; ++i) {
    for (long j = 0; j <= i; ++j)
      F(i, j) = F(j, i) = dot(slopes.columns[static_cast<size_t>(i)], slopes.columns[static_cast<size_t>(j)]);
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

Eigen::MatrixXd calc_fisher(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings,
                            double discrepancy) {
  const long p = static_cast<long>(list_moves(hypothesis).size());
  Eigen::MatrixXd total = Eigen::MatrixXd::Zero(p, p);
  if (p == 0) return total;
  Along along(problem, hypothesis);
  for (int r : recordings) {
    Slopes slopes;
    if (!along.calc_slopes(r, &slopes)) continue;
    const double samples = static_cast<double>(problem.experiment->recordings[static_cast<size_t>(r)].size());
    total += make_fisher(slopes) * calc_information_factor(discrepancy, samples, kIndependent);
  }
  return total;
}

void compare(const Problem& problem, const Explanations& explanations, double rate, MotionCandidate* candidate) {
  Slopes best;
  if (!Along(problem, explanations.list[0].hypothesis).calc_slopes(0, &best)) return;
  const double count = count_judged(problem, 0);
  candidate->comparisons.assign(explanations.list.size(), {});
  for (size_t i = 0; i < explanations.list.size(); ++i) {
    Slopes rival;
    if (i > 0 && !Along(problem, explanations.list[i].hypothesis).calc_slopes(0, &rival)) return;
    const Slopes& slopes = i == 0 ? best : rival;
    Residuals difference(best.at.size());
    for (size_t k = 0; k < difference.size(); ++k) difference[k] = slopes.at[k] - best.at[k];
    Comparison& c = candidate->comparisons[i];
    c.power = rate * dot(difference, difference);
    c.count = rate * count;
    c.fisher = rate * make_fisher(slopes);
    c.along.resize(static_cast<long>(slopes.columns.size()));
    for (size_t p = 0; p < slopes.columns.size(); ++p)
      c.along[static_cast<long>(p)] = rate * dot(slopes.columns[p], difference);
  }
  candidate->ok = true;
}

}  // namespace hrp::diagnosis
