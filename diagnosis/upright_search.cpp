// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright_search.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/fit.h"

namespace hrp::diagnosis::upright {
namespace {

using Residuals = std::vector<std::vector<double>>;  // by recording, flat

constexpr double kMismatch = 2.0;    // a channel beyond this many noise deviations (rms) disagrees with the model
constexpr double kSignificant = 6;   // deviations by which a parameter must differ from no effect
constexpr double kGain = 150;        // least gain of the score; a clean recording's candidates gain below 40
constexpr size_t kRefined = 8;       // candidates that are fitted to the end in each round
constexpr size_t kMostEffects = 3;

// Smallest noise of a channel that is believed: what rounding in a file and contact of a stiff sole leave.
double find_floor(const Channel& c) {
  if (c.kind == "tilt") return 2e-5;
  if (c.kind == "gap") return 5e-6;
  if (c.kind == "balance") return 0.02;
  if (c.kind == "gyro") return 1e-3;
  return c.kind == "gravity" ? 3e-3 : 2e-3;
}

class Search {
 public:
  Search(const StandProblem& problem, int jobs, const Progress& progress) : p_(problem), jobs_(jobs), progress_(progress) {
    out_.channels = list_channels(problem);
    for (size_t r = 0; r < problem.recordings.size(); ++r) (problem.recordings[r].train ? train_ : held_).push_back(r);
    if (held_.empty()) held_ = train_;
  }

  StandOutcome run() {
    Residuals base = calc({});
    out_.sigma.assign(channels(), 1e300);
    update_sigma(base);
    out_.nominal = judge({}, base);
    out_.chosen = out_.nominal;
    out_.mismatch = worst(out_.nominal) > kMismatch;
    if (!find_slip_ratio(p_, &slip_ratio_, &slip_spread_)) slip_ratio_ = 0;
    while (out_.mismatch && worst(out_.chosen) > kMismatch && out_.chosen.hypothesis.size() < kMostEffects && add_effect(&base)) {
    }
    out_.explained = out_.mismatch && worst(out_.chosen) <= kMismatch;
    return std::move(out_);
  }

 private:
  size_t channels() const { return out_.channels.size(); }
  static double worst(const StandFit& fit) { return *std::max_element(fit.channel_rms.begin(), fit.channel_rms.end()); }

  Residuals calc(const StandHypothesis& h) const {
    Residuals out;
    for (size_t r = 0; r < p_.recordings.size(); ++r) out.push_back(calc_channels(p_, h, r));
    return out;
  }

  // Noise of each channel from the high frequencies of its residual; once more is explained it can only get smaller.
  void update_sigma(const Residuals& residuals) {
    for (size_t c = 0; c < channels(); ++c) {
      std::vector<double> found;
      for (const std::vector<double>& flat : residuals) {
        std::vector<double> one;
        for (size_t k = c; k < flat.size(); k += channels()) one.push_back(flat[k] == 0 ? std::nan("") : flat[k]);  // 0: says nothing
        const double noise = estimate_noise(one);
        if (noise > 0 || out_.sigma[c] == 1e300) found.push_back(noise);
      }
      if (found.empty()) continue;
      std::sort(found.begin(), found.end());
      out_.sigma[c] = std::min(out_.sigma[c], std::max(find_floor(out_.channels[c]), found[found.size() / 2]));
    }
  }

  StandFit judge(const StandHypothesis& h, const Residuals& residuals) const {
    StandFit fit;
    fit.hypothesis = h;
    for (size_t c = 0; c < channels(); ++c) {
      double sum = 0, count = 0, said = 0;
      for (size_t r : held_) {
        for (size_t k = c; k < residuals[r].size(); k += channels(), ++count) {
          sum += residuals[r][k] * residuals[r][k];
          said += residuals[r][k] != 0;  // where friction holds or a foot rolls over its edge nothing is said
        }
      }
      const double square = sum / std::max(1.0, said) / (out_.sigma[c] * out_.sigma[c]);
      fit.channel_rms.push_back(std::sqrt(square));
      fit.score += count * std::log(std::max(square, 1.0));
    }
    for (const StandEffect& e : h) fit.score += 8.0 * static_cast<double>(e.p.size());
    return fit;
  }

  // Derivatives of the residuals over the parameters of effects [first, end).
  std::vector<Residuals> differentiate(const StandHypothesis& h, size_t first, const Residuals& base) const {
    std::vector<Residuals> columns;
    for (size_t e = first; e < h.size(); ++e) {
      const StandInfo& info = get_stand_info(h[e].id);
      for (size_t i = 0; i < h[e].p.size(); ++i) {
        StandHypothesis moved = h;
        const double step = info.step[i % info.step.size()];
        if (step == 0) {  // a parameter that is read off, not fitted
          columns.push_back(base);
          for (std::vector<double>& flat : columns.back()) std::fill(flat.begin(), flat.end(), 0.0);
          continue;
        }
        moved[e].p[i] += step;
        Residuals d = calc(moved);
        for (size_t r = 0; r < d.size(); ++r) {
          for (size_t k = 0; k < d[r].size(); ++k) d[r][k] = (d[r][k] - base[r][k]) / step;
        }
        columns.push_back(std::move(d));
      }
    }
    return columns;
  }

  struct Step {
    Eigen::VectorXd delta;
    Eigen::MatrixXd covariance;
    bool ok = false;
  };

  // Gauss-Newton step on the training recordings. Channels that stay far from their noise count less: whatever else is
  // missing there must not bend the parameters. Covariance from the scatter of stretches of the scores (sandwich).
  Step solve(const std::vector<Residuals>& columns, const Residuals& base, bool with_covariance) const {
    const auto n = static_cast<long>(columns.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n), B = A;
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    const std::vector<double> weight = find_weights(base);
    for (size_t r : train_) {
      const size_t rows = base[r].size() / channels(), stretch = std::max<size_t>(1, rows / 20);
      Eigen::VectorXd score = Eigen::VectorXd::Zero(n), row(n);
      for (size_t k = 0; k < rows; ++k) {
        for (size_t c = 0; c < channels(); ++c) {
          const size_t at = k * channels() + c;
          for (long i = 0; i < n; ++i) row(i) = columns[static_cast<size_t>(i)][r][at] * weight[c];
          if (row.isZero(0)) continue;
          A.selfadjointView<Eigen::Lower>().rankUpdate(row);
          score += row * (base[r][at] * weight[c]);
        }
        if ((k + 1) % stretch == 0 || k + 1 == rows) b += score, B += score * score.transpose(), score.setZero();
      }
    }
    A = Eigen::MatrixXd(A.selfadjointView<Eigen::Lower>());
    Eigen::VectorXd scale = A.diagonal().cwiseSqrt();
    for (long i = 0; i < n; ++i) scale(i) = scale(i) > 0 ? 1 / scale(i) : 0;
    Eigen::MatrixXd S = scale.asDiagonal() * A * scale.asDiagonal();
    S.diagonal().array() += 1e-9;
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(S);
    Step step;
    step.delta = -(scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * b));
    step.ok = step.delta.allFinite();
    if (with_covariance) {
      const Eigen::MatrixXd inverse = scale.asDiagonal() * ldlt.solve(Eigen::MatrixXd(scale.asDiagonal()));
      const Eigen::MatrixXd sandwich = inverse * B * inverse;
      step.covariance = sandwich;
      // Not below what white noise alone would give: few stretches can agree by chance.
      for (long i = 0; i < n; ++i) {
        if (sandwich(i, i) < inverse(i, i)) step.covariance(i, i) = inverse(i, i);
      }
    }
    return step;
  }

  std::vector<double> find_weights(const Residuals& base) const {
    std::vector<double> weight(channels());
    for (size_t c = 0; c < channels(); ++c) {
      const double rms = base_rms_.empty() ? out_.sigma[c] : base_rms_[c];
      weight[c] = 1 / std::max(out_.sigma[c], std::min(rms, 3 * out_.sigma[c]));
    }
    (void)base;
    return weight;
  }

  void add_step(const Eigen::VectorXd& delta, size_t first, StandHypothesis* h) const {
    long at = 0;
    for (size_t e = first; e < h->size(); ++e) {
      for (double& p : (*h)[e].p) p += delta(at++);
    }
  }

  static bool is_sensible(const StandEffect& e) {
    const StandInfo& info = get_stand_info(e.id);
    if (info.positive && e.p[0] <= info.neutral[0]) return false;
    switch (e.id) {
      case StandId::kFootCompliance:
      case StandId::kFootHardening: {
        const size_t size = info.step.size();
        for (size_t at = 0; at < e.p.size(); at += size) {
          if (e.p[at] <= 0 || e.p[at + 4] <= 0 || e.p[at + 1] < -1e-3 || e.p[at + 5] < -1e-3) return false;
          if (size > kFootParameters && e.p[at + kFootParameters] <= 0) return false;
        }
        return true;
      }
      case StandId::kMassError:
      case StandId::kTorqueConstant:
      case StandId::kForceScale:
      case StandId::kTorqueScale:
        return e.p[0] > 0.1 && e.p[0] < 5;
      default:
        return true;
    }
  }

  static bool all_sensible(const StandHypothesis& h) { return std::all_of(h.begin(), h.end(), is_sensible); }
  std::vector<StandEffect> list_candidates(const StandHypothesis& base) const;
  bool add_effect(Residuals* base);
  void refine(size_t iterations, StandTrial* trial) const;
  bool is_significant(const StandFit& fit) const;

  const StandProblem& p_;
  int jobs_;
  Progress progress_;
  StandOutcome out_;
  std::vector<size_t> train_, held_;
  std::vector<double> base_rms_;
  double slip_ratio_ = 0, slip_spread_ = 0;
};

std::vector<StandEffect> Search::list_candidates(const StandHypothesis& base) const {
  std::vector<StandEffect> out;
  auto add = [&](StandId id, int place) {
    const StandInfo& info = get_stand_info(id);
    const bool feet = id == StandId::kFootCompliance || id == StandId::kFootHardening;
    for (const StandEffect& e : base) {
      if (e.id == id && e.place == place) return;
      if (feet && (e.id == StandId::kFootCompliance || e.id == StandId::kFootHardening)) return;
    }
    StandEffect effect{id, place, {}};
    for (size_t f = 0; f < (feet ? p_.feet.size() : 1); ++f) effect.p.insert(effect.p.end(), info.neutral.begin(), info.neutral.end());
    out.push_back(effect);
  };
  for (int j = 0; j < p_.tree.num_joints(); ++j) {
    add(StandId::kJointOffset, j);
    if (!p_.driven[static_cast<size_t>(j)]) continue;
    for (StandId id : {StandId::kViscous, StandId::kCoulomb, StandId::kRotorInertia, StandId::kSpring, StandId::kTorqueConstant}) add(id, j);
    if (p_.recordings[0].command[static_cast<size_t>(j)].value.empty()) continue;
    for (StandId id : {StandId::kCommandDelay, StandId::kActuatorLag, StandId::kEffortBias, StandId::kEffortScale}) add(id, j);
  }
  for (size_t link = 0; link < p_.tree.links.size(); ++link) {
    if (p_.tree.links[link].inertia.mass < 1e-6) continue;
    for (StandId id : {StandId::kMassError, StandId::kComError, StandId::kPayload, StandId::kExternalForce}) add(id, static_cast<int>(link));
  }
  for (StandId id : {StandId::kFootCompliance, StandId::kFootHardening, StandId::kGroundSlope}) add(id, 0);
  if (slip_ratio_ > 0) {
    add(StandId::kGroundFriction, 0);
    if (out.back().id == StandId::kGroundFriction) out.back().p[0] = slip_ratio_;
  }
  for (int foot = 0; foot < static_cast<int>(p_.feet.size()); ++foot) {
    for (StandId id : {StandId::kForceBias, StandId::kTorqueBias, StandId::kForceScale, StandId::kTorqueScale, StandId::kWrenchDelay,
                       StandId::kWrenchMisalignment, StandId::kWrenchSkew}) add(id, foot);
  }
  for (StandId id : {StandId::kGyroBias, StandId::kAccelerometerBias, StandId::kGyroScale, StandId::kAccelerometerScale, StandId::kImuDelay,
                     StandId::kImuMisalignment, StandId::kImuSkew}) add(id, 0);
  return out;
}

// Fits all effects together, the added one from its linear start.
void Search::refine(size_t iterations, StandTrial* trial) const {
  StandHypothesis h = trial->fit.hypothesis;
  Residuals base = calc(h);
  Step step;
  for (size_t i = 0; i <= iterations; ++i) {
    const bool last = i == iterations;
    step = solve(differentiate(h, 0, base), base, last);
    if (!step.ok || last) break;
    StandHypothesis next = h;
    add_step(step.delta, 0, &next);
    h = next;
    base = calc(h);
  }
  trial->fit = judge(h, base);
  trial->fit.covariance = step.covariance;
  trial->added = h.back();
  long at = 0;
  for (const StandEffect& e : h) {
    Eigen::VectorXd std(static_cast<long>(e.p.size()));
    for (long i = 0; i < std.size(); ++i, ++at) std(i) = e.id == StandId::kGroundFriction ? slip_spread_ / 3 : std::sqrt(std::max(0.0, step.covariance(at, at)));
    trial->fit.std.push_back(std);
  }
}

bool Search::is_significant(const StandFit& fit) const {
  const StandEffect& e = fit.hypothesis.back();
  const StandInfo& info = get_stand_info(e.id);
  for (size_t i = 0; i < e.p.size(); ++i) {
    const double std = fit.std.back()(static_cast<long>(i));
    if (std > 0 && std::abs(e.p[i] - info.neutral[i % info.neutral.size()]) > kSignificant * std) return true;
  }
  return false;
}

bool Search::add_effect(Residuals* base) {
  const StandHypothesis so_far = out_.chosen.hypothesis;
  base_rms_.clear();
  for (size_t c = 0; c < channels(); ++c) base_rms_.push_back(out_.chosen.channel_rms[c] * out_.sigma[c]);
  const std::vector<StandEffect> candidates = list_candidates(so_far);
  const std::vector<Residuals> shared = differentiate(so_far, 0, *base);
  std::vector<StandTrial> trials(candidates.size());
  parallel_for(jobs_, static_cast<int>(candidates.size()), [&](int i) {
    StandTrial& trial = trials[static_cast<size_t>(i)];
    StandHypothesis h = so_far;
    h.push_back(candidates[static_cast<size_t>(i)]);
    if (candidates[static_cast<size_t>(i)].id == StandId::kGroundFriction) {  // not differentiable: taken as it was seen
      trial.fit = judge(h, calc(h));
      return;
    }
    std::vector<Residuals> columns = shared;
    for (Residuals& column : differentiate(h, so_far.size(), *base)) columns.push_back(std::move(column));
    const Step step = solve(columns, *base, false);
    if (step.ok) add_step(step.delta, 0, &h);
    Residuals predicted = *base;  // the linear prediction: enough to rank
    for (size_t r = 0; step.ok && r < predicted.size(); ++r) {
      for (size_t c = 0; c < columns.size(); ++c) {
        for (size_t k = 0; k < predicted[r].size(); ++k) predicted[r][k] += columns[c][r][k] * step.delta(static_cast<long>(c));
      }
    }
    trial.fit = judge(h, predicted);
    if (!all_sensible(h)) trial.fit.score = 1e300;
  });
  const auto better = [](const StandTrial& a, const StandTrial& b) { return a.fit.score < b.fit.score; };
  std::stable_sort(trials.begin(), trials.end(), better);
  trials.resize(std::min(trials.size(), kRefined));
  parallel_for(jobs_, static_cast<int>(trials.size()), [&](int i) {
    StandTrial& trial = trials[static_cast<size_t>(i)];
    if (trial.fit.score >= 1e299) return;
    refine(3, &trial);
    if (!all_sensible(trial.fit.hypothesis)) trial.fit.score = 1e300;
  });
  std::stable_sort(trials.begin(), trials.end(), better);
  double total = 0;
  for (StandTrial& t : trials) total += t.probability = std::exp(std::max(-200.0, (trials[0].fit.score - t.fit.score) / 8));  // correlated samples: an eighth
  for (StandTrial& t : trials) t.probability /= total;
  const StandTrial& best = trials[0];
  if (progress_) progress_("best explanation " + std::string(get_stand_info(best.fit.hypothesis.back().id).effect) + ", score " + std::to_string(best.fit.score));
  out_.rounds.push_back(trials);
  if (best.fit.score >= 1e299 || out_.chosen.score - best.fit.score < std::max(kGain, 0.02 * out_.nominal.score) || !is_significant(best.fit)) return false;
  *base = calc(best.fit.hypothesis);
  const StandFit fitted = best.fit;
  update_sigma(*base);
  out_.nominal = judge({}, calc({}));
  out_.chosen = judge(fitted.hypothesis, *base);
  out_.chosen.std = fitted.std, out_.chosen.covariance = fitted.covariance;
  return true;
}

}  // namespace

StandOutcome search_standing(const StandProblem& problem, int jobs, const Progress& progress) { return Search(problem, jobs, progress).run(); }

const StandInfo& get_stand_info(StandId id) {
  using I = StandId;
  static const std::vector<StandInfo> infos{
      {I::kViscous, "viscous_friction", {"coefficient"}, {"N m s/rad"}, {0}, {0.1}, true},
      {I::kCoulomb, "coulomb_friction", {"level", "asymmetry"}, {"N m", "1"}, {0, 0}, {0.1, 0.02}, true},
      {I::kRotorInertia, "rotor_inertia", {"inertia"}, {"kg m^2"}, {0}, {0.01}, true},
      {I::kSpring, "parallel_spring", {"stiffness", ""}, {"N m/rad", "N m"}, {0, 0}, {1, 0.1}, true},
      {I::kTorqueConstant, "torque_constant_error", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kJointOffset, "joint_offset", {"offset"}, {"rad"}, {0}, {1e-3}, false},
      {I::kCommandDelay, "command_delay", {"delay"}, {"s"}, {0}, {1e-3}, true},
      {I::kActuatorLag, "actuator_lag", {"time_constant"}, {"s"}, {0}, {1e-3}, true},
      {I::kPayload, "payload", {"mass", "", "", ""}, {"kg", "", "", ""}, {0, 0, 0, 0}, {0.1, 0.01, 0.01, 0.01}, true},
      {I::kMassError, "mass_error", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kComError, "com_error", {"offset"}, {"m"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kExternalForce, "external_force", {"force"}, {"N"}, {0, 0, 0}, {1, 1, 1}, false},
      {I::kFootCompliance, "foot_compliance", {}, {}, {0, 0, 0, 0, 0, 0, 0, 0, 0}, {1e-5, 1e-5, 1e-7, 1e-7, 1e-5, 1e-5, 1e-7, 1e-7, 1e-8}, false},
      {I::kFootHardening, "foot_hardening", {}, {}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, {1e-5, 1e-5, 1e-7, 1e-7, 1e-5, 1e-5, 1e-7, 1e-7, 1e-8, 10}, false},
      {I::kGroundSlope, "ground_slope", {"roll", "pitch"}, {"rad", "rad"}, {0, 0}, {1e-3, 1e-3}, false},
      {I::kGroundFriction, "ground_friction", {"coefficient"}, {"1"}, {0}, {0}, false},
      {I::kForceBias, "sensor_bias", {"value"}, {"N"}, {0, 0, 0}, {0.1, 0.1, 0.1}, false},
      {I::kTorqueBias, "sensor_bias", {"value"}, {"N m"}, {0, 0, 0}, {0.01, 0.01, 0.01}, false},
      {I::kForceScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kTorqueScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kWrenchDelay, "sensor_delay", {"delay"}, {"s"}, {0}, {1e-2}, true},
      {I::kWrenchMisalignment, "sensor_misalignment", {"rpy"}, {"rad"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kWrenchSkew, "clock_skew", {"skew"}, {"1"}, {0}, {3e-3}, false},
      {I::kGyroBias, "sensor_bias", {"value"}, {"rad/s"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kAccelerometerBias, "sensor_bias", {"value"}, {"m/s^2"}, {0, 0, 0}, {1e-2, 1e-2, 1e-2}, false},
      {I::kGyroScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kAccelerometerScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false},
      {I::kImuDelay, "sensor_delay", {"delay"}, {"s"}, {0}, {1e-2}, true},
      {I::kImuMisalignment, "sensor_misalignment", {"rpy"}, {"rad"}, {0, 0, 0}, {1e-3, 1e-3, 1e-3}, false},
      {I::kImuSkew, "clock_skew", {"skew"}, {"1"}, {0}, {3e-3}, false},
      {I::kEffortBias, "sensor_bias", {"value"}, {"N m"}, {0}, {0.1}, false},
      {I::kEffortScale, "sensor_scale", {"scale"}, {"1"}, {1}, {0.01}, false}};
  for (const StandInfo& info : infos) {
    if (info.id == id) return info;
  }
  return infos[0];
}

}  // namespace hrp::diagnosis::upright
