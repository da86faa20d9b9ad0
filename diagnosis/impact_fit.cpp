// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/impact_fit.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/fit.h"
#include "diagnosis/impact_model.h"

namespace hrp::diagnosis::impact {
namespace {

// Nuisances of a window: turn, position, angular velocity, velocity at its start; and height, roll and pitch of the
// ground as the tracker sees it there, which are known to be small.
constexpr int kStart = 15, kPrior = 3;
constexpr double kFailed = 1e6;         // mean square of a window that could not be simulated
using VectorS = Eigen::Matrix<double, kStart, 1>;

WindowStart move_start(const WindowStart& s, const VectorS& d) {
  WindowStart out = s;
  out.ground += d.tail<3>();
  const double angle = d.head<3>().norm();
  if (angle > 0.0) out.R_WB = Eigen::Quaterniond(Eigen::AngleAxisd(angle, d.head<3>() / angle)) * s.R_WB;
  out.R_WB.normalize();
  out.p_WB += d.segment<3>(3), out.w_WB += d.segment<3>(6), out.v_WB += d.segment<3>(9);
  return out;
}

// Predicts one window under one model.
class Predictor {
 public:
  Predictor(const TossProblem& problem, const TossHypothesis& hypothesis, const Window& window)
      : problem_(problem), model_(make_toss_model(problem, hypothesis)), toss_(problem.tosses[window.toss]), window_(window) {
    for (size_t i = 0; i < window.count; ++i) {
      time_.push_back((toss_.time[window.first + i] - toss_.time[window.first]) * (1.0 + model_.sensor.skew));
    }
  }

  bool run(const WindowStart& start, Eigen::VectorXd* residuals, std::vector<Regime>* regimes = nullptr) {
    World world = model_.world;
    world.ground.height += start.ground[0], world.ground.roll += start.ground[1], world.ground.pitch += start.ground[2];
    if (!roll_out(world, problem_.soles, start, time_, &states_, regimes)) return false;
    const PoseSensor& s = model_.sensor;
    residuals->resize(static_cast<long>(6 * window_.count) + kPrior);
    residuals->tail<3>() << start.ground[0] / problem_.slow_p, start.ground[1] / problem_.slow_R, start.ground[2] / problem_.slow_R;
    for (size_t i = 0; i < window_.count; ++i) {
      const BodyState& x = states_[i];
      const size_t k = window_.first + i;
      const auto row = static_cast<long>(6 * i);
      const Vector3d p = s.scale * x.p_WB + s.bias, late = s.delay * x.w_WB;
      Eigen::Quaterniond R = x.R_WB * Eigen::Quaterniond(s.R);
      if (s.delay != 0.0) R = Eigen::Quaterniond(Eigen::AngleAxisd(-late.norm(), late.normalized())) * R;
      residuals->segment<3>(row) = (toss_.p[k] - p) / problem_.sigma_p;
      residuals->segment<3>(row + 3) = calc_turn(R, toss_.R[k]) / problem_.sigma_R;
    }
    return residuals->allFinite();
  }

  // Moves a start to the last sample of the window.
  bool run_on(WindowStart* start) {
    Eigen::VectorXd residuals;
    if (!run(*start, &residuals)) return false;
    static_cast<BodyState&>(*start) = states_.back();
    return true;
  }

  // A true start state from readings: the sensor undone on local motion.
  WindowStart guess(size_t samples) const {
    const size_t first = window_.first, end = first + std::min(samples, window_.count);
    const LocalMotion m = calc_local_motion(problem_, toss_, first, end, first);
    const PoseSensor& s = model_.sensor;
    WindowStart x;
    x.R_WB = toss_.R[first] * Eigen::Quaterniond(Matrix3d(s.R.transpose()));
    x.p_WB = (toss_.p[first] - s.bias) / s.scale, x.w_WB = m.w / (1.0 + s.skew), x.v_WB = m.v / (s.scale * (1.0 + s.skew));
    return x;
  }

 private:
  const TossProblem& problem_;
  const TossModel model_;
  const Toss& toss_;
  const Window window_;
  std::vector<double> time_;
  std::vector<BodyState> states_;
};

VectorS get_start_steps(const TossProblem& problem) {
  VectorS steps;  // a fifth of what a window resolves
  const double speed = 2.0 / problem.horizon;
  steps << Vector3d::Constant(0.2 * problem.sigma_R), Vector3d::Constant(0.2 * problem.sigma_p),
      Vector3d::Constant(0.2 * problem.sigma_R * speed), Vector3d::Constant(0.2 * problem.sigma_p * speed),
      0.2 * problem.slow_p, 0.2 * problem.slow_R, 0.2 * problem.slow_R;
  return steps;
}

struct WindowFit {
  WindowStart start;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd J;       // by the start state
  double misfit = kFailed;
  bool ok = false;
};

bool calc_start_jacobian(const TossProblem& problem, Predictor* predictor, WindowFit* fit) {
  const VectorS steps = get_start_steps(problem);
  fit->J.resize(fit->residuals.size(), kStart);
  Eigen::VectorXd moved;
  for (int i = 0; i < kStart; ++i) {
    if (!predictor->run(move_start(fit->start, steps[i] * VectorS::Unit(i)), &moved)) return false;
    fit->J.col(i) = (moved - fit->residuals) / steps[i];
  }
  return true;
}

double calc_degrees(const Window& window) { return static_cast<double>(6 * window.count) + kPrior - kStart; }

// Levenberg-Marquardt on the start state of one window.
WindowFit fit_window(const TossProblem& problem, Predictor* predictor, const Window& window, const WindowStart& start, int rounds) {
  WindowFit fit;
  fit.start = start;
  if (!predictor->run(start, &fit.residuals)) return fit;
  fit.ok = true;
  double chi2 = fit.residuals.squaredNorm(), lambda = 1e-3;
  for (int round = 0; round < rounds && calc_start_jacobian(problem, predictor, &fit); ++round) {
    const Eigen::MatrixXd A = fit.J.transpose() * fit.J;
    const VectorS b = fit.J.transpose() * fit.residuals;
    const double before = chi2;
    for (int trial = 0; trial < 5; ++trial) {
      Eigen::MatrixXd damped = A;
      damped.diagonal() += lambda * A.diagonal() + Eigen::VectorXd::Constant(kStart, 1e-12);
      const WindowStart next = move_start(fit.start, -damped.ldlt().solve(b));
      Eigen::VectorXd residuals;
      if (predictor->run(next, &residuals) && residuals.squaredNorm() < chi2) {
        fit.start = next, fit.residuals = residuals, chi2 = residuals.squaredNorm(), lambda = std::max(1e-6, 0.1 * lambda);
        break;
      }
      lambda = std::max(1e-4, lambda) * 8.0;
    }
    if (before - chi2 < 1e-3 * before) break;
  }
  fit.misfit = chi2 / calc_degrees(window);
  return fit;
}

// From readings over spans of different length, and from where it was before: the best.
WindowFit fit_window_afresh(const TossProblem& problem, const TossHypothesis& hypothesis, const Window& window,
                            const WindowStart* warm) {
  Predictor predictor(problem, hypothesis, window);
  WindowFit best;
  if (warm) best = fit_window(problem, &predictor, window, *warm, 4);
  if (warm && best.misfit < 1.5) return best;
  for (size_t samples : {size_t{4}, window.count, size_t{3}, size_t{6}}) {
    const WindowFit fit = fit_window(problem, &predictor, window, predictor.guess(samples), warm ? 3 : 8);
    if (fit.ok && fit.misfit < best.misfit) best = fit;
    if (warm || best.misfit < 4.0) break;
  }
  if (!best.ok) best.start = predictor.guess(4);
  return best;
}

// Root mean square over windows of a role, the worst twentieth (at least one of ten or more) left out.
double calc_typical(const TossProblem& problem, const TossFit& fit, bool train) {
  std::vector<std::pair<double, double>> windows;
  for (size_t i = 0; i < problem.windows.size(); ++i) {
    const Window& w = problem.windows[i];
    if (problem.tosses[w.toss].train == train) windows.emplace_back(fit.misfit[i], calc_degrees(w));
  }
  std::sort(windows.begin(), windows.end());
  if (windows.size() >= 10) windows.resize(windows.size() - (windows.size() + 19) / 20);
  double chi2 = 0.0, degrees = 0.0;
  for (const auto& [misfit, n] : windows) chi2 += n * misfit, degrees += n;
  return degrees > 0.0 ? std::sqrt(chi2 / degrees) : 0.0;
}

void summarise(const TossProblem& problem, TossFit* fit) {
  fit->typical_train = calc_typical(problem, *fit, true), fit->typical_validate = calc_typical(problem, *fit, false);
  double chi2[2] = {0, 0}, degrees[2] = {0, 0};
  fit->cost.assign(problem.tosses.size(), 0.0);
  for (size_t i = 0; i < problem.windows.size(); ++i) {
    const Window& w = problem.windows[i];
    const bool train = problem.tosses[w.toss].train;
    const double n = calc_degrees(w);
    chi2[train] += n * fit->misfit[i], degrees[train] += n;
    fit->cost[w.toss] += calc_cost(fit->misfit[i], n);
  }
  fit->train = degrees[1] > 0 ? std::sqrt(chi2[1] / degrees[1]) : 0.0;
  fit->validate = degrees[0] > 0 ? std::sqrt(chi2[0] / degrees[0]) : 0.0;
  fit->train_cost = fit->validate_cost = 0.0;
  for (size_t t = 0; t < problem.tosses.size(); ++t) (problem.tosses[t].train ? fit->train_cost : fit->validate_cost) += fit->cost[t];
}

// Windows that fit badly are tried once more from where the window before them ends: under a right model that is where
// they begin.
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
    if (again.ok && again.misfit < misfit[k]) fit->starts[k] = again.start, fit->misfit[k] = again.misfit;
  });
}

struct Parameter {
  size_t effect, index;
  const TossParameter* info;
};

std::vector<Parameter> list_parameters(const TossHypothesis& hypothesis) {
  std::vector<Parameter> out;
  for (size_t e = 0; e < hypothesis.size(); ++e) {
    const auto& parameters = get_toss_info(hypothesis[e].id).parameters;
    for (size_t i = 0; i < parameters.size(); ++i) out.push_back({e, i, &parameters[i]});
  }
  return out;
}

// Normal equations of the parameters with every start state eliminated, and the scores of each toss.
struct Normal {
  Eigen::MatrixXd A, scores;   // scores: one column a toss
  Eigen::VectorXd b;
  std::vector<Eigen::MatrixXd> follow;  // by window: how its nuisances follow the parameters (kStart x n)
};

struct WindowNormal {
  Eigen::MatrixXd A, follow;
  Eigen::VectorXd b;
};

bool add_window(const TossProblem& problem, const TossFit& fit, size_t index, const std::vector<Parameter>& parameters,
                WindowNormal* out) {
  const Window& window = problem.windows[index];
  Predictor predictor(problem, fit.hypothesis, window);
  WindowFit w;
  w.start = fit.starts[index];
  if (!predictor.run(w.start, &w.residuals) || !calc_start_jacobian(problem, &predictor, &w)) return false;
  const auto n = static_cast<long>(parameters.size());
  Eigen::MatrixXd J(w.residuals.size(), n);
  for (long i = 0; i < n; ++i) {
    const Parameter& p = parameters[static_cast<size_t>(i)];
    Eigen::VectorXd side[2];
    double width = 0.0;
    for (int s = 0; s < 2; ++s) {
      TossHypothesis moved = fit.hypothesis;
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
  out->A = weight * clean.transpose() * clean, out->b = weight * clean.transpose() * r;
  return out->A.allFinite() && out->b.allFinite() && out->follow.allFinite();
}

Normal make_normal(const TossProblem& problem, const TossFit& fit, const std::vector<Parameter>& parameters,
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
  out.A.setZero(n, n), out.b.setZero(n), out.scores.setZero(n, static_cast<long>(problem.tosses.size()));
  for (size_t k = 0; k < count; ++k) {
    out.follow.push_back(parts[k].follow);
    const size_t toss = problem.windows[k].toss;
    if (!use[toss]) continue;
    out.A += parts[k].A, out.b += parts[k].b;
    out.scores.col(static_cast<long>(toss)) += parts[k].b;
  }
  return out;
}

// The fit with its parameters moved and every start state along with them, as far as that is linear.
TossFit move_fit(const TossFit& fit, const Normal& normal, const std::vector<Parameter>& parameters, Eigen::VectorXd step) {
  TossFit moved = fit;
  for (size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& p = parameters[i];
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

// A^-1 (sum of the outer products of the tosses' scores) A^-1, with the small-sample factor of n tosses.
void fill_std(const Normal& normal, const std::vector<Parameter>& parameters, const std::vector<char>& use, TossFit* fit) {
  const auto n = static_cast<long>(parameters.size());
  Eigen::MatrixXd A = normal.A;
  A.diagonal().array() += 1e-12 * (1.0 + A.diagonal().array());
  const Eigen::MatrixXd inverse = A.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  const double tosses = static_cast<double>(std::count(use.begin(), use.end(), 1));
  const double few = tosses > 1.5 ? tosses / (tosses - 1.0) : 4.0;
  fit->covariance = few * inverse * normal.scores * normal.scores.transpose() * inverse;
  fit->std.clear();
  for (const TossEffect& e : fit->hypothesis) fit->std.emplace_back(e.p.size(), 0.0);
  for (long i = 0; i < n; ++i) {
    const Parameter& p = parameters[static_cast<size_t>(i)];
    // Never better than what noise alone would leave.
    fit->std[p.effect][p.index] = std::sqrt(std::max(fit->covariance(i, i), inverse(i, i)));
  }
}

}  // namespace

double calc_cost(double misfit, double degrees) { return 2.0 * degrees * std::log1p(misfit / 4.0); }

std::vector<double> calc_window_residuals(const TossProblem& problem, const TossHypothesis& hypothesis, const Window& window,
                                          const WindowStart& start, std::vector<Regime>* regimes) {
  Eigen::VectorXd r;
  if (!Predictor(problem, hypothesis, window).run(start, &r, regimes)) return {};
  return std::vector<double>(r.data(), r.data() + r.size() - kPrior);
}

TossFit fit_starts(const TossProblem& problem, const TossHypothesis& hypothesis, const TossFit* warm, int jobs) {
  TossFit fit;
  fit.hypothesis = hypothesis;
  const size_t count = problem.windows.size();
  fit.starts.resize(count), fit.misfit.assign(count, kFailed);
  parallel_for(jobs, static_cast<int>(count), [&](int i) {
    const auto k = static_cast<size_t>(i);
    const WindowFit w = fit_window_afresh(problem, hypothesis, problem.windows[k], warm ? &warm->starts[k] : nullptr);
    fit.starts[k] = w.start, fit.misfit[k] = std::min(w.misfit, kFailed);
  });
  continue_windows(problem, jobs, &fit);
  summarise(problem, &fit);
  return fit;
}

std::vector<double> calc_gains(const TossProblem& problem, const TossFit& fit, const std::vector<TossId>& candidates, int jobs) {
  std::vector<char> use;
  for (const Toss& t : problem.tosses) use.push_back(t.train);
  TossFit with = fit;
  for (TossId id : candidates) with.hypothesis.push_back(make_neutral(problem, id));
  const std::vector<Parameter> parameters = list_parameters(with.hypothesis);
  const Normal normal = make_normal(problem, with, parameters, use, jobs);
  std::vector<double> gains;
  for (size_t c = 0; c < candidates.size(); ++c) {
    std::vector<long> rows;
    for (size_t i = 0; i < parameters.size(); ++i) {
      const size_t effect = parameters[i].effect;
      if (effect < fit.hypothesis.size() || effect == fit.hypothesis.size() + c) rows.push_back(static_cast<long>(i));
    }
    const auto n = static_cast<long>(rows.size());
    Eigen::MatrixXd A(n, n);
    Eigen::VectorXd b(n);
    for (long i = 0; i < n; ++i) {
      b[i] = normal.b[rows[static_cast<size_t>(i)]];
      for (long j = 0; j < n; ++j) A(i, j) = normal.A(rows[static_cast<size_t>(i)], rows[static_cast<size_t>(j)]);
    }
    A.diagonal() += 1e-9 * A.diagonal() + Eigen::VectorXd::Constant(n, 1e-12);
    gains.push_back(0.5 * b.dot(A.ldlt().solve(b)));
  }
  return gains;
}

TossFit fit_tosses(const TossProblem& problem, const TossFit& start, const TossFitOptions& options) {
  std::vector<char> use;
  for (const Toss& t : problem.tosses) use.push_back(options.use ? (*options.use)[use.size()] : t.train);
  TossFit fit = start;
  const std::vector<Parameter> parameters = list_parameters(fit.hypothesis);
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
      if (better) fit = next, lambda = std::max(1e-6, 0.1 * lambda);
      else lambda = 10.0 * std::max(lambda, 1e-3);
    }
    if (!better || before - sum_cost(fit, use) < 1e-4 * before) break;
  }
  normal = make_normal(problem, fit, parameters, use, options.jobs);
  fill_std(normal, parameters, use, &fit);
  return fit;
}

}  // namespace hrp::diagnosis::impact
