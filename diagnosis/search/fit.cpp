// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/fit.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "diagnosis/search/parameters.h"

namespace hrp::diagnosis {
namespace {

using FreeParameter = Parameter<ParameterInfo>;

std::vector<FreeParameter> list_parameters(const Hypothesis& hypothesis, const std::vector<char>& frozen) {
  return flatten<ParameterInfo>(
      hypothesis, [](const Effect& e) -> const auto& { return get_effect(e.id).parameters; },
      [&](size_t e, const ParameterInfo& info) { return !info.scanned && !(e < frozen.size() && frozen[e]); });
}

// Sticking and slipping make readings a jagged function of friction: differences over 2 % see its trend.
double find_difference(EffectId id, const ParameterInfo& info, double value) {
  const bool sticks = id == EffectId::kCoulomb || id == EffectId::kStribeck || id == EffectId::kLoadFriction;
  return (sticks ? 0.02 : 0.005) * std::max(info.step, std::abs(value));
}

struct Normal {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  double chi2 = 0.0;
  bool ok = true;
  std::vector<Eigen::VectorXd> blocks;  // sums of score vectors over stretches of the recordings
};

// J^T J and J^T r of one recording from its residuals and those with each parameter moved.
Normal make_normal(const std::vector<std::vector<double>>& residuals, const std::vector<double>& deltas, bool blocks) {
  const size_t p = deltas.size(), size = residuals[0].size();
  Normal normal;
  normal.A.setZero(static_cast<long>(p), static_cast<long>(p));
  normal.b.setZero(static_cast<long>(p));
  Eigen::VectorXd row(static_cast<long>(p)), sum = Eigen::VectorXd::Zero(static_cast<long>(p));
  const size_t stretch = size / kIndependent + 1;
  for (size_t k = 0; k < size; ++k) {
    const double r = residuals[0][k];
    normal.chi2 += r * r;
    for (size_t i = 0; i < p; ++i) row[static_cast<long>(i)] = (residuals[i + 1][k] - r) / deltas[i];
    for (size_t i = 0; i < p; ++i) {
      const double x = row[static_cast<long>(i)];
      if (x == 0.0) continue;
      normal.b[static_cast<long>(i)] += x * r;
      for (size_t j = 0; j <= i; ++j)
        normal.A(static_cast<long>(i), static_cast<long>(j)) += x * row[static_cast<long>(j)];
    }
    if (!blocks) continue;
    sum += row * r;
    if ((k + 1) % stretch == 0 || k + 1 == size) {
      normal.blocks.push_back(sum);
      sum.setZero();
    }
  }
  normal.A = normal.A.selfadjointView<Eigen::Lower>();
  return normal;
}

void clamp(Hypothesis* hypothesis) {
  for (Effect& effect : *hypothesis) {
    const EffectInfo& info = get_effect(effect.id);
    for (size_t i = 0; i < effect.p.size(); ++i) {
      effect.p[i] = std::min(info.parameters[i].high, std::max(info.parameters[i].low, effect.p[i]));
    }
    if (effect.id == EffectId::kStribeck) effect.p[1] = std::max(effect.p[1], effect.p[0]);
  }
}

class Fitter {
 public:
  Fitter(const Problem& problem, const Hypothesis& start, const std::vector<int>& recordings, const FitOptions& options)
      : problem_(problem),
        recordings_(recordings),
        options_(options),
        hypothesis_(start),
        parameters_(list_parameters(start, options.frozen)) {
    clamp(&hypothesis_);
  }

  FitResult run() {
    FitResult result;
    double lambda = 1e-3;
    Normal normal = linearise(false);
    if (!normal.ok) return result;
    for (int i = 0; i < options_.max_iterations; ++i) {
      result.iterations = i + 1;
      const double before = normal.chi2;
      bool better = false;
      for (int attempt = 0; attempt < 5 && !better; ++attempt) {
        const Hypothesis trial = take_step(normal, lambda);
        const Score score = calc_score(problem_, trial, recordings_);
        better = score.ok && score.chi2 < before;
        if (better) {
          hypothesis_ = trial;
          last_ = score.chi2;
        }
        lambda = better ? std::max(1e-9, lambda * 0.1) : lambda * 8.0;
      }
      if (!better) break;
      if (i >= 2 && options_.abandon_above > 0.0 && last_ > options_.abandon_above) break;
      if (before - last_ < options_.tolerance * last_ + 0.5) break;
      normal = linearise(false);
      if (!normal.ok) break;
    }
    result.hypothesis = hypothesis_;
    result.train = calc_score(problem_, hypothesis_, recordings_);
    result.ok = result.train.ok;
    if (options_.intervals && result.ok) add_intervals(&result);
    return result;
  }

 private:
  // Residuals with every parameter moved, all recordings; the rollouts run in parallel.
  Normal linearise(bool blocks) {
    const size_t p = parameters_.size();
    std::vector<double> deltas;
    std::vector<Hypothesis> variants{hypothesis_};
    for (const FreeParameter& parameter : parameters_) {
      const double value = hypothesis_[parameter.effect].p[parameter.index];
      double delta = find_difference(hypothesis_[parameter.effect].id, *parameter.info, value);
      if (value + delta > parameter.info->high) delta = -delta;
      variants.push_back(hypothesis_);
      variants.back()[parameter.effect].p[parameter.index] += delta;
      deltas.push_back(delta);
    }
    const size_t n = recordings_.size();
    std::vector<std::vector<std::vector<double>>> residuals(n, std::vector<std::vector<double>>(p + 1));
    std::vector<char> ok(n * (p + 1), 1);
    parallel_for(problem_.jobs, static_cast<int>(n * (p + 1)), [&](int task) {
      const size_t r = static_cast<size_t>(task) / (p + 1), v = static_cast<size_t>(task) % (p + 1);
      ok[static_cast<size_t>(task)] = calc_residuals(problem_, variants[v], recordings_[r], &residuals[r][v]);
    });
    Normal total;
    total.A.setZero(static_cast<long>(p), static_cast<long>(p));
    total.b.setZero(static_cast<long>(p));
    total.ok = std::all_of(ok.begin(), ok.end(), [](char c) { return c != 0; });
    if (!total.ok) return total;
    for (size_t r = 0; r < n; ++r) {
      const Normal one = make_normal(residuals[r], deltas, blocks);
      total.A += one.A, total.b += one.b, total.chi2 += one.chi2;
      total.blocks.insert(total.blocks.end(), one.blocks.begin(), one.blocks.end());
    }
    return total;
  }

  Hypothesis take_step(const Normal& normal, double lambda) const {
    Eigen::MatrixXd A = normal.A;
    for (long i = 0; i < A.rows(); ++i) {
      const double step = parameters_[static_cast<size_t>(i)].info->step;
      A(i, i) = A(i, i) * (1.0 + lambda) + 1e-6 / (step * step);  // a direction without information stays where it is
    }
    const Eigen::VectorXd dx = A.ldlt().solve(-normal.b);
    Hypothesis trial = hypothesis_;
    for (size_t i = 0; i < parameters_.size(); ++i) {
      const double d = dx[static_cast<long>(i)];
      if (std::isfinite(d)) trial[parameters_[i].effect].p[parameters_[i].index] += d;
    }
    clamp(&trial);
    return trial;
  }

  // A^-1 B A^-1 with B from sums over stretches, at least A (times the mean square residual where that exceeds 1).
  void add_intervals(FitResult* result) {
    const Normal normal = linearise(true);
    if (!normal.ok) return;
    const long p = static_cast<long>(parameters_.size());
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(p, p);
    for (const Eigen::VectorXd& s : normal.blocks) B += s * s.transpose();
    const double inflate = std::max(1.0, result->train.chi2 / std::max(1.0, result->train.count));
    Eigen::MatrixXd A = normal.A;
    for (long i = 0; i < p; ++i) {
      const ParameterInfo& info = *parameters_[static_cast<size_t>(i)].info;
      A(i, i) += 1e-9 / (info.step * info.step);
      // What is known beforehand of the drive's timing: somewhere between its bounds (variance of a uniform
      // distribution). Without it a lag of the servo's rate and a rotor's inertia would be taken for the same thing.
      if (hypothesis_[parameters_[static_cast<size_t>(i)].effect].id == EffectId::kTiming)
        A(i, i) += 12.0 / std::pow(info.high - info.low, 2);
    }
    const Eigen::MatrixXd inverse = A.ldlt().solve(Eigen::MatrixXd::Identity(p, p));
    const Eigen::MatrixXd sandwich = inverse * B * inverse;
    result->std.clear();
    for (const Effect& effect : result->hypothesis) result->std.emplace_back(effect.p.size(), 0.0);
    for (long i = 0; i < p; ++i) {
      const FreeParameter& parameter = parameters_[static_cast<size_t>(i)];
      const double variance = std::max(inverse(i, i) * inflate, sandwich(i, i));
      result->std[parameter.effect][parameter.index] = std::sqrt(std::max(0.0, variance));
    }
  }

  const Problem& problem_;
  std::vector<int> recordings_;
  FitOptions options_;
  Hypothesis hypothesis_;
  std::vector<FreeParameter> parameters_;
  double last_ = 0.0;
};

}  // namespace

void parallel_for(int jobs, int count, const std::function<void(int, int)>& work) {
  const int threads = std::min(std::max(1, jobs), count);
  if (threads <= 1) {
    for (int i = 0; i < count; ++i) work(i, 0);
    return;
  }
  std::atomic<int> next{0};
  std::vector<std::thread> pool;
  for (int t = 0; t < threads; ++t) {
    pool.emplace_back([&, t] {
      for (int i = next++; i < count; i = next++) work(i, t);
    });
  }
  for (std::thread& thread : pool) thread.join();
}

void parallel_for(int jobs, int count, const std::function<void(int)>& work) {
  parallel_for(jobs, count, [&work](int i, int) { work(i); });
}

double Score::rms() const { return count > 0.0 ? std::sqrt(chi2 / count) : 0.0; }

void Score::add(const Score& other) {
  chi2 += other.chi2, count += other.count;
  if (signal_chi2.empty()) signal_chi2.assign(other.signal_chi2.size(), 0.0), signal_count = signal_chi2;
  for (size_t i = 0; i < other.signal_chi2.size(); ++i) {
    signal_chi2[i] += other.signal_chi2[i], signal_count[i] += other.signal_count[i];
  }
  ok = ok && other.ok;
}

Problem make_problem(const Experiment& experiment, int jobs) {
  Problem problem;
  problem.experiment = &experiment;
  problem.jobs = jobs;
  problem.smooth.resize(experiment.recordings.size());
  parallel_for(jobs, static_cast<int>(experiment.recordings.size()), [&](int r) {
    problem.smooth[static_cast<size_t>(r)] =
        smooth_recording(experiment, experiment.recordings[static_cast<size_t>(r)]);
  });
  for (const auto& joint : experiment.joint_noise) {
    for (const Noise& noise : joint) problem.weights.push_back(1.0 / noise.sigma);
  }
  for (size_t r = 0; r < experiment.recordings.size(); ++r) {
    (experiment.recordings[r].spec.train ? problem.train : problem.validate).push_back(static_cast<int>(r));
  }
  return problem;
}

namespace {

// Accelerations of a simulated link from its velocities, over +- 2 samples: they are smooth, only sampled.
constexpr int kLinkWindow = 2;

RobotPath make_path(const Problem& problem, const Plant& plant, int recording) {
  const size_t r = static_cast<size_t>(recording);
  const Recording& data = problem.experiment->recordings[r];
  const RobotPath* slopes = problem.nominal_paths[r].empty() ? nullptr : &problem.nominal_paths[r];
  RobotPath path = calc_path(plant, problem.smooth[r], slopes, {});
  std::vector<LinkMotion> links(plant.laws.size());
  bool elastic = false;
  for (size_t j = 0; j < plant.laws.size(); ++j) {
    if (!plant.laws[j].elastic) continue;
    std::vector<double> readings(data.size() * problem.weights.size(), 0.0);
    std::vector<LinkMotion> moved;
    if (!simulate_joint(plant, data, problem.smooth[r], path, static_cast<int>(j), problem.options, &readings, &moved))
      continue;
    links[j] = moved[j];
    for (size_t k = 0; k < problem.smooth[r].start; ++k) links[j].q[k] = path[j].q[k], links[j].qd[k] = path[j].qd[k];
    smooth_series(data.time, links[j].qd, kLinkWindow, nullptr, &links[j].qdd, nullptr);
    elastic = true;
  }
  if (elastic) path = calc_path(plant, problem.smooth[r], slopes, links);
  return path;
}

}  // namespace

void prepare_paths(Problem* problem) {
  const size_t count = problem->experiment->recordings.size();
  const Plant plant = make_plant(*problem->experiment, {});
  problem->nominal_paths.assign(count, {});
  Paths paths(count);
  parallel_for(problem->jobs, static_cast<int>(count),
               [&](int r) { paths[static_cast<size_t>(r)] = make_path(*problem, plant, r); });
  problem->nominal_paths = std::move(paths);
}

Paths make_paths(const Problem& problem, const Hypothesis& hypothesis) {
  const Plant plant = make_plant(*problem.experiment, hypothesis);
  Paths paths(problem.smooth.size());
  parallel_for(problem.jobs, static_cast<int>(paths.size()),
               [&](int r) { paths[static_cast<size_t>(r)] = make_path(problem, plant, r); });
  return paths;
}

namespace {

// Readings that a hypothesis predicts along the recorded paths.
bool predict_along(const Problem& problem, const Plant& plant, int recording, std::vector<double>* readings) {
  const Recording& data = problem.experiment->recordings[static_cast<size_t>(recording)];
  const SmoothRecording& smooth = problem.smooth[static_cast<size_t>(recording)];
  RobotPath own;
  if (!problem.view.paths) own = make_path(problem, plant, recording);
  const RobotPath& path = problem.view.paths ? (*problem.view.paths)[static_cast<size_t>(recording)] : own;
  const int n = problem.experiment->num_joints();
  readings->assign(data.size() * static_cast<size_t>(n) * kQuantities, 0.0);
  for (int j = 0; j < n; ++j) {
    if (problem.view.joint >= 0 && problem.view.joint != j) continue;
    if (!simulate_joint(plant, data, smooth, path, j, problem.options, readings)) return false;
  }
  apply_faults(plant, data, readings);
  return true;
}

size_t first_channel(const Problem& problem) {
  return problem.view.joint < 0 ? 0 : static_cast<size_t>(problem.view.joint) * kQuantities;
}
size_t count_channels(const Problem& problem) { return problem.view.joint < 0 ? problem.weights.size() : kQuantities; }

}  // namespace

bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording,
                    std::vector<double>* residuals) {
  const size_t r = static_cast<size_t>(recording);
  const StartState* start = r < problem.starts.size() ? &problem.starts[r] : nullptr;
  return calc_residuals(problem, hypothesis, recording, problem.options, start, residuals);
}

bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording, const RolloutOptions& options,
                    const StartState* start, std::vector<double>* residuals) {
  const Recording& data = problem.experiment->recordings[static_cast<size_t>(recording)];
  const SmoothRecording& smooth = problem.smooth[static_cast<size_t>(recording)];
  const Plant plant = make_plant(*problem.experiment, hypothesis);
  std::vector<double> readings;
  const bool ok = problem.view.along ? predict_along(problem, plant, recording, &readings)
                                     : simulate_recording(plant, data, smooth, options, &readings, start);
  if (!ok) return false;
  const bool corrected =
      !problem.view.along && options.until == 0.0 && static_cast<size_t>(recording) < problem.step_errors.size();
  const std::vector<double> none, &error = corrected ? problem.step_errors[static_cast<size_t>(recording)] : none;
  for (size_t i = 0; i < error.size(); ++i) readings[i] += error[i];
  const size_t width = problem.weights.size(), first = first_channel(problem), count = count_channels(problem);
  size_t rows = data.size();
  if (options.until > 0.0) {
    const auto end = std::upper_bound(data.time.begin(), data.time.end(), data.time[smooth.start] + options.until);
    rows = static_cast<size_t>(end - data.time.begin());
  }
  residuals->assign(rows * count, 0.0);
  for (size_t k = options.until > 0.0 ? smooth.start : smooth.judged; k < rows; ++k) {
    for (size_t c = 0; c < count; ++c) {
      const std::vector<double>& column = data.joints[(first + c) / kQuantities].signal[(first + c) % kQuantities];
      if (column.empty() || !std::isfinite(column[k])) continue;
      (*residuals)[k * count + c] = (column[k] - readings[k * width + first + c]) * problem.weights[first + c];
    }
  }
  return true;
}

Score calc_score(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings) {
  std::vector<Score> scores(recordings.size());
  const size_t width = problem.weights.size(), first = first_channel(problem), channels = count_channels(problem);
  parallel_for(problem.jobs, static_cast<int>(recordings.size()), [&](int i) {
    Score& score = scores[static_cast<size_t>(i)];
    score.signal_chi2.assign(width, 0.0), score.signal_count.assign(width, 0.0);
    const int r = recordings[static_cast<size_t>(i)];
    std::vector<double> residuals;
    score.ok = calc_residuals(problem, hypothesis, r, &residuals);
    if (!score.ok) return;
    const Recording& data = problem.experiment->recordings[static_cast<size_t>(r)];
    for (size_t c = 0; c < channels; ++c) {
      const std::vector<double>& column = data.joints[(first + c) / kQuantities].signal[(first + c) % kQuantities];
      if (column.empty()) continue;
      double &chi2 = score.signal_chi2[first + c], &count = score.signal_count[first + c];
      for (size_t k = problem.smooth[static_cast<size_t>(r)].judged; k < data.size(); ++k) {
        chi2 += residuals[k * channels + c] * residuals[k * channels + c];
        count += std::isfinite(column[k]) ? 1.0 : 0.0;
      }
      score.chi2 += chi2, score.count += count;
    }
  });
  Score total;
  for (const Score& score : scores) total.add(score);
  return total;
}

FitResult fit(const Problem& problem, const Hypothesis& start, const std::vector<int>& recordings,
              const FitOptions& options) {
  return Fitter(problem, start, recordings, options).run();
}

}  // namespace hrp::diagnosis
