// SPDX-License-Identifier: BSD-3-Clause
// Hypotheses about a tossed body, fitted to the poses through simulation over short windows. Each window has a start
// state of its own, which is estimated along with everything else: it is not known.
#pragma once

#include "diagnosis/toss/effects.h"

namespace hrp::diagnosis::toss {

struct WindowStart : BodyState {
  Vector3d ground{0, 0,
                  0};  // [m, rad, rad] height, roll, pitch of the ground in the tracker's eyes, beyond the model's
};

struct TossFit {
  Hypothesis hypothesis;
  std::vector<WindowStart> starts;       // by window
  std::vector<double> misfit;            // by window: mean square of whitened residuals per degree of freedom
  std::vector<std::vector<double>> std;  // by effect, by parameter: from scores summed over tosses, so that it holds
                                         // whatever is left in a toss is correlated with
  // By effect, by parameter: standard deviation of its value from toss to toss, beyond what noise makes of it: a law
  // that is not quite the right one has no one value.
  std::vector<std::vector<double>> spread;
  Eigen::MatrixXd covariance;
  double train = 0.0, validate = 0.0;  // root mean square of whitened residuals (noise = 1)
  // The same without the twentieth of the windows that is worst: near an edge or a corner two motions can be as likely,
  // and the estimate of a start may end at the wrong one.
  double typical_train = 0.0, typical_validate = 0.0;
  std::vector<double> cost;  // by toss: robust, see calc_cost()
  double train_cost = 0.0, validate_cost = 0.0;
};

// Predicted readings against recorded ones, whitened: per sample position x y z, turn x y z. Empty when the simulation
// failed.
std::vector<double> calc_window_residuals(const TossProblem& problem, const Hypothesis& hypothesis,
                                          const Window& window, const WindowStart& start,
                                          std::vector<Regime>* regimes = nullptr);

struct TossFitOptions {
  int jobs = 1;
  int rounds = 6;                          // of the parameters
  const std::vector<char>* use = nullptr;  // by toss: parameters are fitted to these; all of role train where null
};

// Start states under the hypothesis as it stands.
TossFit fit_starts(const TossProblem& problem, const Hypothesis& hypothesis, const TossFit* warm, int jobs);

// Parameters and start states. Start states are found for every window, parameters from the windows in `use`.
TossFit fit_tosses(const TossProblem& problem, const TossFit& start, const TossFitOptions& options);

// How far the cost of the training recordings would fall with each candidate added to the fit, to first order.
std::vector<double> calc_gains(const TossProblem& problem, const TossFit& fit, const std::vector<EffectId>& candidates,
                               int jobs);

// What a window adds to the cost: 2 n log(1 + misfit / 4), that of residuals whose scale is not known: a window in
// which the prediction took another branch (edge instead of corner) does not outweigh all others.
double calc_cost(double misfit, double degrees);

}  // namespace hrp::diagnosis::toss
