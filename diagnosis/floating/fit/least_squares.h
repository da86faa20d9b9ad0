// SPDX-License-Identifier: BSD-3-Clause
// One weighted least-squares fit of chosen effects over all equations. Each equation weighs what the best model so far
// leaves in it, not its noise: a law that is right but not alone keeps its significance (design of the evidence).
//
// Noise of an acceleration stands in a residual and in what it is explained by: plain least squares would take one for
// the other. Rows come from even and from odd samples, whose noise is independent. With m their mean and d half their
// difference, sums of (m m^T - d d^T) are products of one half with the other, without the noise's square (an
// instrumental-variable estimator). What is left is then mismatch alone; noise is known beside it.
#pragma once

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "diagnosis/floating/fit/candidates.h"
#include "diagnosis/floating/fit/moment_sum.h"
#include "diagnosis/floating/fit/row_table.h"

namespace hrp::diagnosis::floating {

// Of a quantity's spread, or of its size: to which models of rigid bodies and scales of sensors are exact.
constexpr double kExactShare = 5e-3;

// Rows that are fitted, and those that a fit is tried on.
enum class Part { kTrain, kHeld };

// What a hypothesis leaves.
struct LeggedFit {
  std::vector<Candidate> effects;
  Eigen::VectorXd x;                       // coefficients of all effects in turn
  std::vector<double> mean_square[2];      // weighted, noise taken out, by part, by channel; 0 where there are no rows
  std::vector<double> signed_square[2];    // the same, negative where halves differ by more than what is left
  size_t find_first(size_t effect) const;  // of an effect's coefficients in x
  Eigen::VectorXd get(size_t effect) const;
};

class LeggedFitter {
 public:
  LeggedFitter(std::vector<ChannelRows> channels, int columns);

  const std::vector<ChannelRows>& channels() const { return channels_; }
  size_t count(Part part, size_t channel) const { return counts_[static_cast<size_t>(part)][channel]; }
  // Square of what is left beside any mismatch: noise, and what no model is more exact than.
  double floor(size_t channel) const { return floor_[channel] + noise_[channel]; }
  // [unit of the channel] What no model is more exact than, noise aside. It may be the same in all recordings.
  double find_exactness(size_t channel) const { return std::sqrt(floor_[channel]); }
  // Independent rows of a channel, with the errors that `fit` leaves.
  double count_independent(Part part, size_t channel) const;
  bool is_held(size_t channel, size_t row) const;  // of the part that is not fitted

  // Whether rows in which even and odd samples differ by more than noise, at impacts, count in full.
  void count_impacts(bool in_full) { impacts_ = in_full; }
  // Weights from what a fit leaves, for the fits to come. Where the fit is not finite, or would not be with new weights
  // of rows, the weights of equations stay. `only`: columns that the next fits use; all others tell nothing until the
  // next call without.
  void update_weights(const LeggedFit& fit, const std::vector<int>* only = nullptr);
  // Fits, to the fitted rows or to all; not finite where the effects cannot be told apart at all.
  LeggedFit fit(const std::vector<Candidate>& effects, bool all = false) const;
  // The same coefficients from all equations but one: values, and their deviations by blocks (sandwich, fitted rows).
  std::pair<Eigen::VectorXd, Eigen::MatrixXd> fit_without(const std::vector<Candidate>& effects, size_t channel);
  // n log of what is left in `a` over what is left in `b`, over all channels: how much better b is. Where even and odd
  // samples differ by more than what is left, noise was less than that: both are counted from the lower one.
  double calc_gain(Part part, const LeggedFit& a, const LeggedFit& b) const;
  double calc_gain(Part part, size_t channel, const LeggedFit& a, const LeggedFit& b) const;
  // The same over all rows, with as many independent rows as b's errors leave: what a lacks may be the same all the
  // time, as a weight is, and one long error counts once; where b is right, nothing is left that remembers.
  double calc_gain_after(const LeggedFit& a, const LeggedFit& b) const;
  double calc_gain_after(size_t channel, const LeggedFit& a, const LeggedFit& b) const;
  // Of the coefficients: scatter of the scores of blocks (sandwich), of the fitted rows or of all.
  Eigen::MatrixXd calc_covariance(const LeggedFit& fit, bool all = false) const;
  // Of the coefficients: how far each moves where every equation errs by its exactness in line with that coefficient's
  // column. Equations err independently, rows of one do not.
  Eigen::VectorXd calc_systematic(const LeggedFit& fit) const;
  // The coefficients of one effect by recording, or by half where there is one recording only; the rest stays as it is.
  struct PartFit {
    Eigen::VectorXd x, weight;  // weight: the part's share of the information on each coefficient
  };
  std::vector<PartFit> fit_parts(const LeggedFit& fit, size_t effect) const;
  // By row: of the halves' mean, or half their difference.
  std::vector<double> calc_residuals(const LeggedFit& fit, size_t channel, bool noise = false) const;
  // Rows by coefficients: of the halves' mean, or half their difference.
  Eigen::MatrixXd calc_columns(size_t channel, const std::vector<Candidate>& effects, bool noise) const;
  // Whether an equation changes with an effect.
  bool changes(size_t channel, const Candidate& effect) const;
  // Whether any equation changes with both.
  bool have_common_equation(const Candidate& a, const Candidate& b) const;
  // Of two effects of one coefficient: the square of the correlation of what they predict, over all rows, without
  // noise.
  double calc_overlap(const Candidate& a, const Candidate& b) const;
  // Of a row against all others.
  double get_weight(size_t channel, size_t row) const { return weight_[channel] * rows_[channel][row]; }
  // Share of the held-out mismatch that all columns together take away, fitted freely to the training part.
  double calc_ceiling(size_t channel) const;

 private:
  std::vector<std::pair<int, double>> find_local(size_t channel, const Terms& terms) const;
  void add_normal(Part part, size_t channel, const std::vector<Candidate>& effects, Eigen::MatrixXd* A,
                  Eigen::VectorXd* b) const;
  double calc_left(Part part, size_t channel, const LeggedFit& fit) const;
  // Normal equations of one effect's coefficients, by recording * 2 + half (fit_parts).
  using Normal = std::pair<Eigen::MatrixXd, Eigen::VectorXd>;
  std::map<int, Normal> sum_parts(const LeggedFit& fit, size_t effect) const;

  std::vector<ChannelRows> channels_;
  std::vector<Moments> moments_[2];
  std::vector<size_t> counts_[2];
  double calc_memory(size_t channel, std::vector<double> residuals) const;
  void update_moments(const std::vector<int>* only);
  std::vector<long> list_used(size_t channel, const std::vector<int>* only) const;
  void update_row_weights(size_t channel, const std::vector<double>& residuals);
  void dampen_impacts(size_t channel, const std::vector<size_t>& bin);

  std::vector<double> floor_, noise_, weight_, memory_;
  std::vector<std::vector<double>> rows_;  // by channel: weights of rows against each other, 1 for the quietest
  std::vector<std::vector<int>> local_;    // by channel, by column
  bool has_held_ = false, impacts_ = false;
};

}  // namespace hrp::diagnosis::floating
