// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/toss/window.h"

#include <algorithm>

#include "common/spatial/turn.h"

namespace hrp::diagnosis::toss {
namespace {

VectorS get_start_steps(const TossProblem& problem) {
  VectorS steps;  // a fifth of the resolution of a window
  const double speed = 2.0 / problem.horizon;
  steps << Vector3d::Constant(0.2 * problem.sigma_R), Vector3d::Constant(0.2 * problem.sigma_p),
      Vector3d::Constant(0.2 * problem.sigma_R * speed), Vector3d::Constant(0.2 * problem.sigma_p * speed),
      0.2 * problem.slow_p, 0.2 * problem.slow_R, 0.2 * problem.slow_R;
  return steps;
}

}  // namespace

WindowStart move_start(const WindowStart& s, const VectorS& d) {
  WindowStart out = s;
  out.ground += d.tail<3>();
  out.R_WB = make_turn(d.head<3>()) * s.R_WB;
  out.R_WB.normalize();
  out.p_WB += d.segment<3>(3);
  out.w_WB += d.segment<3>(6);
  out.v_WB += d.segment<3>(9);
  return out;
}

Predictor::Predictor(const TossProblem& problem, const Hypothesis& hypothesis, const Window& window)
    : problem_(problem),
      model_(make_toss_model(problem, hypothesis)),
      toss_(problem.tosses[window.toss]),
      window_(window) {
  for (size_t i = 0; i < window.count; ++i) {
    time_.push_back((toss_.time[window.first + i] - toss_.time[window.first]) * (1.0 + model_.sensor.skew));
  }
}

bool Predictor::run(const WindowStart& start, Eigen::VectorXd* residuals, std::vector<Regime>* regimes) {
  World world = model_.world;
  world.ground.height += start.ground[0];
  world.ground.roll += start.ground[1];
  world.ground.pitch += start.ground[2];
  if (!roll_out(world, problem_.soles, start, time_, &states_, regimes)) return false;
  const PoseSensor& s = model_.sensor;
  residuals->resize(static_cast<long>(6 * window_.count) + kPrior);
  residuals->tail<3>() << start.ground[0] / problem_.slow_p, start.ground[1] / problem_.slow_R,
      start.ground[2] / problem_.slow_R;
  for (size_t i = 0; i < window_.count; ++i) {
    const BodyState& x = states_[i];
    const size_t k = window_.first + i;
    const auto row = static_cast<long>(6 * i);
    const Vector3d p = s.scale * x.p_WB + s.bias, late = -s.delay * x.w_WB;
    Eigen::Quaterniond R = x.R_WB * Eigen::Quaterniond(s.R);
    R = make_turn(late) * R;
    residuals->segment<3>(row) = (toss_.p[k] - p) / problem_.sigma_p;
    residuals->segment<3>(row + 3) = calc_turn(R, toss_.R[k]) / problem_.sigma_R;
  }
  return residuals->allFinite();
}

bool Predictor::run_on(WindowStart* start) {
  Eigen::VectorXd residuals;
  if (!run(*start, &residuals)) return false;
  static_cast<BodyState&>(*start) = states_.back();
  return true;
}

WindowStart Predictor::guess(size_t samples) const {
  const size_t first = window_.first, end = first + std::min(samples, window_.count);
  const LocalMotion m = calc_local_motion(problem_, toss_, first, end, first);
  const PoseSensor& s = model_.sensor;
  WindowStart x;
  x.R_WB = toss_.R[first] * Eigen::Quaterniond(Matrix3d(s.R.transpose()));
  x.p_WB = (toss_.p[first] - s.bias) / s.scale;
  x.w_WB = m.w / (1.0 + s.skew);
  x.v_WB = m.v / (s.scale * (1.0 + s.skew));
  return x;
}

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

WindowFit fit_window(const TossProblem& problem, Predictor* predictor, const Window& window, const WindowStart& start,
                     int rounds) {
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
        fit.start = next;
        fit.residuals = residuals;
        chi2 = residuals.squaredNorm();
        lambda = std::max(1e-6, 0.1 * lambda);
        break;
      }
      lambda = std::max(1e-4, lambda) * 8.0;
    }
    if (before - chi2 < 1e-3 * before) break;
  }
  fit.misfit = chi2 / calc_degrees(window);
  return fit;
}

WindowFit fit_window_afresh(const TossProblem& problem, const Hypothesis& hypothesis, const Window& window,
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

}  // namespace hrp::diagnosis::toss
