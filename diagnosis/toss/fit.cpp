// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/toss/fit.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/robust.h"
#include "diagnosis/search/fit.h"
#include "diagnosis/search/parameters.h"
#include "diagnosis/toss/window.h"

namespace hrp::diagnosis::toss {
namespace {

// Rms over the windows of a role without the worst twentieth (at least one of ten or more).
double calc_typical(const TossProblem& problem, const TossFit& fit, bool train) {
  std::vector<std::pair<double, double>> windows;
  for (size_t i = 0; i < problem.windows.size(); ++i) {
    const Window& w = problem.windows[i];
    if (problem.tosses[w.toss].train == train) windows.emplace_back(fit.misfit[i], calc_degrees(w));
  }
  std::sort(windows.begin(), windows.end());
  if (windows.size() >= 10) windows.resize(windows.size() - (windows.size() + 19) / 20);
  double chi2 = 0.0, degrees = 0.0;
  for (const auto& [misfit, n] : windows) {
    chi2 += n * misfit;
    degrees += n;
  }
  return degrees > 0.0 ? std::sqrt(chi2 / degrees) : 0.0;
}

void summarise(const TossProblem& problem, TossFit* fit) {
  fit->typical_train = calc_typical(problem, *fit, true);
  fit->typical_validate = calc_typical(problem, *fit, false);
  double chi2[2] = {0, 0}, degrees[2] = {0, 0};
  fit->cost.assign(problem.tosses.size(), 0.0);
  for (size_t i = 0; i < problem.windows.size(); ++i) {
    const Window& w = problem.windows[i];
    const bool train = problem.tosses[w.toss].train;
    const double n = calc_degrees(w);
    chi2[train] += n * fit->misfit[i];
    degrees[train] += n;
    fit->cost[w.toss] += calc_cost(fit->misfit[i], n);
  }
  fit->train = degrees[1] > 0 ? std::sqrt(chi2[1] / degrees[1]) : 0.0;
  fit->validate = degrees[0] > 0 ? std::sqrt(chi2[0] / degrees[0]) : 0.0;
  fit->train_cost = fit->validate_cost = 0.0;
  for (size_t t = 0; t < problem.tosses.size(); ++t)
    (problem.tosses[t].train ? fit->train_cost : fit->validate_cost) += fit->cost[t];
}

// Fits bad windows again, starting where the prediction of the previous window ends. Under the right model this is
// their start state.
void continue_windows(const TossProblem& problem, int jobs, TossFit* fit) {
  const std::vector<WindowStart> starts = fit->starts;
  const std::vector<double> misfit = fit->misfit;
  parallel_for(jobs, static_cast<int>(starts.size()), [&](int i) {
    const auto k = static_cast<size_t>(i);
    if (k == 0 || misfit[k] < 4.0 || misfit[k - 1] > misfit[k]) return;
    const Window &before = problem.windows[k - 1], &here = problem.windows[k];
    if (before.toss != here.toss || before.first + before.count != here.first) return;
    Window bridge = before;
    ++bridge.count;
    WindowStart start = starts[k - 1];
    if (!Predictor(problem, fit->hypothesis, bridge).run_on(&start)) return;
    Predictor predictor(problem, fit->hypothesis, here);
    const WindowFit again = fit_window(problem, &predictor, here, start, 5);
    if (again.ok && again.misfit < misfit[k]) {
      fit->starts[k] = again.start;
      fit->misfit[k] = again.misfit;
    }
  });
}

using Parameters = std::vector<Parameter<TossParameter>>;

Parameters list_parameters(const Hypothesis& hypothesis) {
  return flatten<TossParameter>(
      hypothesis, [](const Effect& e) -> const auto& { return get_toss_row(e).parameters; });
}

// Normal equations of the parameters after elimination of all start states, and the score vector of each toss.
struct Normal {
  Eigen::MatrixXd A, scores;  // scores: one column per toss
  Eigen::VectorXd b;
  std::vector<Eigen::MatrixXd> by_toss;  // share of each toss in A; empty without windows
  // by window: derivative of its nuisance parameters with respect to the parameters (kStart x n)
  std::vector<Eigen::MatrixXd> follow;
};

struct WindowNormal {
  Eigen::MatrixXd A, follow;
  Eigen::VectorXd b;
};

bool add_window(const TossProblem& problem, const TossFit& fit, size_t index, const Parameters& parameters,
                WindowNormal* out) {
  const Window& window = problem.windows[index];
  Predictor predictor(problem, fit.hypothesis, window);
  WindowFit w;
  w.start = fit.starts[index];
  if (!predictor.run(w.start, &w.residuals) || !calc_start_jacobian(problem, &predictor, &w)) return false;
  const auto n = static_cast<long>(parameters.size());
  Eigen::MatrixXd J(w.residuals.size(), n);
  for (long i = 0; i < n; ++i) {
    const Parameter<TossParameter>& p = parameters[static_cast<size_t>(i)];
    Eigen::VectorXd side[2];
    double width = 0.0;
    for (int s = 0; s < 2; ++s) {
      Hypothesis moved = fit.hypothesis;
      double& value = moved[p.effect].p[p.index];
      const double centre = value;
      value = std::clamp(centre + (s ? -1.0 : 1.0) * p.info->step, p.info->low, p.info->high);
      width += (s ? -1.0 : 1.0) * (value - centre);
      if (!Predictor(problem, moved, window).run(w.start, &side[s])) return false;
    }
    J.col(i) = (side[0] - side[1]) / width;
  }
  const Eigen::MatrixXd N = w.J.transpose() * w.J;
  Eigen::MatrixXd damped = N;
  damped.diagonal() += 1e-9 * N.diagonal() + Eigen::VectorXd::Constant(kStart, 1e-12);
  const Eigen::LDLT<Eigen::MatrixXd> factor(damped);
  out->follow = -factor.solve(w.J.transpose() * J);
  const Eigen::MatrixXd clean = J + w.J * out->follow;
  const Eigen::VectorXd r = w.residuals - w.J * factor.solve(w.J.transpose() * w.residuals);
  const double weight = 1.0 / (1.0 + fit.misfit[index] / 4.0);
  out->A = weight * clean.transpose() * clean;
  out->b = weight * clean.transpose() * r;
  return out->A.allFinite() && out->b.allFinite() && out->follow.allFinite();
}

Normal make_normal(const TossProblem& problem, const TossFit& fit, const Parameters& parameters,
                   const std::vector<char>& use, int jobs) {
  const auto n = static_cast<long>(parameters.size());
  const size_t count = problem.windows.size();
  const WindowNormal nothing{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(kStart, n), Eigen::VectorXd::Zero(n)};
  std::vector<WindowNormal> parts(count, nothing);
  parallel_for(jobs, static_cast<int>(count), [&](int i) {
    const auto k = static_cast<size_t>(i);
    WindowNormal part = nothing;
    if (add_window(problem, fit, k, parameters, &part)) parts[k] = part;
  });
  Normal out;
  out.by_toss.resize(problem.tosses.size());
  out.A.setZero(n, n);
  out.b.setZero(n);
  out.scores.setZero(n, static_cast<long>(problem.tosses.size()));
  for (size_t k = 0; k < count; ++k) {
    out.follow.push_back(parts[k].follow);
    const size_t toss = problem.windows[k].toss;
    if (!use[toss]) continue;
    Eigen::MatrixXd& own = out.by_toss[toss];
    if (own.size() == 0) own.setZero(n, n);
    own += parts[k].A;
    out.A += parts[k].A;
    out.b += parts[k].b;
    out.scores.col(static_cast<long>(toss)) += parts[k].b;
  }
  return out;
}

// Takes a step in the parameters and moves all start states along, to first order.
TossFit move_fit(const TossFit& fit, const Normal& normal, const Parameters& parameters, Eigen::VectorXd step) {
  TossFit moved = fit;
  for (size_t i = 0; i < parameters.size(); ++i) {
    const Parameter<TossParameter>& p = parameters[i];
    double& value = moved.hypothesis[p.effect].p[p.index];
    const double before = value;
    value = std::clamp(value + step[static_cast<long>(i)], p.info->low, p.info->high);
    step[static_cast<long>(i)] = value - before;
  }
  for (size_t k = 0; k < moved.starts.size(); ++k) moved.starts[k] = move_start(fit.starts[k], normal.follow[k] * step);
  return moved;
}

double sum_cost(const TossFit& fit, const std::vector<char>& use) {
  double sum = 0.0;
  for (size_t t = 0; t < use.size(); ++t) sum += use[t] ? fit.cost[t] : 0.0;
  return sum;
}

// Standard deviation of a parameter between tosses (DerSimonian and Laird, 1986, eq. 8: scatter of their own values
// minus what their information allows). `along`: change of all parameters if this one changes by 1 and the others are
// fitted again. Leaves out tosses with little information, whose own values are too far away for the linearisation.
double calc_spread(const Normal& normal, const Eigen::VectorXd& along) {
  std::vector<std::pair<double, double>> tosses;  // information, score
  double most = 0.0;
  for (size_t t = 0; t < normal.by_toss.size(); ++t) {
    if (normal.by_toss[t].size() == 0) continue;
    tosses.emplace_back(along.dot(normal.by_toss[t] * along), along.dot(normal.scores.col(static_cast<long>(t))));
    most = std::max(most, tosses.back().first);
  }
  double count = 0.0, w1 = 0.0, w2 = 0.0, mean = 0.0, scatter = 0.0;
  const double least = 0.05 * most;
  for (const auto& [w, score] : tosses) {
    if (w > least) {
      count += 1.0;
      w1 += w;
      w2 += w * w;
      mean -= score;
    }
  }
  if (count < 3.0) return 0.0;
  mean /= w1;
  for (const auto& [w, score] : tosses) {
    if (w > least) scatter += w * std::pow(-score / w - mean, 2);
  }
  return std::sqrt(std::max(0.0, (scatter - (count - 1.0)) / (w1 - w2 / w1)));
}

// Robust covariance with tosses as clusters.
void fill_std(const Normal& normal, const Parameters& parameters, TossFit* fit) {
  const auto n = static_cast<long>(parameters.size());
  Eigen::MatrixXd A = normal.A;
  A.diagonal().array() += 1e-12 * (1.0 + A.diagonal().array());
  const Eigen::MatrixXd inverse = A.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  double tosses = 0.0;
  for (const Eigen::MatrixXd& own : normal.by_toss) tosses += own.size() > 0 ? 1.0 : 0.0;
  const double few = tosses > 1.5 ? find_few(tosses) : 4.0;  // a single toss counts as two that differ twice as much
  const RobustCovariance covariance = make_robust_covariance(inverse, normal.scores * normal.scores.transpose(), few);
  fit->covariance = covariance.robust;
  fit->std.clear();
  for (const Effect& e : fit->hypothesis) fit->std.emplace_back(e.p.size(), 0.0);
  fit->spread = fit->std;
  for (long i = 0; i < n; ++i) {
    const Parameter<TossParameter>& p = parameters[static_cast<size_t>(i)];
    fit->std[p.effect][p.index] = std::sqrt(covariance.find_variance(i));
    fit->spread[p.effect][p.index] = calc_spread(normal, inverse.col(i) / inverse(i, i));
  }
}

}  // namespace

double calc_cost(double misfit, double degrees) { return 2.0 * degrees * std::log1p(misfit / 4.0); }

std::vector<double> calc_window_residuals(const TossProblem& problem, const Hypothesis& hypothesis,
                                          const Window& window, const WindowStart& start,
                                          std::vector<Regime>* regimes) {
  Eigen::VectorXd r;
  if (!Predictor(problem, hypothesis, window).run(start, &r, regimes)) return {};
  return std::vector<double>(r.data(), r.data() + r.size() - kPrior);
}

TossFit fit_starts(const TossProblem& problem, const Hypothesis& hypothesis, const TossFit* warm, int jobs) {
  TossFit fit;
  fit.hypothesis = hypothesis;
  const size_t count = problem.windows.size();
  fit.starts.resize(count);
  fit.misfit.assign(count, kFailed);
  parallel_for(jobs, static_cast<int>(count), [&](int i) {
    const auto k = static_cast<size_t>(i);
    const WindowFit w = fit_window_afresh(problem, hypothesis, problem.windows[k], warm ? &warm->starts[k] : nullptr);
    fit.starts[k] = w.start;
    fit.misfit[k] = std::min(w.misfit, kFailed);
  });
  continue_windows(problem, jobs, &fit);
  summarise(problem, &fit);
  return fit;
}

std::vector<double> calc_gains(const TossProblem& problem, const TossFit& fit, const std::vector<EffectId>& candidates,
                               int jobs) {
  std::vector<char> use;
  for (const Toss& t : problem.tosses) use.push_back(t.train);
  TossFit with = fit;
  for (EffectId id : candidates) with.hypothesis.push_back(make_neutral(problem, id));
  const Parameters parameters = list_parameters(with.hypothesis);
  const Normal normal = make_normal(problem, with, parameters, use, jobs);
  std::vector<double> gains;
  for (size_t c = 0; c < candidates.size(); ++c) {
    std::vector<long> rows;
    for (size_t i = 0; i < parameters.size(); ++i) {
      const size_t effect = parameters[i].effect;
      if (effect < fit.hypothesis.size() || effect == fit.hypothesis.size() + c) rows.push_back(static_cast<long>(i));
    }
    Eigen::MatrixXd A = normal.A(rows, rows);
    const Eigen::VectorXd b = normal.b(rows);
    A.diagonal() += 1e-9 * A.diagonal() + Eigen::VectorXd::Constant(b.size(), 1e-12);
    gains.push_back(0.5 * b.dot(A.ldlt().solve(b)));
  }
  return gains;
}

TossFit fit_tosses(const TossProblem& problem, const TossFit& start, const TossFitOptions& options) {
  std::vector<char> use;
  for (const Toss& t : problem.tosses) use.push_back(options.use ? (*options.use)[use.size()] : t.train);
  TossFit fit = start;
  const Parameters parameters = list_parameters(fit.hypothesis);
  if (parameters.empty()) return fit;
  double lambda = 1e-3;
  Normal normal;
  for (int round = 0; round < options.rounds; ++round) {
    normal = make_normal(problem, fit, parameters, use, options.jobs);
    const double before = sum_cost(fit, use);
    bool better = false;
    for (int trial = 0; trial < 3 && !better; ++trial) {
      Eigen::MatrixXd A = normal.A;
      A.diagonal() += lambda * normal.A.diagonal() + Eigen::VectorXd::Constant(A.rows(), 1e-12);
      const Eigen::VectorXd step = -A.ldlt().solve(normal.b);
      const TossFit moved = move_fit(fit, normal, parameters, step);
      const TossFit next = fit_starts(problem, moved.hypothesis, &moved, options.jobs);
      better = sum_cost(next, use) < before;
      if (better) {
        fit = next;
        lambda = std::max(1e-6, 0.1 * lambda);
      } else {
        lambda = 10.0 * std::max(lambda, 1e-3);
      }
    }
    if (!better || before - sum_cost(fit, use) < 1e-4 * before) break;
  }
  normal = make_normal(problem, fit, parameters, use, options.jobs);
  fill_std(normal, parameters, &fit);
  return fit;
}

}  // namespace hrp::diagnosis::toss
