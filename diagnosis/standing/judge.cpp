// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/judge.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/spatial/gravity.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/search/fit.h"
#include "diagnosis/standing/free_play.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kTurn = 0.3;  // [s] over which a gyroscope is compared with two attitudes
// Factor on a smoothing error, which is known to leading order only and is the same in all recordings.
constexpr double kLeadingOrder = 2;
// Of a sum of products over the root of their summed squares: with two lags in 80 equations, kNoChance is one robot of
// a thousand. Lags [windows]. Windows two apart do not overlap, and sensor filters forget within that time, while
// motion does not. An oscillation with a quarter period at one lag appears at the other.
constexpr size_t kLater[] = {2, 3};
constexpr size_t kThin = 3;  // one of so many samples ranks candidates

// Smallest plausible noise of a channel: rounding in files, contact of a stiff sole, and the error of an estimated
// attitude. Balance and efforts do not depend on the attitude: IMU, encoders and force sensors measure in the robot's
// axes.
double find_floor(const StandProblem& p, const Channel& c) {
  const double tilt = p.attitude_error;
  if (c.kind == ChannelKind::kTilt) return std::max(2e-5, tilt);
  if (c.kind == ChannelKind::kGap) return std::max(5e-6, 0.3 * tilt);  // feet some 0.3 m apart
  if (c.kind == ChannelKind::kStand || c.kind == ChannelKind::kBase) return 1e-5;
  if (c.kind == ChannelKind::kBalance) return 0.02;
  if (c.kind == ChannelKind::kGyro) return std::max(1e-4, std::sqrt(2) * tilt / kTurn);
  if (c.kind == ChannelKind::kVelocity) return 1e-4;
  return c.kind == ChannelKind::kGravity ? std::max(3e-3, kGravity * tilt) : 2e-3;
}

// One value a recording.
bool is_mean(const Channel& c) { return c.kind == ChannelKind::kGravity; }

// Most samples say nothing: each one that does is of many samples, and of others than the next.
bool is_sparse(const Channel& c) { return c.kind == ChannelKind::kGyro || is_mean(c); }

bool is_loose(const Hypothesis& h) {
  return std::any_of(h.begin(), h.end(), [](const Effect& e) { return get_row(e).loose; });
}

// First channel whose noise can be estimated. The position of a link in a loose transmission is read off the feet, so
// their residuals no longer contain all of the noise.
size_t find_first_sure(const StandProblem& p, const Hypothesis& h) {
  return is_loose(h) ? find_places(p) + count_places(p) : 0;
}

}  // namespace

StandJudge::StandJudge(const StandProblem& problem)
    : problem_(&problem), channels_(list_channels(problem)), sigma_(channels_.size(), 1e300) {
  for (size_t r = 0; r < problem.recordings.size(); ++r) (problem.recordings[r].train ? train_ : held_).push_back(r);
  if (held_.empty()) held_ = train_;
  if (train_.empty()) train_ = held_;
}

void StandJudge::update_sigma(const Evaluation& evaluation, const Hypothesis& h) {
  for (size_t c = find_first_sure(*problem_, h); c < channels_.size(); ++c) {
    const bool sparse = is_sparse(channels_[c]);
    std::vector<double> found;
    for (const StandBase& base : evaluation) {
      std::vector<double> one;
      for (size_t k = c; k < base.residuals.size(); k += channels_.size()) {
        const double v = base.residuals[k];
        if (v != 0 || !sparse) one.push_back(v == 0 ? std::nan("") : v);  // 0: the channel says nothing
      }
      const double noise = one.size() > 8 ? estimate_noise(one) : 0;
      if (noise > 0 || sigma_[c] == 1e300) found.push_back(noise);
    }
    if (found.empty()) continue;
    const double floor = find_floor(*problem_, channels_[c]);
    sigma_[c] = std::min(sigma_[c], std::max(floor, find_median(std::move(found))));
  }
}

// Squared noise of the mean of even and odd samples: a quarter of their squared difference.
std::vector<double> StandJudge::find_noise(const Evaluation& even, const Evaluation& odd) const {
  std::vector<double> out;
  for (size_t c = 0; c < channels_.size(); ++c) {
    double sum = 0, count = 0;
    for (size_t r = 0; r < even.size(); ++r) {
      for (size_t k = c; k < even[r].residuals.size(); k += channels_.size()) {
        const double a = even[r].residuals[k], b = odd[r].residuals[k];
        if (a != 0 && b != 0) {
          sum += 0.25 * (a - b) * (a - b);
          ++count;
        }
      }
    }
    out.push_back(count > 0 ? sum / count : 0);
  }
  return out;
}

// Squared error of smoothing, by channel. A local cubic's error (second derivative) grows with the square of its
// window. Windows wider by the root of two double it, so the difference equals the error. The product of both halves'
// differences contains no noise.
std::vector<double> StandJudge::find_smoothed_away(const std::array<Evaluation, 4>& halves) const {
  std::vector<double> sum(channels_.size(), 0.0), count(channels_.size(), 0.0);
  for (size_t r = 0; r < halves[0].size(); ++r) {
    const auto get = [&](size_t half, size_t k) { return halves[half][r].residuals[k]; };
    for (size_t k = 0; k < halves[0][r].residuals.size(); ++k) {
      if (get(0, k) == 0 || get(1, k) == 0 || get(2, k) == 0 || get(3, k) == 0) continue;
      sum[k % channels_.size()] += (get(2, k) - get(0, k)) * (get(3, k) - get(1, k));
      ++count[k % channels_.size()];
    }
  }
  for (size_t c = 0; c < sum.size(); ++c) {
    sum[c] = kLeadingOrder * kLeadingOrder * std::max(0.0, sum[c] / std::max(1.0, count[c]));
  }
  return sum;
}

void StandJudge::update_sigma(const Evaluation& all, const std::array<Evaluation, 4>& halves, const Hypothesis& h) {
  const std::vector<double> noise = find_noise(halves[0], halves[1]), away = find_smoothed_away(halves);
  if (problem_->held) {
    update_sigma(all, h);
    return set_reference(noise);
  }
  for (size_t c = find_first_sure(*problem_, h); c < channels_.size(); ++c) {
    const double found = std::max(find_floor(*problem_, channels_[c]), std::sqrt(noise[c] + away[c]));
    sigma_[c] = std::min(sigma_[c], found);
  }
  if (away_.empty()) away_ = away;
  for (size_t c = 0; c < away.size(); ++c) away_[c] = std::min(away_[c], away[c]);
  set_reference(noise);
}

// Like sigma_, the reference only decreases.
void StandJudge::set_reference(const std::vector<double>& noise) {
  if (reference_.empty()) reference_ = noise;
  for (size_t c = 0; c < noise.size(); ++c) {
    reference_[c] = std::min(reference_[c], noise[c]);
    sigma_[c] = std::max(sigma_[c], std::sqrt(reference_[c]));  // third differences of few samples may be zero
  }
}

// Mean product of a channel's even samples with odd samples `later` windows on, and the reverse, in units of squared
// noise; 0 if its size may be chance.
double StandJudge::find_memory(size_t c, size_t later, const Evaluation& even, const Evaluation& odd) const {
  double sum = 0, squares = 0, count = 0;
  for (size_t r = 0; r < even.size(); ++r) {
    const std::vector<int>& samples = problem_->recordings[r].samples;
    const int apart = static_cast<int>(later) * problem_->recordings[r].step;
    for (size_t k = 0; k + later < samples.size(); ++k) {
      const size_t first = k * channels_.size() + c, second = first + later * channels_.size();
      const double a[] = {even[r].residuals[first], odd[r].residuals[first]};
      const double b[] = {even[r].residuals[second], odd[r].residuals[second]};
      if (samples[k + later] - samples[k] != apart || a[0] == 0 || a[1] == 0 || b[0] == 0 || b[1] == 0) continue;
      const double product = 0.5 * (a[0] * b[1] + a[1] * b[0]) / (sigma_[c] * sigma_[c]);
      sum += product;
      squares += product * product;
      ++count;
    }
  }
  return std::abs(sum) > kNoChance * std::sqrt(squares) ? sum / count : 0;
}

std::vector<double> StandJudge::find_shared(const Evaluation& even, const Evaluation& odd) const {
  std::vector<double> out(channels_.size(), 0.0);
  for (size_t c = 0; c < channels_.size() && !problem_->held; ++c) {
    if (channels_[c].kind == ChannelKind::kGravity) continue;  // one value per recording
    const double floor = find_floor(*problem_, channels_[c]);
    const double granted = (floor * floor + (away_.empty() ? 0 : away_[c])) / (sigma_[c] * sigma_[c]);
    double most = 0;
    for (size_t later : kLater) most = std::max(most, std::abs(find_memory(c, later, even, odd)) - granted);
    if (most > kPart) out[c] = std::sqrt(most);
  }
  return out;
}

std::vector<double> StandJudge::find_extra_noise(const Evaluation& even, const Evaluation& odd) const {
  std::vector<double> out = find_noise(even, odd);
  for (size_t c = 0; c < out.size(); ++c) out[c] = std::max(0.0, out[c] - reference_[c]);
  return out;
}

// Squared rms [noise] that noise and smoothing leave in a channel. Third differences of overlapping windows make sigma_
// about a tenth too large. Below this limit a residual cannot be distinguished from noise.
double StandJudge::find_least(size_t channel) const {
  // One parameter takes all of a few means away, which is no merit unless they disagree.
  if (is_mean(channels_[channel])) return kAboveNoise * kAboveNoise;
  if (reference_.empty()) return 1;
  const double left = reference_[channel] + (away_.empty() ? 0 : away_[channel]);
  return std::clamp(left / (sigma_[channel] * sigma_[channel]), kPart, 1.0);
}

double StandJudge::add_channel(size_t c, const std::vector<size_t>& recordings, const Evaluation& evaluation,
                               double extra, StandFit* fit) const {
  double sum = 0, count = 0, said = 0;
  const double each = is_mean(channels_[c]) ? kCorrelated : 1;  // it is independent of all others
  for (size_t r : recordings) {
    const std::vector<double>& residuals = evaluation[r].residuals;
    for (size_t k = c; k < residuals.size(); k += channels_.size(), ++count) {
      sum += each * residuals[k] * residuals[k];
      if (residuals[k] != 0) said += each;  // 0 where friction holds the joint or a foot rolls over its edge
    }
  }
  sum = std::max(0.0, sum - said * extra);
  // Adds one independent sample of pure noise, because a few samples may be large by chance.
  const double square = (sum / (sigma_[c] * sigma_[c]) + kCorrelated) / (said + kCorrelated);
  if (channels_[c].kind == ChannelKind::kGyro) count = said;
  // A free link follows the noise of the feet, so a residual below the noise gains nothing.
  const bool free = c < find_places(*problem_) + count_places(*problem_) && is_loose(fit->hypothesis);
  fit->score += count * std::log(std::max(square, free ? 1.0 : find_least(c)));
  // Such a channel disagrees with the model.
  if (square > kAboveNoise * kAboveNoise) fit->mismatch += count * std::log(square);
  return std::sqrt(square);
}

// Training recordings count as well, since a few parameters cannot fit the noise of so many samples. add_effect()
// requires that held-out recordings improve, too.
StandFit StandJudge::judge(const Hypothesis& h, const Evaluation& evaluation, const std::vector<double>& extra) const {
  StandFit fit;
  fit.hypothesis = h;
  for (const Effect& e : h) {
    fit.score += kCorrelated * (static_cast<double>(e.p.size()) + find_doubt(*problem_, e));
  }
  const double parameters = fit.score;
  for (size_t c = 0; c < channels_.size(); ++c) {
    fit.channel_rms.push_back(add_channel(c, held_, evaluation, extra.empty() ? 0 : extra[c], &fit));
  }
  fit.held_score = fit.score - parameters;
  for (size_t c = 0; c < channels_.size() && train_ != held_; ++c) {
    fit.train_rms.push_back(add_channel(c, train_, evaluation, extra.empty() ? 0 : extra[c], &fit));
  }
  if (fit.train_rms.empty()) fit.train_rms = fit.channel_rms;
  return fit;
}

FitSelection StandJudge::select(const StandFit& so_far) const {
  FitSelection out{train_, {}};
  for (size_t c = 0; c < channels_.size(); ++c) {
    out.weight.push_back(1 / (sigma_[c] * std::clamp(so_far.channel_rms[c], 1.0, 3.0)));
  }
  return out;
}

bool StandJudge::is_quiet(double left, double before) {
  // Above kAboveNoise: with dozens of parameters, details of laws remain in the worst of some eighty equations, and so
  // do wide motions in the worst training recording.
  return left <= kSeveralTimes || left * left <= 1e-3 * before * before;
}

void fill_noise(StandProblems* p) {
  const Evaluation nominal = evaluate(p->all, {});
  StandJudge judge(p->all);
  judge.update_sigma(nominal, {});
  p->all.slack = find_slack(p->all, nominal);
  p->all.noise = judge.sigma();
  for (StandProblem* half : {&p->even, &p->odd, &p->wide_even, &p->wide_odd}) {
    half->slack = p->all.slack;
    half->noise = p->all.noise;
  }
}

void choose_laws(StandProblems* problems) {
  const StandProblem& all = problems->all;
  const size_t joints = all.effort.size();
  std::vector<char> both(joints, 0);
  for (size_t j = 0; j < joints; ++j) both[j] = all.effort[j] && all.command[j] && !all.held;
  if (!has(both, 1)) return;
  StandProblem* const each[] = {&problems->all, &problems->even, &problems->odd, &problems->wide_even,
                                &problems->wide_odd};
  std::vector<double> shared, noise[2];  // by channel; the noise with logs and with laws
  for (const bool law : {false, true}) {
    for (StandProblem* p : each) {
      p->law.assign(joints, false);
      for (size_t j = 0; j < joints && law; ++j) p->law[j] = both[j];  // without commands there is no law
    }
    const std::array<Evaluation, 4> halves{evaluate(problems->even, {}), evaluate(problems->odd, {}),
                                           evaluate(problems->wide_even, {}), evaluate(problems->wide_odd, {})};
    StandJudge judge(all);
    judge.update_sigma(evaluate(all, {}), halves, {});
    noise[law ? 1 : 0] = judge.sigma();
    if (!law) shared = judge.find_shared(halves[0], halves[1]);
  }
  for (size_t j = 0; j < joints; ++j) {
    const size_t c = find_drive(all, j);  // channel of its equation of motion; the next one compares log and law
    const bool better = both[j] && shared[c + 1] == 0 && noise[1][c] < kHalf * noise[0][c];
    for (StandProblem* p : each) p->law[j] = better;
  }
}

StandProblem make_coarse(StandProblem problem) {
  for (StandRecording& r : problem.recordings) {
    std::vector<int> few;
    for (size_t s = kThin / 2; s < r.samples.size(); s += kThin) few.push_back(r.samples[s]);
    r.samples = few;
    r.step *= static_cast<int>(kThin);
  }
  return problem;
}

Evaluation thin_out(const Evaluation& evaluation, size_t channels) {
  Evaluation out(evaluation.size());
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const std::vector<double>& all = evaluation[r].residuals;
    for (size_t at = kThin / 2 * channels; at < all.size(); at += kThin * channels) {
      const auto row = all.begin() + static_cast<long>(at);
      out[r].residuals.insert(out[r].residuals.end(), row, row + static_cast<long>(channels));
    }
  }
  return out;
}

double calc_deviations(const Eigen::VectorXd& vector, const Eigen::MatrixXd& covariance) {
  return std::sqrt(std::max(0.0, vector.dot(covariance.ldlt().solve(vector))));
}

Eigen::Vector2d find_tilting(const StandProblem& p) {
  Eigen::Vector2d sum(0, 0);
  double count = 0;
  for (const StandRecording& r : p.recordings) {
    for (int k : r.samples) {
      for (size_t f = 0; f < p.feet.size(); ++f, ++count) {
        const auto read = [&](size_t i) { return r.wrench[6 * f + i].value[static_cast<size_t>(k)]; };
        const Vector3d force(read(0), read(1), read(2)), torque(read(3), read(4), read(5));
        const Vector3d moment = torque - p.feet[f].bush.cross(force);
        for (int a = 0; a < 2; ++a) sum(a) += std::pow(moment(a) * find_give(p.feet[f], a), 2);
      }
    }
  }
  return (sum / (12 * std::max(1.0, count))).cwiseSqrt();
}

}  // namespace hrp::diagnosis::standing
