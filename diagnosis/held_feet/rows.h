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

#include "diagnosis/model/nominal.h"

namespace hrp::diagnosis::held_feet {

enum class RowEffectId {
  kViscous,
  kCoulomb,
  kLoadFriction,
  kRotorInertia,
  kTorqueConstant,
  kJointOffset,
  kSpring,
  kEffortBias,
  kMassError,
  kComError,
  kForceBias,
  kForceScale,
  kForceDelay,
  kForceMisalignment
};
constexpr int kRowEffects = 14;

struct RowParameter {
  const char* name;
  const char* unit;
  double neutral, step;
  bool positive;  // below neutral it means nothing
};

struct RowInfo {
  const char* effect;  // of the report
  const char* kind;    // joint, link, sensor
  const char* suffix;  // of a sensor's name
  std::vector<RowParameter> parameters;
  const char* phrase;
};
const RowInfo& get_row_info(RowEffectId id);

struct RowEffect {
  RowEffectId id;
  int place = 0;  // joint, link or wrench sensor
  std::vector<double> p;
};
using RowHypothesis = std::vector<RowEffect>;

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

// The effect with values that change nothing.
RowEffect make_neutral(RowEffectId id, int place);

}  // namespace hrp::diagnosis::held_feet
