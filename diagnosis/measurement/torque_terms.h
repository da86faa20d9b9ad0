// SPDX-License-Identifier: BSD-3-Clause
// Effects as columns of the missing torque (torque.h), and back from coefficients to parameters.
//
// Of one joint, in its own row; s is the smooth sign of its velocity:
//   viscous b v; dry c s; growing with load mu |tau| s; of a gear that the load drives
//   backwards mu |tau| s where tau s < 0; Stribeck (f_s - f_c) exp(-(v / v_s)^2) s; rotor J a;
//   true torque k times the effort: (1 - k) y, or (1/k - 1) tau; constant; spring k (q - rest); lag or delay T dy/dt;
//   late commands T (c(t) - c(t - T0)) / T0 with c = kp r + kd r', for several T0, of which the one nearest to T fits
//   best; cogging A sin(p q + phase).
// The factor k by either column: errors of tau (accelerations) draw the second one down, physics that is left out draws
// the first one up; the truth is between the two (errors in variables, Frisch's bounds).
// Of the whole robot, in every row: mass, centre of mass and load of a link (regressor of inverse dynamics), a constant
// force (-J^T F), an encoder's zero (-d tau / d q_j), the base turned against gravity (d tau / d roll, pitch), a
// share of gravity that no drive carries (tau without gravity less tau), and commands that are late at all joints alike: the column above in every row, as on one bus.
#pragma once

#include "common/effects/effect_info.h"
#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

enum class TermKind {
  kViscous, kDry, kLoadDry, kBackdriven, kStribeck, kRotor, kGain, kGainOfModel, kConstant, kSpring, kLag, kCommandDelay, kCogging,
  kPayload, kMassError, kComError, kForce, kOffset, kTilt, kCarried, kBusDelay
};

struct Term {
  TermKind kind;
  int place = 0;       // joint, or link
  double shape = 0.0;  // Stribeck velocity [rad/s], cogging [1/rad], delay T0 [s]
  int columns = 1;
  bool whole = false;  // rows of every joint, else of `place` alone
};

Term make_term(TermKind kind, int place, double shape = 0.0);

// (c(t) - c(t - T0)) / T0 at sample k of the full grid: the mean of c' over the last T0.
double calc_late(const TorqueRecording& recording, long joint, long k, double delay);

// Everything that is tried: terms of each joint that is judged, and terms of the whole robot.
std::vector<Term> list_joint_terms(const TorqueData& data, int joint);
std::vector<Term> list_whole_terms(const TorqueData& data);

// Columns of a joint's term in its row: kept samples x columns.
Eigen::MatrixXd calc_joint_columns(const TorqueData& data, const TorqueRecording& recording, const Term& term);

// Columns of all whole-robot terms in the rows of one recording: by joint, kept samples x all columns, terms in order.
std::vector<Eigen::MatrixXd> calc_whole_columns(const TorqueData& data, const TorqueRecording& recording,
                                                const std::vector<Term>& terms);

// The row of the table of effects.
EffectId get_effect_id(TermKind kind);
std::string get_effect_name(TermKind kind);
EffectFamily get_family(TermKind kind);

}  // namespace hrp::diagnosis
