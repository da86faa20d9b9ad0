// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/fit.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/robust.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr int kHalvings = 3;  // of a step that makes the fit worse: an eighth of it tells nothing

// Normal equations of columns and residuals of two sides; both sides are the same for plain least squares.
struct Normal {
  Eigen::MatrixXd A, B;
  Eigen::VectorXd b;
};

struct Side {
  const std::vector<Derivative>& columns;
  const Evaluation& base;
};

size_t count_rows(const StandProblem& problem, size_t recording) {
  return problem.recordings[recording].samples.size();
}

Normal gather(const StandProblem& problem, const FitSelection& selection, const Side& x, const Side& y) {
  const auto n = static_cast<long>(x.columns.size());
  const size_t channels = selection.weight.size();
  Normal normal{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  for (size_t r : selection.recordings) {
    const StandRecording& recording = problem.recordings[r];
    const size_t rows = count_rows(problem, r);
    const double span = recording.time[static_cast<size_t>(recording.samples.back())] -
                        recording.time[static_cast<size_t>(recording.samples.front())];
    const auto stretch = std::max<size_t>(1, static_cast<size_t>(kBlock * static_cast<double>(rows) / span));
    Eigen::VectorXd score = Eigen::VectorXd::Zero(n), a(n), b(n);
    for (size_t k = 0; k < rows; ++k) {
      for (size_t c = 0; c < channels; ++c) {
        const size_t at = k * channels + c;
        for (long i = 0; i < n; ++i) {
          a(i) = x.columns[static_cast<size_t>(i)][r][at] * selection.weight[c];
          b(i) = y.columns[static_cast<size_t>(i)][r][at] * selection.weight[c];
        }
        if (a.isZero(0) && b.isZero(0)) continue;
        normal.A.noalias() += 0.5 * (a * b.transpose() + b * a.transpose());
        score += 0.5 * selection.weight[c] * (a * y.base[r].residuals[at] + b * x.base[r].residuals[at]);
      }
      if ((k + 1) % stretch == 0 || k + 1 == rows) {
        normal.b += score;
        normal.B += score * score.transpose();
        score.setZero();
      }
    }
  }
  return normal;
}

void add_priors(const StandProblem& problem, const Hypothesis& hypothesis, Normal* normal) {
  long at = 0;
  for (const Effect& e : hypothesis) {
    const std::vector<double>& neutral = get_row(e).neutral;
    for (size_t i = 0; i < e.p.size(); ++i, ++at) {
      const double prior = find_prior(problem, e, i);
      if (prior == 0) continue;
      const double precision = 1 / (prior * prior);
      normal->A(at, at) += precision;
      normal->B(at, at) += precision;
      normal->b(at) += precision * (e.p[i] - neutral[i % neutral.size()]);
    }
  }
}

StandStep solve_normal(const Normal& normal) {
  const long n = normal.b.size();
  Eigen::VectorXd scale = normal.A.diagonal().cwiseMax(0).cwiseSqrt();
  for (long i = 0; i < n; ++i) scale(i) = scale(i) > 0 ? 1 / scale(i) : 0;
  Eigen::MatrixXd S = scale.asDiagonal() * normal.A * scale.asDiagonal();
  S.diagonal().array() += 1e-9;
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(S);
  StandStep step;
  step.delta = -(scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * normal.b));
  const Eigen::MatrixXd inverse = scale.asDiagonal() * ldlt.solve(Eigen::MatrixXd(scale.asDiagonal()));
  const RobustCovariance covariance = make_robust_covariance(inverse, normal.B);
  step.covariance = covariance.robust;
  for (long i = 0; i < n; ++i) step.covariance(i, i) = covariance.find_variance(i);
  step.ok = step.delta.allFinite() && step.covariance.allFinite();
  return step;
}

}  // namespace

Evaluation evaluate(const StandProblem& problem, const Hypothesis& hypothesis) {
  Evaluation out(problem.recordings.size());
  for (size_t r = 0; r < out.size(); ++r) calc_channels(problem, hypothesis, r, &out[r]);
  return out;
}

std::vector<Derivative> differentiate(const StandProblem& problem, const Hypothesis& hypothesis, size_t first,
                                      const Evaluation& base, const std::vector<size_t>& recordings) {
  std::vector<Derivative> columns;
  for (size_t e = first; e < hypothesis.size(); ++e) {
    const StandRow& row = get_row(hypothesis[e]);
    for (size_t i = 0; i < hypothesis[e].p.size(); ++i) {
      const double step = row.step[i % row.step.size()];
      Hypothesis moved = hypothesis;
      moved[e].p[i] += step;
      Derivative column(base.size());
      for (size_t r : recordings) {
        const std::vector<double>& at = base[r].residuals;
        if (step == 0) {
          column[r].assign(at.size(), 0.0);
          continue;
        }
        const bool drive = row.at_drive;
        column[r] = drive ? calc_drive_channels(problem, moved, r, base[r], hypothesis[e].place.index)
                          : calc_channels(problem, moved, r);
        for (size_t k = 0; k < at.size(); ++k) {
          const bool silent = column[r][k] == 0 || at[k] == 0;  // an equation that says nothing has no slope
          column[r][k] = silent ? 0 : (column[r][k] - at[k]) / step;
        }
      }
      columns.push_back(std::move(column));
    }
  }
  return columns;
}

namespace {

Eigen::VectorXd stack(const FitSelection& selection, const Derivative& column) {
  const size_t channels = selection.weight.size();
  size_t rows = 0;
  for (size_t r : selection.recordings) rows += column[r].size();
  Eigen::VectorXd out(static_cast<long>(rows));
  long at = 0;
  for (size_t r : selection.recordings) {
    for (size_t k = 0; k < column[r].size(); ++k) out(at++) = column[r][k] * selection.weight[k % channels];
  }
  return out;
}

Eigen::MatrixXd stack_all(const FitSelection& selection, const std::vector<Derivative>& columns, long rows) {
  Eigen::MatrixXd out(rows, static_cast<long>(columns.size()));
  for (size_t i = 0; i < columns.size(); ++i) out.col(static_cast<long>(i)) = stack(selection, columns[i]);
  return out;
}

}  // namespace

SharedColumns share_columns(const FitSelection& selection, std::vector<Derivative> columns, const Evaluation& base) {
  SharedColumns out;
  Derivative residuals;
  for (const StandBase& b : base) residuals.push_back(b.residuals);
  out.residual = stack(selection, residuals);
  out.weighted = stack_all(selection, columns, out.residual.size());
  out.columns = std::move(columns);
  return out;
}

Eigen::VectorXd solve_with(const StandProblem& problem, const FitSelection& selection, const Hypothesis& hypothesis,
                           const ColumnSide& x, const ColumnSide& y) {
  const auto join = [&](const ColumnSide& side) {
    const long rows = side.shared.residual.size(), n = side.shared.weighted.cols();
    Eigen::MatrixXd out(rows, n + static_cast<long>(side.added.size()));
    out << side.shared.weighted, stack_all(selection, side.added, rows);
    return out;
  };
  const Eigen::MatrixXd X = join(x), Y = join(y), XY = X.transpose() * Y;
  Normal normal{0.5 * (XY + XY.transpose()), Eigen::MatrixXd::Zero(X.cols(), X.cols()),
                0.5 * (X.transpose() * y.shared.residual + Y.transpose() * x.shared.residual)};
  add_priors(problem, hypothesis, &normal);
  return solve_normal(normal).delta;
}

StandStep solve(const StandProblem& problem, const FitSelection& selection, const Hypothesis& hypothesis,
                const std::vector<Derivative>& columns, const Evaluation& base) {
  const Side side{columns, base};
  Normal normal = gather(problem, selection, side, side);
  add_priors(problem, hypothesis, &normal);
  return solve_normal(normal);
}

namespace {

// Limits shape parameters, which a step may move too far if the data hardly determine them.
void keep_shapes(Hypothesis* hypothesis) {
  for (Effect& e : *hypothesis) {
    const size_t size = get_row(e).step.size();
    for (size_t at = 0; is_foot(e) && at < e.p.size(); at += size) {
      for (size_t damping : {at + 1, at + 3}) e.p[damping] = std::max(e.p[damping], 0.0);  // [s]
    }
    if (get_row(e).keep) get_row(e).keep(&e.p);
  }
}

}  // namespace

void add_step(const Eigen::VectorXd& delta, size_t first, Hypothesis* hypothesis) {
  long at = 0;
  for (size_t e = 0; e < hypothesis->size(); ++e) {
    for (double& p : (*hypothesis)[e].p) {
      if (e >= first) p += delta(at);
      ++at;
    }
  }
  keep_shapes(hypothesis);
}

namespace {

// Cost of a fit: weighted products of the residuals of two sides, plus the priors.
double calc_cost(const StandProblem& problem, const FitSelection& selection, const Hypothesis& h, const Evaluation& x,
                 const Evaluation& y) {
  double cost = 0;
  for (size_t r : selection.recordings) {
    const std::vector<double>&a = x[r].residuals, &b = y[r].residuals;
    const size_t channels = selection.weight.size();
    for (size_t k = 0; k < a.size(); ++k) cost += a[k] * b[k] * std::pow(selection.weight[k % channels], 2);
  }
  for (const Effect& e : h) {
    const std::vector<double>& neutral = get_row(e).neutral;
    for (size_t i = 0; i < e.p.size(); ++i) {
      const double prior = find_prior(problem, e, i);
      if (prior > 0) cost += std::pow((e.p[i] - neutral[i % neutral.size()]) / prior, 2);
    }
  }
  return cost;
}

// Takes a step, or a half, quarter or eighth of it if the full step increases the cost. Samples that alternately stick
// and slide can make full steps oscillate. `judge` evaluates a hypothesis and returns its cost.
template <class Judge>
Hypothesis take_step(const Hypothesis& from, const Eigen::VectorXd& delta, double cost, Judge judge) {
  Hypothesis h;
  double share = 1;
  for (int i = 0; i <= kHalvings; ++i, share /= 2) {
    h = from;
    add_step(share * delta, 0, &h);
    if (judge(h) <= cost) break;
  }
  return h;
}

}  // namespace

Hypothesis refine(const StandProblem& problem, const FitSelection& selection, Hypothesis hypothesis, int iterations) {
  Evaluation base = evaluate(problem, hypothesis);
  for (int i = 0; i < iterations; ++i) {
    const std::vector<Derivative> columns = differentiate(problem, hypothesis, 0, base, selection.recordings);
    const StandStep step = solve(problem, selection, hypothesis, columns, base);
    if (!step.ok) break;
    const double cost = calc_cost(problem, selection, hypothesis, base, base);
    hypothesis = take_step(hypothesis, step.delta, cost, [&](const Hypothesis& h) {
      base = evaluate(problem, h);
      return calc_cost(problem, selection, h, base, base);
    });
  }
  return hypothesis;
}

bool polish(const StandProblems& problems, const FitSelection& selection, int iterations, Hypothesis* hypothesis,
            Eigen::MatrixXd* covariance) {
  Hypothesis h = *hypothesis;
  Evaluation even = evaluate(problems.even, h), odd = evaluate(problems.odd, h);
  for (int i = 0; i <= iterations; ++i) {
    const std::vector<Derivative> by_even = differentiate(problems.even, h, 0, even, selection.recordings);
    const std::vector<Derivative> by_odd = differentiate(problems.odd, h, 0, odd, selection.recordings);
    Normal normal = gather(problems.all, selection, {by_even, even}, {by_odd, odd});
    add_priors(problems.all, h, &normal);
    const StandStep step = solve_normal(normal);
    if (!step.ok) return false;
    *covariance = step.covariance;
    if (i == iterations) break;
    const double cost = calc_cost(problems.all, selection, h, even, odd);
    h = take_step(h, step.delta, cost, [&](const Hypothesis& moved) {
      even = evaluate(problems.even, moved);
      odd = evaluate(problems.odd, moved);
      return calc_cost(problems.all, selection, moved, even, odd);
    });
    if (!are_sensible(problems.all, h)) return false;
  }
  *hypothesis = h;
  return true;
}

}  // namespace hrp::diagnosis::standing
