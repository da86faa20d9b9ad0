// SPDX-License-Identifier: BSD-3-Clause
// One window of a tossed body: what a model predicts there, and the start state that meets the readings best.
#pragma once

#include <vector>

#include "diagnosis/toss/model.h"

namespace hrp::diagnosis::toss {

// Nuisances of a window: turn, position, angular velocity, velocity at its start; and height, roll and pitch of the
// ground as the tracker sees it there, which are known to be small.
constexpr int kStart = 15, kPrior = 3;
constexpr double kFailed = 1e6;  // mean square of a window that could not be simulated
using VectorS = Eigen::Matrix<double, kStart, 1>;

WindowStart move_start(const WindowStart& start, const VectorS& by);
inline double calc_degrees(const Window& window) { return static_cast<double>(6 * window.count) + kPrior - kStart; }

// Predicts one window under one model.
class Predictor {
 public:
  Predictor(const TossProblem& problem, const Hypothesis& hypothesis, const Window& window);

  // Whitened: per sample position x y z, turn x y z; then what is known of the nuisances. False when it cannot be
  // simulated.
  bool run(const WindowStart& start, Eigen::VectorXd* residuals, std::vector<Regime>* regimes = nullptr);
  // Moves a start to the last sample of the window.
  bool run_on(WindowStart* start);
  // A true start state from the first readings: the sensor undone on local motion.
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
  Eigen::MatrixXd J;  // by the start state
  double misfit = kFailed;
  bool ok = false;
};

bool calc_start_jacobian(const TossProblem& problem, Predictor* predictor, WindowFit* fit);

// Levenberg-Marquardt on the start state of one window.
WindowFit fit_window(const TossProblem& problem, Predictor* predictor, const Window& window, const WindowStart& start,
                     int rounds);

// From readings over spans of different length, and from where it was before: the best.
WindowFit fit_window_afresh(const TossProblem& problem, const Hypothesis& hypothesis, const Window& window,
                            const WindowStart* warm);

}  // namespace hrp::diagnosis::toss
