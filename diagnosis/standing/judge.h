// SPDX-License-Identifier: BSD-3-Clause
// How well a hypothesis agrees with the recordings it was not fitted to.
#pragma once

#include <array>

#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

constexpr double kMismatch = 2.0;  // a channel beyond this many noise deviations (rms) disagrees with the model
constexpr double kCorrelated = 8;  // samples that tell as much as one: errors of neighbours are alike

struct StandFit {
  Hypothesis hypothesis;
  std::vector<Eigen::VectorXd> std;         // by effect, by parameter
  std::vector<Eigen::MatrixXd> covariance;  // the same with what the parameters of one effect err alike
  std::vector<double> channel_rms;          // whitened, on the recordings that were not fitted
  std::vector<double> train_rms;            // the same on the others
  double score = 0;                         // sum over channels of n log(rms^2), not below the noise; lower is better
  double held_score = 0;                    // the part of it by the recordings that were not fitted
  double mismatch = 0;                      // the part of it by channels that disagree with the model
};

class StandJudge {
 public:
  // A fit of dozens of parameters leaves the details of laws in the worst of some eighty equations; so do wide motions
  // in the worst of the recordings that are not judged. More than what makes a mismatch where nothing was fitted.
  static constexpr double kLeftOver = 2.5;

  explicit StandJudge(const StandProblem& problem);

  const std::vector<Channel>& list() const { return channels_; }
  const std::vector<double>& sigma() const { return sigma_; }  // of each channel
  const std::vector<size_t>& train() const { return train_; }  // recordings

  // Noise of each channel under a hypothesis; once more is explained it can only get smaller. Even and odd samples
  // differ by noise alone, and wide windows from narrow ones, in both halves alike, by what smoothing takes away from
  // fast motion. Where values are held the halves share their noise: then third differences of the residual, which
  // fast disturbances enlarge. `halves`: at even samples, at odd ones, both with wide windows.
  void update_sigma(const Evaluation& all, const std::array<Evaluation, 4>& halves, const Hypothesis& hypothesis);
  void update_sigma(const Evaluation& all, const Hypothesis& hypothesis);  // by third differences

  // `extra`: noise [squared] by channel that the hypothesis itself adds, as find_extra_noise() has it; empty: none.
  StandFit judge(const Hypothesis& hypothesis, const Evaluation& evaluation,
                 const std::vector<double>& extra = {}) const;

  // A heavier link turns the same acceleration's noise into more force; that is no disagreement. Even and odd samples
  // differ by noise alone. Its square by channel, and how much more that is than under the reference.
  std::vector<double> find_noise(const Evaluation& even, const Evaluation& odd) const;
  std::vector<double> find_extra_noise(const Evaluation& even, const Evaluation& odd) const;

  // [noise deviations] By channel what even and odd samples of windows that do not overlap have in common, and noise
  // has not, though a sensor's filter colours it; 0 where that may be chance, or is less than half of the noise.
  std::vector<double> find_shared(const Evaluation& even, const Evaluation& odd) const;

  // Channels that stay far from their noise count less: whatever else is missing there must not bend the parameters.
  FitSelection select(const StandFit& so_far) const;

  // What is left of a channel [noise deviations] is noise, or a thousandth (of its power) of what there was.
  static bool is_quiet(double left, double before);

 private:
  double find_least(size_t channel) const;
  double find_memory(size_t channel, size_t later, const Evaluation& even, const Evaluation& odd) const;
  void set_reference(const std::vector<double>& noise);
  std::vector<double> find_smoothed_away(const std::array<Evaluation, 4>& halves) const;
  // Adds one channel over some recordings to a fit; returns its rms.
  double add_channel(size_t channel, const std::vector<size_t>& recordings, const Evaluation& evaluation, double extra,
                     StandFit* fit) const;
  const StandProblem* problem_;
  std::vector<Channel> channels_;
  std::vector<double> sigma_, reference_;  // reference_: as find_noise() has it, of the hypothesis that sigma_ is from
  std::vector<double> away_;               // square of what smoothing takes away
  std::vector<size_t> train_, held_;
};

// A log of efforts is as noisy as its sensor is wide: at a wrist it can hide what a hand weighs, and the servo law, by
// command and encoder, tells the same effort a hundred times better. So where log and law agree (all that even and odd
// samples share of their difference may be chance), and the equation of motion is then known twice as well, the law
// stands in it; the log is still held against the law.
void choose_laws(StandProblems* problems);

// The same problem with a third of the samples: enough to rank candidates by; and its rows of a whole evaluation.
StandProblem make_coarse(StandProblem problem);
Evaluation thin_out(const Evaluation& evaluation, size_t channels);

// So many deviations of a normal distribution, where the deviation itself is known from so many independent errors
// only: Student's t by Wallace's approximation, good to 1 % from four on.
double find_student(double normal, double degrees);

// Length of a vector of so many normal errors of deviation 1, one to three, that is exceeded as rarely as so many
// deviations of one error.
double find_length(double normal, size_t components);

// Deviations of a vector from nothing, whatever axes it is written in: sqrt(v^T C^-1 v).
double calc_deviations(const Eigen::VectorXd& vector, const Eigen::MatrixXd& covariance);

// Deviation of feet's roll and pitch [rad]: their moments (rms) times what ground and sole may give, evenly up to most.
Eigen::Vector2d find_tilting(const StandProblem& problem);

}  // namespace hrp::diagnosis::standing
