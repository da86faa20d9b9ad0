// SPDX-License-Identifier: BSD-3-Clause
// Measurement in torque space, for robots on a fixed base: at every joint and moment
//
//   missing = y - tau(q, v, a),   y: effort of the drive, recorded or by the servo's law; tau: inverse dynamics of the
//                                 nominal model along the smoothed motion, its own joint friction included, less what
//                                 the measured forces on its feet give (foot_loads.h). Joints without a drive: y = 0.
//
// Nothing is simulated, so it is well conditioned where a simulation from measured efforts drifts away. Effects are
// columns of missing = sum of column x parameter (torque_terms.h). Both sides pass the same zero-phase filter, so that
// neither is late against the other (Gautier, "Dynamic identification of robots with power model", ICRA 1997).
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/measurement/foot_loads.h"
#include "diagnosis/measurement/servo_law.h"
#include "diagnosis/measurement/velocity_log.h"

namespace hrp::diagnosis {

enum class EffortSource { kNone, kRecorded, kServoLaw };

// One recording on an even grid. Matrices: sample x joint; rad, rad/s, rad/s^2, N m.
struct TorqueRecording {
  size_t index = 0;  // in the experiment
  bool train = true;
  double begin = 0.0, step = 0.0;  // [s] of the full grid
  long stride = 1, trim = 0;       // every `stride`-th sample is kept, `trim` full samples are left out at both ends
  Eigen::MatrixXd q, v, a;         // smoothed, full grid
  Eigen::MatrixXd speed;           // v with less smoothing, full grid: laws with edges in speed, as dry friction, see this one
  Eigen::MatrixXd effort;          // y on the full grid, smoothed
  Eigen::MatrixXd effort_rate;     // [N m/s] of the smoothed y
  Eigen::MatrixXd command_rate;    // [N m/s] kp r' + kd r'': what a late command changes; zero without commands
  Eigen::MatrixXd tau;             // nominal inverse dynamics, full grid
  Eigen::MatrixXd load;            // [N m] full grid: what friction that grows with the load grows with
  Eigen::MatrixXd foot_wrench;     // full grid x 6 of every loaded foot, as recorded: force, torque
  Eigen::MatrixXd missing;         // kept samples x joint
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> use;  // kept samples x joint: the joint moves and y is known

  long kept() const { return missing.rows(); }
  long full_row(long kept_row) const { return trim + kept_row * stride; }
  double time(long kept_row) const { return begin + step * static_cast<double>(full_row(kept_row)); }
};

struct TorqueData {
  const Experiment* experiment = nullptr;
  double cutoff = 0.0;                  // [Hz] of every signal
  std::vector<EffortSource> source;     // by joint
  std::vector<LoadedFoot> feet;         // whose measured forces are in `tau`
  std::vector<ServoDelay> delays;       // of joints whose commands come late
  std::vector<ServoReading> servo;      // by joint: faults of its log against the servo's law, taken out of `effort`
  std::vector<VelocityReading> velocity;  // by joint: faults of positions and velocities against each other, taken out of all below
  // By joint: whether friction that grows with the load follows all that the drive gives, rotor and friction included, or
  // only the torque of the bodies behind the gear. Gears differ; the training recordings say which fits better.
  std::vector<char> loaded_by_drive;
  std::vector<double> slow;             // [rad/s] by joint: below it the direction of motion is not known
  std::vector<TorqueRecording> recordings;
  std::vector<size_t> frozen;           // recordings of the experiment whose log freezes
  std::vector<Vector3d> load_p_L;       // [m] by link: where a load is taken to hang, for its inertia about the link's frame
  bool behind_gears = false;            // tau was measured there: nothing of links, nor springs beside gears, is missing
  std::vector<std::string> warnings;    // stretches that are left out
  std::vector<std::string> missing;     // what was not recorded and what therefore is not judged, by file and column

  bool is_judged(int joint) const { return source[static_cast<size_t>(joint)] != EffortSource::kNone; }
  // A function of the full grid, filtered as everything else is, at the kept samples.
  Eigen::VectorXd condition(const TorqueRecording& recording, const Eigen::VectorXd& full) const;
  // Smooth sign of velocity on the full grid: tanh(speed / slow); and conditioned.
  Eigen::VectorXd calc_sign(const TorqueRecording& recording, int joint) const;
  Eigen::VectorXd calc_direction(const TorqueRecording& recording, int joint) const;
};

// Joints without position, or without both effort and servo law, get no rows. A recording that lacks the position of a
// moving joint is left out. Empty recordings: nothing can be judged; `missing` says why.
TorqueData make_torque_data(const Experiment& experiment);

// The same for a robot whose base moves or whose feet are loaded: `bodies` gives the nominal torques of a recording
// [N m], sample x joint of its full grid, from signals that pass the same filter, up to `cutoff` [Hz].
using BodyTorques = std::function<Eigen::MatrixXd(const TorqueRecording& recording, double cutoff)>;
TorqueData make_torque_data(const Experiment& experiment, const BodyTorques& bodies);

}  // namespace hrp::diagnosis
