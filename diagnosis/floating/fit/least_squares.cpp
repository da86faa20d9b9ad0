// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/least_squares.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/fit/normal_equations.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr int kLags = 25;    // rows, the most that errors remember
constexpr size_t kBins = 8;  // of rows by roughness

// [the unit] What gyroscopes and encoders leave whatever is fitted, or else accelerometers, force sensors and models.
double find_least(const std::string& unit) { return unit == "rad" || unit == "m" || unit == "rad/s" ? 1e-4 : 1e-3; }

}  // namespace

size_t LeggedFit::find_first(size_t effect) const {
  size_t first = 0;
  for (size_t i = 0; i < effect; ++i) first += effects[i].terms.size();
  return first;
}

Eigen::VectorXd LeggedFit::get(size_t effect) const {
  return x.segment(static_cast<long>(find_first(effect)), static_cast<long>(effects[effect].terms.size()));
}

LeggedFitter::LeggedFitter(std::vector<ChannelRows> table, int columns) : channels_(std::move(table)) {
  for (const ChannelRows& c : channels()) has_held_ = has_held_ || std::count(c.train.begin(), c.train.end(), 0) > 0;
  for (size_t c = 0; c < channels().size(); ++c) {
    const ChannelRows& rows = channels()[c];
    std::vector<int> local(static_cast<size_t>(columns), -1);
    for (size_t i = 0; i < rows.columns.size(); ++i) local[static_cast<size_t>(rows.columns[i])] = static_cast<int>(i);
    local_.push_back(std::move(local));
    rows_.emplace_back(rows.rows(), 1.0);
    const double least = std::max({find_least(rows.info.unit), rows.info.error, kExactShare * rows.scale});
    floor_.push_back(least * least);
  }
  weight_.assign(channels().size(), 1.0);
  memory_ = weight_;
  noise_.assign(channels().size(), 0.0);
  const std::vector<int> none;
  update_moments(&none);
  update_weights(fit({}));
}

// Of the columns `only`, or of all, those that the equation has, in turn.
std::vector<long> LeggedFitter::list_used(size_t c, const std::vector<int>* only) const {
  std::vector<long> out;
  if (!only) {
    out.resize(channels()[c].columns.size());
    std::iota(out.begin(), out.end(), 0L);
    return out;
  }
  for (int column : *only) {
    const auto i = static_cast<size_t>(column);
    if (i < local_[c].size() && local_[c][i] >= 0) out.push_back(local_[c][i]);
  }
  return out;
}

void LeggedFitter::update_moments(const std::vector<int>* only) {
  for (size_t part = 0; part < 2; ++part) {
    moments_[part].clear();
    counts_[part].clear();
  }
  for (size_t c = 0; c < channels().size(); ++c) {
    const ChannelRows& rows = channels()[c];
    const auto p = static_cast<long>(rows.columns.size());
    const std::vector<long> used = list_used(c, only);
    MomentSum sums[2] = {{p, used}, {p, used}};
    size_t n[2] = {0, 0};
    for (size_t i = 0; i < rows.rows(); ++i) {
      const size_t part = is_held(c, i) ? 1 : 0;
      sums[part].add(rows.row(i), rows.noise_row(i), rows.y[i], rows.noise_y[i], rows_[c][i]);
      ++n[part];
    }
    for (size_t part = 0; part < 2; ++part) {
      moments_[part].push_back(sums[part].take());
      counts_[part].push_back(n[part]);
    }
    const Moments &m0 = moments_[0][c], &m1 = moments_[1][c];
    noise_[c] = (m0.noise + m1.noise) / std::max(1e-300, m0.total + m1.total);
  }
}

// Errors grow with what the kernel takes away: the variance of each eighth of the rows, ordered by roughness, by its
// median, so that a few impacts do not set it; never less than that of a quieter eighth.
void LeggedFitter::update_row_weights(size_t c, const std::vector<double>& r) {
  const std::vector<double>& rough = channels()[c].roughness;
  const size_t bins = std::min(kBins, r.size() / static_cast<size_t>(kRowsPerColumn));
  if (bins < 2) return;
  std::vector<size_t> order(r.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t i, size_t k) { return rough[i] < rough[k]; });
  double variance = floor_[c], quietest = 0;
  for (size_t bin = 0; bin < bins; ++bin) {
    const size_t begin = bin * r.size() / bins, end = (bin + 1) * r.size() / bins;
    std::vector<double> sizes;
    for (size_t i = begin; i < end; ++i) sizes.push_back(std::abs(r[order[i]]));
    variance = std::max(variance, std::pow(find_deviation(std::move(sizes)), 2));
    if (bin == 0) quietest = variance;
    for (size_t i = begin; i < end; ++i) rows_[c][order[i]] = quietest / variance;
    if (!impacts_)
      dampen_impacts(c, {order.begin() + static_cast<long>(begin), order.begin() + static_cast<long>(end)});
  }
}

// Rows whose even and odd samples differ by more than noise weigh less: at an impact, neither tells what was between
// them. The rule uses noise alone, so that it puts no mismatch aside.
void LeggedFitter::dampen_impacts(size_t c, const std::vector<size_t>& bin) {
  const std::vector<double>& noise = channels()[c].noise_y;
  std::vector<double> sizes;
  for (size_t i : bin) sizes.push_back(std::abs(noise[i]));
  const double most = kOutlier * kOutlier * std::max(floor_[c], std::pow(find_deviation(std::move(sizes)), 2));
  for (size_t i : bin) rows_[c][i] *= std::min(1.0, std::pow(most / std::max(most, noise[i] * noise[i]), 2));
}

bool LeggedFitter::is_held(size_t channel, size_t row) const {
  const ChannelRows& c = channels()[channel];
  return has_held_ ? !c.train[row] : c.block[row] % 2 == 1;
}

double LeggedFitter::count_independent(Part part, size_t channel) const {
  return static_cast<double>(count(part, channel)) / memory_[channel];
}

// How many rows one error lasts for: one, and twice its correlations with the rows that follow.
double LeggedFitter::calc_memory(size_t c, std::vector<double> r) const {
  const ChannelRows& rows = channels()[c];
  for (size_t i = 0; i < r.size(); ++i) r[i] *= std::sqrt(rows_[c][i]);
  double zero = 1e-300, memory = 1;
  for (double v : r) zero += v * v;
  for (int lag = 1; lag <= kLags; ++lag) {
    double sum = 0;
    for (size_t i = static_cast<size_t>(lag); i < r.size(); ++i) {
      if (rows.recording[i] == rows.recording[i - static_cast<size_t>(lag)])
        sum += r[i] * r[i - static_cast<size_t>(lag)];
    }
    if (sum / zero < kMinor) break;
    memory += 2 * sum / zero;
  }
  return memory;
}

void LeggedFitter::update_weights(const LeggedFit& so_far, const std::vector<int>* only) {
  if (!so_far.x.allFinite()) return;
  for (size_t c = 0; c < channels().size(); ++c) update_row_weights(c, calc_residuals(so_far, c));
  update_moments(only);
  const LeggedFit fit = this->fit(so_far.effects);
  if (!fit.x.allFinite()) return;
  for (size_t c = 0; c < channels().size(); ++c) {
    memory_[c] = calc_memory(c, calc_residuals(fit, c));
    weight_[c] = 1 / (memory_[c] * (fit.mean_square[0][c] + floor(c)));
  }
}

std::vector<std::pair<int, double>> LeggedFitter::find_local(size_t channel, const Terms& terms) const {
  std::vector<std::pair<int, double>> out;
  for (const auto& [column, factor] : terms) {
    const int at = local_[channel][static_cast<size_t>(column)];
    if (at >= 0) out.emplace_back(at, factor);
  }
  return out;
}

bool LeggedFitter::changes(size_t channel, const Candidate& effect) const {
  return std::any_of(effect.terms.begin(), effect.terms.end(),
                     [&](const Terms& t) { return !find_local(channel, t).empty(); });
}

bool LeggedFitter::have_common_equation(const Candidate& a, const Candidate& b) const {
  for (size_t c = 0; c < channels().size(); ++c) {
    if (channels()[c].rows() > 0 && changes(c, a) && changes(c, b)) return true;
  }
  return false;
}

void LeggedFitter::add_normal(Part part, size_t c, const std::vector<Candidate>& effects, Eigen::MatrixXd* A,
                              Eigen::VectorXd* b) const {
  std::vector<std::vector<std::pair<int, double>>> local;
  bool any = false;
  for (const Candidate& e : effects) {
    for (const Terms& t : e.terms) {
      local.push_back(find_local(c, t));
      any = any || !local.back().empty();
    }
  }
  if (!any) return;
  const Moments& m = moments_[static_cast<size_t>(part)][c];
  for (size_t i = 0; i < local.size(); ++i) {
    for (const auto& [li, fi] : local[i]) {
      (*b)(static_cast<long>(i)) += weight_[c] * fi * m.b(li);
      for (size_t j = 0; j <= i; ++j) {
        double sum = 0;
        for (const auto& [lj, fj] : local[j]) sum += fj * m.G(li, lj);
        (*A)(static_cast<long>(i), static_cast<long>(j)) += weight_[c] * fi * sum;
      }
    }
  }
}

double LeggedFitter::calc_left(Part part, size_t c, const LeggedFit& fit) const {
  const Moments& m = moments_[static_cast<size_t>(part)][c];
  if (count(part, c) == 0) return 0;
  std::map<int, double> coefficient;
  long at = 0;
  for (const Candidate& e : fit.effects) {
    for (const Terms& t : e.terms) {
      for (const auto& [local, factor] : find_local(c, t)) coefficient[local] += factor * fit.x(at);
      ++at;
    }
  }
  double left = m.yy;
  for (const auto& [i, xi] : coefficient) {
    left -= 2 * xi * m.b(i);
    for (const auto& [j, xj] : coefficient) left += xi * xj * m.G(i, j);
  }
  return left / std::max(1e-300, m.total);
}

LeggedFit LeggedFitter::fit(const std::vector<Candidate>& effects, bool all) const {
  LeggedFit out;
  out.effects = effects;
  const long n = count_coefficients(effects);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (size_t c = 0; n > 0 && c < channels().size(); ++c) {
    add_normal(Part::kTrain, c, effects, &A, &b);
    if (all) add_normal(Part::kHeld, c, effects, &A, &b);
  }
  A = Eigen::MatrixXd(A.selfadjointView<Eigen::Lower>());
  add_priors(effects, &A, &b);
  out.x = n > 0 ? solve_scaled(A, b) : Eigen::VectorXd();
  for (const Part part : {Part::kTrain, Part::kHeld}) {
    for (size_t c = 0; c < channels().size(); ++c) {
      const double left = calc_left(part, c, out);
      out.signed_square[static_cast<size_t>(part)].push_back(left);
      out.mean_square[static_cast<size_t>(part)].push_back(std::max(0.0, left));
    }
  }
  return out;
}

std::pair<Eigen::VectorXd, Eigen::MatrixXd> LeggedFitter::fit_without(const std::vector<Candidate>& effects,
                                                                      size_t channel) {
  const double weight = weight_[channel];
  weight_[channel] = 0;
  const LeggedFit rest = fit(effects);
  std::pair<Eigen::VectorXd, Eigen::MatrixXd> out{rest.x,
                                                  rest.x.allFinite() ? calc_covariance(rest) : Eigen::MatrixXd()};
  weight_[channel] = weight;
  return out;
}

double LeggedFitter::calc_gain(Part part, size_t c, const LeggedFit& a, const LeggedFit& b) const {
  const auto p = static_cast<size_t>(part);
  if (count(part, c) == 0) return 0;
  const double from = std::min({0.0, a.signed_square[p][c], b.signed_square[p][c]});
  return count_independent(part, c) *
         std::log((a.signed_square[p][c] - from + floor(c)) / (b.signed_square[p][c] - from + floor(c)));
}

double LeggedFitter::calc_gain(Part part, const LeggedFit& a, const LeggedFit& b) const {
  double sum = 0;
  for (size_t c = 0; c < channels().size(); ++c) sum += calc_gain(part, c, a, b);
  return sum;
}

double LeggedFitter::calc_gain_after(size_t c, const LeggedFit& a, const LeggedFit& b) const {
  const double gain = calc_gain(Part::kTrain, c, a, b) + calc_gain(Part::kHeld, c, a, b);
  return gain == 0 ? 0 : gain * memory_[c] / calc_memory(c, calc_residuals(b, c));
}

double LeggedFitter::calc_gain_after(const LeggedFit& a, const LeggedFit& b) const {
  double sum = 0;
  for (size_t c = 0; c < channels().size(); ++c) sum += calc_gain_after(c, a, b);
  return sum;
}

Eigen::MatrixXd LeggedFitter::calc_columns(size_t c, const std::vector<Candidate>& effects, bool noise) const {
  const ChannelRows& rows = channels()[c];
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(static_cast<long>(rows.rows()), count_coefficients(effects));
  long at = 0;
  for (const Candidate& e : effects) {
    for (const Terms& t : e.terms) {
      for (const auto& [local, factor] : find_local(c, t)) {
        for (size_t i = 0; i < rows.rows(); ++i)
          X(static_cast<long>(i), at) += factor * (noise ? rows.noise_row(i) : rows.row(i))[local];
      }
      ++at;
    }
  }
  return X;
}

std::vector<double> LeggedFitter::calc_residuals(const LeggedFit& fit, size_t c, bool noise) const {
  std::vector<double> out = noise ? channels()[c].noise_y : channels()[c].y;
  if (fit.x.size() == 0) return out;
  const Eigen::VectorXd predicted = calc_columns(c, fit.effects, noise) * fit.x;
  for (size_t i = 0; i < out.size(); ++i) out[i] -= predicted(static_cast<long>(i));
  return out;
}

double LeggedFitter::calc_ceiling(size_t c) const {
  const Moments &train = moments_[0][c], &held = moments_[1][c];
  if (count(Part::kTrain, c) == 0 || count(Part::kHeld, c) == 0 || held.yy <= 0) return 0;
  double best = 0;
  for (const double ridge : {1e-4, 1e-3, 1e-2, 1e-1}) {
    const Eigen::VectorXd x = solve_scaled(train.G, train.b, ridge);
    best = std::max(best, (2 * x.dot(held.b) - x.dot(held.G * x)) / held.yy);
  }
  return std::min(1.0, best);
}

}  // namespace hrp::diagnosis::floating
