// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright/judge.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis::upright {
namespace {

// A fit of dozens of parameters leaves the details of laws in the worst of some eighty equations; more than what makes
// a mismatch where nothing was fitted.
constexpr double kLeftOver = 2.5;
constexpr double kFew = 8;    // samples
constexpr size_t kThin = 3;  // one sample of so many is enough to rank candidates by

// Smallest noise of a channel that is believed: what rounding in a file and contact of a stiff sole leave, and the
// error of an attitude that was not recorded.
double find_floor(const StandProblem& p, const Channel& c) {
  const double tilt = p.attitude_error;
  double weight = 0;
  for (const LinkSpec& link : p.tree.links) weight += 9.81 * link.inertia.mass;
  if (c.kind == "tilt") return std::max(2e-5, tilt);
  if (c.kind == "gap") return std::max(5e-6, 0.3 * tilt);  // feet some 0.3 m apart
  if (c.kind == "stand" || c.kind == "base") return 1e-5;
  if (c.kind == "balance") return std::max(0.02, weight * tilt);
  if (c.kind == "effort") return std::max(2e-3, 0.3 * weight * tilt);
  if (c.kind == "gyro") return 1e-4;
  if (c.kind == "velocity") return 1e-4;
  return c.kind == "gravity" ? std::max(3e-3, 9.81 * tilt) : 2e-3;
}

}  // namespace

StandJudge::StandJudge(const StandProblem& problem)
    : problem_(&problem), channels_(list_channels(problem)), sigma_(channels_.size(), 1e300) {
  for (size_t r = 0; r < problem.recordings.size(); ++r) (problem.recordings[r].train ? train_ : held_).push_back(r);
  if (held_.empty()) held_ = train_;
  if (train_.empty()) train_ = held_;
}

void StandJudge::update_sigma(const Evaluation& evaluation) {
  for (size_t c = 0; c < channels_.size(); ++c) {
    const bool sparse = channels_[c].kind == "gyro";
    std::vector<double> found;
    for (const StandBase& base : evaluation) {
      std::vector<double> one;
      for (size_t k = c; k < base.residuals.size(); k += channels_.size()) {
        const double v = base.residuals[k];
        if (v != 0 || !sparse) one.push_back(v == 0 ? std::nan("") : v);  // 0: says nothing
      }
      const double noise = one.size() > 8 ? estimate_noise(one) : 0;
      if (noise > 0 || sigma_[c] == 1e300) found.push_back(noise);
    }
    if (found.empty()) continue;
    std::sort(found.begin(), found.end());
    const double floor = find_floor(*problem_, channels_[c]);
    sigma_[c] = std::min(sigma_[c], std::max(floor, found[found.size() / 2]));
  }
}

StandFit StandJudge::judge(const StandHypothesis& h, const Evaluation& evaluation) const {
  StandFit fit;
  fit.hypothesis = h;
  for (size_t c = 0; c < channels_.size(); ++c) {
    double sum = 0, count = 0, said = 0;
    for (size_t r : held_) {
      const std::vector<double>& residuals = evaluation[r].residuals;
      for (size_t k = c; k < residuals.size(); k += channels_.size(), ++count) {
        sum += residuals[k] * residuals[k];
        said += residuals[k] != 0;  // where friction holds or a foot rolls over its edge nothing is said
      }
    }
    // With as many samples of noise beside them as an rms needs: few may be large by chance.
    const double square = (sum / (sigma_[c] * sigma_[c]) + kFew) / (said + kFew);
    fit.channel_rms.push_back(std::sqrt(square));
    if (channels_[c].kind == "gyro") count = said;
    fit.score += count * std::log(std::max(square, 1.0));
    if (square > kMismatch * kMismatch) fit.mismatch += count * std::log(square);
  }
  for (const StandEffect& e : h) fit.score += kCorrelated * static_cast<double>(e.p.size());
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
  return left <= kLeftOver || left * left <= 1e-3 * before * before;
}

StandProblem make_coarse(StandProblem problem) {
  for (StandRecording& r : problem.recordings) {
    std::vector<int> few;
    for (size_t s = kThin / 2; s < r.samples.size(); s += kThin) few.push_back(r.samples[s]);
    r.samples = few;
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

}  // namespace hrp::diagnosis::upright
