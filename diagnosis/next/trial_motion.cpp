// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/trial_motion.h"

#include <algorithm>

namespace hrp::diagnosis {
namespace {

constexpr double kStep = 0.001;  // [s] integration step; its error is far below the compared differences

Recording make_recording(const Recording& like, const Commands& commands, const std::vector<LoadSpec>& loads) {
  Recording r;
  r.spec.name = "next";
  r.spec.loads = loads;
  r.time = commands.time;
  r.joints.resize(like.joints.size());
  for (size_t j = 0; j < r.joints.size(); ++j) {
    r.joints[j].command = commands.position[j];
    r.joints[j].command_rate = commands.velocity[j];
    r.joints[j].signal[0] = commands.position[j];
  }
  return r;
}

void fill_readings(const Recording& like, const std::vector<double>& readings, size_t start, Recording* r) {
  const size_t width = r->joints.size() * kQuantities;
  for (size_t c = 0; c < width; ++c) {
    std::vector<double>& signal = r->joints[c / kQuantities].signal[c % kQuantities];
    signal.clear();
    if (like.joints[c / kQuantities].signal[c % kQuantities].empty()) continue;
    for (size_t k = 0; k < r->size(); ++k) signal.push_back(readings[std::max(k, start) * width + c]);
  }
}

}  // namespace

bool simulate_trial(const TrialMotion& motion, const Hypothesis& hypothesis, std::vector<double>* readings) {
  const Plant plant = make_plant(motion.experiment, hypothesis, motion.experiment.recordings[0].spec);
  RolloutOptions options;
  options.max_step = kStep;
  options.free_running = true;  // no pull to the commanded motion, as on a real robot
  return simulate_recording(plant, motion.experiment.recordings[0], motion.problem.smooth[0], options, readings);
}

std::unique_ptr<TrialMotion> make_trial_motion(const Experiment& bare, const Recording& like, const Commands& commands,
                                               const Hypothesis& truth, const std::vector<LoadSpec>& loads) {
  auto motion = std::make_unique<TrialMotion>();
  motion->experiment = bare;
  motion->experiment.recordings = {make_recording(like, commands, loads)};
  motion->problem = make_problem(motion->experiment, 1);
  std::vector<double> readings;
  if (!simulate_trial(*motion, truth, &readings)) return nullptr;
  fill_readings(like, readings, motion->problem.smooth[0].start, &motion->experiment.recordings[0]);
  motion->problem = make_problem(motion->experiment, 1);
  motion->problem.options.max_step = kStep;
  return motion;
}

std::unique_ptr<TrialMotion> make_followed_motion(const Experiment& bare, const Recording& like,
                                                  const Commands& commands,
                                                  const std::vector<std::vector<double>>& efforts,
                                                  const std::vector<LoadSpec>& loads) {
  auto motion = std::make_unique<TrialMotion>();
  motion->experiment = bare;
  motion->experiment.recordings = {make_recording(like, commands, loads)};
  std::vector<JointColumns>& joints = motion->experiment.recordings[0].joints;
  for (size_t j = 0; j < joints.size(); ++j) {
    joints[j].signal[1] = commands.velocity[j];
    joints[j].signal[2] = efforts[j];
  }
  motion->problem = make_problem(motion->experiment, 1);
  return motion;
}

}  // namespace hrp::diagnosis
