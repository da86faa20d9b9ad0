// SPDX-License-Identifier: BSD-3-Clause
// One window of a tossed body: prediction of its poses, and the start state that fits them best.
#pragma once

#include <vector>

#include "diagnosis/toss/model.h"

namespace hrp::diagnosis::toss {

// Nuisance parameters of a window: rotation, position, angular velocity and velocity at its start, and height, roll and
// pitch of the ground as the tracker measures it. The last three have a prior around zero.
constexpr int kStart = 15, kPrior = 3;
constexpr double kFailed = 1e6;  // misfit of a window whose simulation failed
using VectorS = Eigen::Matrix<double, kStart, 1>;

// Adds a step to the nuisance parameters.
WindowStart move_start(const WindowStart& start, const VectorS& by);

// Degrees of freedom of a window's residuals.
inline double calc_degrees(const Window& window) { return static_cast<double>(6 * window.count) + kPrior - kStart; }

// Predicts one window with one model.
class Predictor {
 public:
  Predictor(const TossProblem& problem, const Hypothesis& hypothesis, const Window& window);

  // Whitened residuals, per sample position x y z, rotation x y z; then those of the priors. Returns false if the
  // simulation fails.
  bool run(const WindowStart& start, Eigen::VectorXd* residuals, std::vector<Regime>* regimes = nullptr);
  // Moves `start` to the last sample of the window.
  bool run_on(WindowStart* start);
  // Start state from the first poses: local motion, corrected for the pose sensor.
  WindowStart guess(size_t samples) const;

 private:
  const TossProblem& problem_;
  const TossModel model_;
  const Toss& toss_;
  const Window window_;
  std::vector<double> time_;
  std::vector<BodyState> states_;
};

struct WindowFit {
  WindowStart start;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd J;  // with respect to the start state
  double misfit = kFailed;
  bool ok = false;
};

// Fills fit->J by forward differences; returns false if a simulation fails.
bool calc_start_jacobian(const TossProblem& problem, Predictor* predictor, WindowFit* fit);

// Levenberg-Marquardt fit of the start state of one window.
WindowFit fit_window(const TossProblem& problem, Predictor* predictor, const Window& window, const WindowStart& start,
                     int rounds);

// Fits from several start values (poses over spans of different length, `warm`) and returns the best fit.
WindowFit fit_window_afresh(const TossProblem& problem, const Hypothesis& hypothesis, const Window& window,
                            const WindowStart* warm);

}  // namespace hrp::diagnosis::toss
