// SPDX-License-Identifier: BSD-3-Clause
// Missing torque of robots on a fixed base: at every joint and sample
//
//   missing = y - tau(q, v, a),   y: effort of the drive, recorded or by the servo's law; tau: inverse dynamics of the
//                                 nominal model along the smoothed motion, its own joint friction included, less what
//                                 the measured forces on its feet give (foot_loads.h). Joints without a drive: y = 0.
//
// A gear that gives moves the links otherwise than the drive. Where a second encoder shows it, and the training
// recordings fit better with it, tau is that of the links' motion; friction and rotors follow the drive's.
//
// No simulation is needed, so this stays well conditioned where a simulation from measured efforts would drift away.
// Effects are columns of missing = sum of column x parameter (torque/terms.h). Both sides pass the same zero-phase
// filter, so neither is delayed against the other (Gautier, "Dynamic identification of robots with power model", ICRA
// 1997).
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

// Columns of sensors behind the gears: this, the joint's name, "/position" or "/effort".
constexpr const char* kLinkSide = "/joint_states_link/";

enum class EffortSource { kNone, kRecorded, kServoLaw };

// One recording on an even grid. Matrices: sample x joint; rad, rad/s, rad/s^2, N m.
struct TorqueRecording {
  size_t index = 0;  // in the experiment
  bool train = true;
  double begin = 0.0, step = 0.0;          // [s] of the full grid
  long stride = 1, trim = 0;               // every `stride`-th sample is kept; `trim` samples are left out at both ends
  Eigen::MatrixXd q, v, a;                 // smoothed, full grid
  Eigen::MatrixXd link_q, link_v, link_a;  // of the links behind gears that give, full grid; empty: as q, v, a
  Eigen::MatrixXd speed;                   // v with less smoothing, full grid: for laws of friction
  Eigen::MatrixXd effort;                  // y on the full grid, smoothed
  Eigen::MatrixXd effort_rate;             // [N m/s] derivative of the smoothed y
  Eigen::MatrixXd command_rate;            // [N m/s] kp r' + kd r'': regressor of a late command; zero without commands
  Eigen::MatrixXd tau;                     // nominal inverse dynamics, full grid, smoothed
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> known;  // full grid x joint: tau is known; empty: everywhere
  // Torque of fast motion is curved, so the torque of the smoothed motion is not the smoothed torque. By how much they
  // differ for the nominal model; empty: not known.
  Eigen::MatrixXd filter_gap;
  Eigen::MatrixXd sharp_q, sharp_v,
      sharp_a;                  // with the sharpest filter, full grid; empty where the gap does not matter
  Eigen::MatrixXd load;         // [N m] full grid: regressor of load-dependent friction
  Eigen::MatrixXd foot_wrench;  // full grid x 6 of every loaded foot, as recorded: force, torque
  Eigen::MatrixXd missing;      // kept samples x joint
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> use;  // kept samples x joint: the joint moves and y is known

  long kept() const { return missing.rows(); }
  // Smoothed torque, from that of another model along the smoothed motion.
  Eigen::MatrixXd smooth_torque(const Eigen::MatrixXd& along) const {
    return filter_gap.size() > 0 ? along + filter_gap : along;
  }
  bool is_sharp() const { return sharp_q.size() > 0; }
  const Eigen::MatrixXd& get_link_q() const { return link_q.size() > 0 ? link_q : q; }
  const Eigen::MatrixXd& get_link_v() const { return link_v.size() > 0 ? link_v : v; }
  const Eigen::MatrixXd& get_link_a() const { return link_a.size() > 0 ? link_a : a; }
  long full_row(long kept_row) const { return trim + kept_row * stride; }
  double time(long kept_row) const { return begin + step * static_cast<double>(full_row(kept_row)); }
};

// A gear without an encoder behind it that gives under its load (soft_gears.h).
struct SoftGear {
  int joint = 0;
  double give = 0.0, std = 0.0;       // [rad/(N m)] compliance and its standard error
  Eigen::Vector4d motor{0, 0, 0, 0};  // rotor, viscous friction, dry friction, friction of the load: not on the gear
  double left = 1.0;                  // squares over those with a rigid gear
  bool applied = false;
};

// The missing torque of all recordings, with what was corrected and what is left out.
struct TorqueData {
  const Experiment* experiment = nullptr;
  double cutoff = 0.0;                    // [Hz] of the filter of all signals
  std::vector<EffortSource> source;       // by joint
  std::vector<LoadedFoot> feet;           // their measured forces are part of `tau`
  std::vector<ServoDelay> delays;         // joints whose commands are late
  std::vector<ServoReading> servo;        // by joint: faults of its log against the servo's law, corrected in `effort`
  std::vector<VelocityReading> velocity;  // by joint: faults of positions and velocities, corrected in all below
  // By joint: whether load-dependent friction grows with the drive's whole effort, rotor and friction included, or only
  // with the torque of the bodies behind the gear. Gears differ; the training recordings decide.
  std::vector<char> loaded_by_drive;
  std::vector<double> slow;  // [rad/s] by joint: below it the direction of motion is unknown
  std::vector<TorqueRecording> recordings;
  std::vector<size_t> frozen;         // indices of recordings whose log freezes
  std::vector<SoftGear> soft;         // gears that give; the links' motion is that behind those that are `applied`
  std::vector<Vector3d> load_p_L;     // [m] by link: assumed position of a load, for its inertia about the link's frame
  bool behind_gears = false;          // tau was measured there: links and springs beside gears do not contribute
  std::vector<std::string> warnings;  // about stretches that are left out
  std::vector<std::string> missing;   // by file and column: what was not recorded and is not judged

  bool is_judged(int joint) const { return source[static_cast<size_t>(joint)] != EffortSource::kNone; }
  // Filters a function of the full grid like all signals and returns its kept samples.
  Eigen::VectorXd condition(const TorqueRecording& recording, const Eigen::VectorXd& full) const;
  // Smooth sign of the velocity, tanh(speed / slow): on the full grid; and filtered at the kept samples.
  Eigen::VectorXd calc_sign(const TorqueRecording& recording, int joint) const;
  Eigen::VectorXd calc_direction(const TorqueRecording& recording, int joint) const;
};

// Angle of the encoder behind a joint's gear on the grid of `recording`, with the filter of all signals [rad].
Eigen::VectorXd read_link_angle(const Experiment& experiment, int joint, const TorqueRecording& recording,
                                double cutoff);

// Joints without position, or without both effort and servo law, have no rows. Recordings that lack the position of a
// moving joint are left out. Without any recording nothing can be judged, and `missing` says why.
TorqueData make_torque_data(const Experiment& experiment);

// The same if the base moves or the feet are loaded. `bodies` returns the nominal torques of a recording [N m], sample
// x joint of its full grid, from signals with the same filter up to `cutoff` [Hz]. NaN: not known, not judged.
using BodyTorques = std::function<Eigen::MatrixXd(const TorqueRecording& recording, double cutoff)>;
TorqueData make_torque_data(const Experiment& experiment, const BodyTorques& bodies);

}  // namespace hrp::diagnosis
