// SPDX-License-Identifier: BSD-3-Clause
// Judges how well a hypothesis agrees with recordings, also those that it was not fitted to.
#pragma once

#include <array>

#include "diagnosis/estimate/limits.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

constexpr double kCorrelated = 8;  // samples that count as one independent sample: errors of neighbours are correlated

// A hypothesis with its score and its residuals by channel.
struct StandFit {
  Hypothesis hypothesis;
  std::vector<Eigen::VectorXd> std;         // by effect, by parameter
  std::vector<Eigen::MatrixXd> covariance;  // by effect: covariance of its parameters
  std::vector<double> channel_rms;          // rms in units of noise, by channel, held-out recordings
  std::vector<double> train_rms;            // the same on the training recordings
  double score = 0;       // sum over channels of n ln(rms^2), limited at the noise, plus priors; lower is better
  double held_score = 0;  // part of it from held-out recordings
  double mismatch = 0;    // part of it from channels that disagree with the model
};

// Knows the noise of each channel and scores hypotheses with it.
class StandJudge {
 public:
  explicit StandJudge(const StandProblem& problem);

  const std::vector<Channel>& list() const { return channels_; }
  const std::vector<double>& sigma() const { return sigma_; }  // noise of each channel, in the channel's unit
  const std::vector<size_t>& train() const { return train_; }  // indices of the training recordings

  // Updates the noise of each channel under a hypothesis. It only decreases, because a better model explains more. Even
  // and odd samples differ by noise alone. Wide and narrow windows differ, alike in both halves, by what smoothing
  // removes from fast motion. If sensors hold values, the halves share noise; then third differences of the residual
  // are used, which fast disturbances increase. `halves`: even, odd, and both with wide windows.
  void update_sigma(const Evaluation& all, const std::array<Evaluation, 4>& halves, const Hypothesis& hypothesis);
  void update_sigma(const Evaluation& all, const Hypothesis& hypothesis);  // from third differences

  // `extra`: squared noise by channel that the hypothesis adds, from find_extra_noise(); empty: none.
  StandFit judge(const Hypothesis& hypothesis, const Evaluation& evaluation,
                 const std::vector<double>& extra = {}) const;

  // A heavier link converts the same noise of acceleration to more force, which is no disagreement. find_noise: squared
  // noise by channel, from the difference of even and odd samples. find_extra_noise: its excess over the noise of the
  // reference hypothesis.
  std::vector<double> find_noise(const Evaluation& even, const Evaluation& odd) const;
  std::vector<double> find_extra_noise(const Evaluation& even, const Evaluation& odd) const;

  // By channel, in units of its noise: the rms that even and odd samples share in windows that do not overlap. Noise
  // shares nothing, even if a sensor's filter correlates it. 0 if it may be chance or is below half of the noise.
  std::vector<double> find_shared(const Evaluation& even, const Evaluation& odd) const;

  // Weights of a fit. Channels far above their noise count less, so unknown physics there bends the parameters less.
  FitSelection select(const StandFit& so_far) const;

  // True if the residual `left` of a channel [noise] is noise, or a thousandth of the power of `before`.
  static bool is_quiet(double left, double before);

 private:
  double find_least(size_t channel) const;
  double find_memory(size_t channel, size_t later, const Evaluation& even, const Evaluation& odd) const;
  void set_reference(const std::vector<double>& noise);
  std::vector<double> find_smoothed_away(const std::array<Evaluation, 4>& halves) const;
  // Adds one channel over some recordings to the score of a fit. Returns its rms [noise].
  double add_channel(size_t channel, const std::vector<size_t>& recordings, const Evaluation& evaluation, double extra,
                     StandFit* fit) const;
  const StandProblem* problem_;
  std::vector<Channel> channels_;
  std::vector<double> sigma_, reference_;  // reference_: find_noise() of the hypothesis that sigma_ is from
  std::vector<double> away_;               // squared residual that smoothing causes, by channel
  std::vector<size_t> train_, held_;
};

// Selects for each joint the effort log or the servo law as the effort in the equation of motion. An effort sensor's
// noise grows with its range, so at a wrist it can exceed the weight of a hand. The law, from command and encoder, may
// be a hundred times more precise. The law is selected if it agrees with the log (no significant shared residual) and
// halves the noise of the equation. The log is still compared with the law.
void choose_laws(StandProblems* problems);

// Fills in, for all five problems, the noise of each channel of the nominal robot and the torques that exceed it.
void fill_noise(StandProblems* problems);

// Problem with a third of the samples, enough to rank candidates. thin_out: its rows of a complete evaluation.
StandProblem make_coarse(StandProblem problem);
Evaluation thin_out(const Evaluation& evaluation, size_t channels);

// Distance of a vector from zero in standard deviations, independent of axes: sqrt(v^T C^-1 v).
double calc_deviations(const Eigen::VectorXd& vector, const Eigen::MatrixXd& covariance);

// Standard deviation of the feet's roll and pitch [rad] from unknown contact stiffness: rms moments times a compliance
// that is uniform between zero and find_give().
Eigen::Vector2d find_tilting(const StandProblem& problem);

}  // namespace hrp::diagnosis::standing
