// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/problem.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/search/subtrees.h"
#include "diagnosis/search/trust.h"

namespace hrp::diagnosis {

double Score::rms() const { return count > 0.0 ? std::sqrt(chi2 / count) : 0.0; }

double Score::rms(size_t signal) const {
  if (signal >= signal_count.size()) return 1e300;  // no rollout has stayed finite
  return signal_count[signal] > 0.0 ? std::sqrt(signal_chi2[signal] / signal_count[signal]) : 0.0;
}

double Score::worst() const {
  double largest = 0.0;
  for (size_t c = 0; c < signal_chi2.size(); ++c) largest = std::max(largest, rms(c));
  return largest;
}

void Score::add(const Score& other) {
  chi2 += other.chi2;
  count += other.count;
  if (signal_chi2.empty()) {
    signal_chi2.assign(other.signal_chi2.size(), 0.0);
    signal_count = signal_chi2;
  }
  for (size_t i = 0; i < other.signal_chi2.size(); ++i) {
    signal_chi2[i] += other.signal_chi2[i];
    signal_count[i] += other.signal_count[i];
  }
  ok = ok && other.ok;
}

const std::vector<int>& get_judged(const Problem& problem) {
  return problem.validate.empty() ? problem.train : problem.validate;
}

Problem make_problem(const Experiment& experiment, int jobs) {
  Problem problem;
  problem.experiment = &experiment;
  problem.jobs = jobs;
  problem.smooth.resize(experiment.recordings.size());
  // Standing robots are smoothed elsewhere, from even and odd samples (standing/data.h).
  const int smoothed = experiment.scenario.floating_base ? 0 : static_cast<int>(experiment.recordings.size());
  parallel_for(jobs, smoothed, [&](int r) {
    problem.smooth[static_cast<size_t>(r)] =
        smooth_recording(experiment, experiment.recordings[static_cast<size_t>(r)]);
  });
  for (const auto& joint : experiment.joint_noise) {
    for (const Noise& noise : joint) problem.weights.push_back(1.0 / noise.sigma);
  }
  for (size_t r = 0; r < experiment.recordings.size(); ++r) {
    (experiment.recordings[r].spec.train ? problem.train : problem.validate).push_back(static_cast<int>(r));
    if (!experiment.scenario.floating_base) problem.trust.push_back(find_trust(problem, r));
  }
  return problem;
}

double get_weight(const Problem& problem, size_t recording, size_t sample, size_t channel) {
  const double weight = problem.weights[channel];
  if (recording >= problem.trust.size() || problem.trust[recording].empty()) return weight;
  return weight * static_cast<double>(problem.trust[recording][sample * problem.weights.size() + channel]);
}

namespace {

// Accelerations of a simulated link are derived from its velocities over +- 2 samples; these have no noise.
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
    for (size_t k = 0; k < problem.smooth[r].start; ++k) {
      links[j].q[k] = path[j].q[k];
      links[j].qd[k] = path[j].qd[k];
    }
    smooth_series(data.time, links[j].qd, kLinkWindow, nullptr, &links[j].qdd, nullptr);
    elastic = true;
  }
  if (elastic) path = calc_path(plant, problem.smooth[r], slopes, links);
  return path;
}

}  // namespace

void prepare_paths(Problem* problem) {
  const size_t count = problem->experiment->recordings.size();
  problem->nominal_paths.assign(count, {});
  problem->nominal_paths = make_paths(*problem, {});
}

Paths make_paths(const Problem& problem, const Hypothesis& hypothesis) {
  const Plant plant = make_plant(*problem.experiment, hypothesis);
  Paths paths(problem.smooth.size());
  parallel_for(problem.jobs, static_cast<int>(paths.size()), [&](int r) {
    const size_t i = static_cast<size_t>(r);
    paths[i] = make_path(problem, add_by_hand(plant, problem.experiment->recordings[i].spec), r);
  });
  return paths;
}

namespace {

// Readings that a hypothesis predicts along recorded paths.
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
  if (!problem.subtrees.empty()) return calc_subtree_residuals(problem, hypothesis, recording, residuals);
  const size_t r = static_cast<size_t>(recording);
  const StartState* start = r < problem.starts.size() ? &problem.starts[r] : nullptr;
  return calc_residuals(problem, hypothesis, recording, problem.options, start, residuals);
}

bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording, const RolloutOptions& options,
                    const StartState* start, std::vector<double>* residuals) {
  const size_t r = static_cast<size_t>(recording);
  const Recording& data = problem.experiment->recordings[r];
  const SmoothRecording& smooth = problem.smooth[r];
  const Plant plant = make_plant(*problem.experiment, hypothesis, data.spec);
  std::vector<double> readings;
  const bool ok = problem.view.along ? predict_along(problem, plant, recording, &readings)
                                     : simulate_recording(plant, data, smooth, options, &readings, start);
  if (!ok) return false;
  const bool corrected = !problem.view.along && options.until == 0.0 && r < problem.step_errors.size();
  const std::vector<double> none, &error = corrected ? problem.step_errors[r] : none;
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
      (*residuals)[k * count + c] =
          (column[k] - readings[k * width + first + c]) * get_weight(problem, r, k, first + c);
    }
  }
  return true;
}

Score calc_score(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings,
                 std::vector<std::vector<double>>* all) {
  std::vector<Score> scores(recordings.size());
  if (all) all->resize(recordings.size());
  const size_t width = problem.weights.size(), first = first_channel(problem), channels = count_channels(problem);
  parallel_for(problem.jobs, static_cast<int>(recordings.size()), [&](int i) {
    Score& score = scores[static_cast<size_t>(i)];
    score.signal_chi2.assign(width, 0.0);
    score.signal_count.assign(width, 0.0);
    const int r = recordings[static_cast<size_t>(i)];
    std::vector<double> own, &residuals = all ? (*all)[static_cast<size_t>(i)] : own;
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
      score.chi2 += chi2;
      score.count += count;
    }
  });
  Score total;
  for (const Score& score : scores) total.add(score);
  return total;
}

}  // namespace hrp::diagnosis
