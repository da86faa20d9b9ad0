// SPDX-License-Identifier: BSD-3-Clause
// Robots on a rail or stand whose feet touch or are fixed to the ground and whose foot forces are measured: equations
// of motion along the recorded motion, no simulation.
//
//   M(q) qdd + h(q, qd) - J^T F = tau
//
// F is the measured wrench on the foot. A row whose joint is pushed by an unknown force is left out; a joint without a
// drive has tau = 0. Where a foot is attached, the chain is closed and gives the position of a joint that was not
// recorded (the height on the rail).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/model/effect.h"
#include "diagnosis/model/nominal.h"

namespace hrp::diagnosis::held_feet {

using RowEffect = PlacedEffect;
using RowHypothesis = PlacedHypothesis;

// One recording, smoothed alike in every signal and thinned to about independent samples.
struct RowRecording {
  std::string file;
  bool train = true;
  std::vector<double> time;
  Eigen::MatrixXd q, qd, qdd, effort;                // sample x joint
  std::vector<Eigen::MatrixXd> wrench, wrench_rate;  // by sensor: sample x 6, force then torque, axes as recorded
  std::vector<char> rows;                            // by joint: its equation is used
  Eigen::MatrixXd clipped;                           // sample x joint: 1 where the effort stands at a limit: at least
                                                     // so much, how much the log does not say
  std::vector<char> sudden;                          // by sample: the foot force changes faster than smoothing follows
};

struct RowSensor {
  std::string name;
  int link = -1;
  bool world = false;   // axes of the reading
  bool torque = false;  // recorded
};

struct RowProblem {
  const Experiment* experiment = nullptr;
  NominalRobot nominal;
  std::vector<RowSensor> sensors;
  std::vector<RowRecording> recordings;
  std::vector<double> sigma;  // by joint: what each equation does on its own from one sample to the next
  double step = 0.0;          // [s] between samples
  std::vector<std::string> notes;
};

bool make_row_problem(const Experiment& experiment, RowProblem* problem, std::string* why);

// Residuals tau_recorded - tau_needed of a recording, flat [sample][joint], [N m or N]; NaN where a row is not used and
// in samples in which a joint is as good as at rest (what friction does there is not known).
std::vector<double> calc_rows(const RowProblem& problem, const RowHypothesis& hypothesis, size_t recording);

// Effects whose part in these equations is known at the places that they can be at.
std::vector<RowEffect> list_row_effects(const RowProblem& problem);

}  // namespace hrp::diagnosis::held_feet
