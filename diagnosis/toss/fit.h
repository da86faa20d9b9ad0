// SPDX-License-Identifier: BSD-3-Clause
// Fits hypotheses about a tossed body to its poses, by simulation over short windows. The start state of each window is
// unknown and is estimated with the parameters.
#pragma once

#include "diagnosis/toss/effects.h"

namespace hrp::diagnosis::toss {

// Nuisance parameters of a window: start state, and the ground as the tracker measures it.
struct WindowStart : BodyState {
  Vector3d ground{0, 0,
                  0};  // height [m], roll, pitch [rad] of the ground as the tracker measures it, minus the model's
};

// A hypothesis fitted to windows, with its errors on training and held-out tosses.
struct TossFit {
  Hypothesis hypothesis;
  std::vector<WindowStart> starts;       // by window
  std::vector<double> misfit;            // by window: mean squared whitened residual per degree of freedom
  std::vector<std::vector<double>> std;  // by effect, by parameter; robust, with tosses as clusters,
                                         // so it includes any correlation within a toss
  // By effect, by parameter: standard deviation of its value between tosses, beyond the noise. A law that is only
  // approximately right has no single value.
  std::vector<std::vector<double>> spread;
  Eigen::MatrixXd covariance;
  double train = 0.0, validate = 0.0;  // rms of whitened residuals (noise = 1)
  // The same without the worst twentieth of the windows. Near an edge or a corner two motions can be equally likely,
  // and the estimated start state may be that of the wrong one.
  double typical_train = 0.0, typical_validate = 0.0;
  std::vector<double> cost;  // by toss: robust, see calc_cost()
  double train_cost = 0.0, validate_cost = 0.0;
};

// Whitened residuals of predicted and recorded poses, per sample: position x y z, rotation x y z. Empty if the
// simulation failed.
std::vector<double> calc_window_residuals(const TossProblem& problem, const Hypothesis& hypothesis,
                                          const Window& window, const WindowStart& start,
                                          std::vector<Regime>* regimes = nullptr);

struct TossFitOptions {
  int jobs = 1;
  int rounds = 6;                          // iterations over the parameters
  const std::vector<char>* use = nullptr;  // by toss: parameters are fitted to these; null: those of role train
};

// Estimates the start states under a fixed hypothesis. `warm`: start values, or null.
TossFit fit_starts(const TossProblem& problem, const Hypothesis& hypothesis, const TossFit* warm, int jobs);

// Estimates parameters and start states: start states of all windows, parameters from the tosses in `use`.
TossFit fit_tosses(const TossProblem& problem, const TossFit& start, const TossFitOptions& options);

// First-order estimate of the reduction of the training cost for each candidate, if it were added to the fit.
std::vector<double> calc_gains(const TossProblem& problem, const TossFit& fit, const std::vector<EffectId>& candidates,
                               int jobs);

// Cost of a window, 2 n ln(1 + misfit / 4), as for residuals of unknown scale (Student's t). A window whose prediction
// took another branch (edge instead of corner) then does not dominate the sum. `degrees`: n, degrees of freedom.
double calc_cost(double misfit, double degrees);

}  // namespace hrp::diagnosis::toss
