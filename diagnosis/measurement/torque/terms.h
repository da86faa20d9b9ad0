// SPDX-License-Identifier: BSD-3-Clause
// Effects as columns of the missing torque (torque.h), and the conversion from coefficients to parameters.
//
// Terms of one joint, in its own rows; s is the smooth sign of its velocity:
//   viscous b v; Coulomb c s; load-dependent mu |tau| s; of a gear that the load drives backwards mu |tau| s where
//   tau s < 0; Stribeck (f_s - f_c) exp(-(v / v_s)^2) s; rotor J a;
//   true torque k times the effort: (1 - k) y, or (1/k - 1) tau; constant; spring k (q - rest); lag or delay T dy/dt;
//   hysteresis k q_y z, z the state of a Bouc-Wen element along the recorded motion, for several yield angles q_y;
//   late commands T (c(t) - c(t - T0)) / T0 with c = kp r + kd r', for several T0, of which the one nearest to T fits
//   best; an effort that is logged T late -T (y(t + T0) - y(t)) / T0; cogging A sin(p q + phase).
// The two columns of the factor k give bounds. Errors of tau (accelerations) bias the second one low, missing physics
// biases the first one high, and the true value is between them (errors in variables, Frisch's bounds).
//
// Terms of the whole robot, in every joint's rows: mass, centre of mass and load of a link (regressor of inverse
// dynamics), a constant force (-J^T F), an encoder's zero (-d tau / d q_j), a tilted base (d tau / d roll, pitch), a
// share of gravity that no drive carries (tau without gravity - tau), and commands that are late at all joints alike
// (the column above, as on one bus).
#pragma once

#include "common/effects/effect_info.h"
#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

struct TermRow;
class WholeColumns;  // measurement/torque/whole_columns.cpp

// An effect at a place with a fixed shape: columns of the missing torque.
struct Term {
  const TermRow* row = nullptr;
  int place = 0;       // joint, or link
  double shape = 0.0;  // Stribeck velocity [rad/s], cogging [1/rad], delay T0 [s], yield angle [rad]

  int columns() const;
  bool whole() const;  // in the rows of every joint, else of `place` only
  const EffectInfo& effect() const;
};

// Parameters of a term in the order of the effect's row, with standard deviations.
struct TermValues {
  std::vector<double> value, std;
};

// Shapes of load-dependent friction: it grows with the bodies' torque behind the gear, or with the drive's whole
// effort.
constexpr double kLoadOfBodies = 0.0, kLoadOfDrive = 1.0;

// A kind of term: its row in the table of effects, and what only the missing torque needs. To add a term, add a row
// (term_rows.cpp, whole_columns.cpp) and its column; evidence, grades, wording and pages read the fields.
struct TermRow {
  const EffectInfo* effect = nullptr;
  PlaceKind place = PlaceKind::kJoint;  // kJoint, kLink; kNone: the base
  int columns = 1;
  // Columns in the joint's own rows: kept samples x columns; null for terms in the rows of every joint.
  Eigen::MatrixXd (*calc_columns)(const TorqueData& data, const TorqueRecording& recording, const Term& term) = nullptr;
  // Columns in the rows of every joint for one sample: joint x columns.
  void (WholeColumns::*fill_columns)(const Term& term, Eigen::Ref<Eigen::MatrixXd> columns) = nullptr;
  // Shapes to try at a joint or link; an empty list: no such term there. Null: one term without a shape.
  std::vector<double> (*list_shapes)(const TorqueData& data, int place) = nullptr;
  // Convert coefficients x with standard deviations s to parameters, and parameters to coefficients; null: they are the
  // same.
  TermValues (*make_values)(const Term& term, const Eigen::VectorXd& x, const Eigen::VectorXd& s) = nullptr;
  Eigen::VectorXd (*make_coefficients)(const std::vector<double>& values) = nullptr;
  // [nats] prior cost of the term; lowest for effects that every drive has.
  double cost = 3.0;
  const char* motion = "";  // that would distinguish it from other terms
  // Physical range of the first coefficient, or of the norm: friction opposes motion, inertias and delays are positive.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool by_norm = false;
  bool within_reach = false;  // the coefficients are a position [m] within the link's reach
  double material = 0.0;      // smallest norm that counts; smaller ones occur in every drive or encoder
  bool whole = false;         // in the rows of every joint
  bool needs_drive = false;  // only at joints with a motor and their links; of the whole robot: only if a joint has one
  bool usual = false;        // every drive has it
  bool of_motor_and_gear = false;  // losses and rotors; once they are known, the drive is
  bool scanned = false;            // a joint's models contain at most one of its shapes
  bool only_beside_all = false;  // tried only if it is worth its cost beside all other terms, which explain much of it
  bool late = false;             // late commands
  bool of_log = false;           // a fault of the recorded effort, not of the joint
  bool factor = false;           // the parameter is 1 + coefficient, with a prior around one
  bool level = false;            // Coulomb friction, independent of the load
  bool by_load = false;          // load-dependent friction
  bool excess = false;           // Stribeck excess over a level; needs one, and is reported with it
  bool memory = false;           // depends on past positions; needs dry friction, whose pre-sliding looks like it
  double least_shape = 0.0;      // terms of at most this shape only serve for comparison
  bool backwards = false;        // of a gear that the load drives
  bool scales_effort = false;  // the drive's gain, by the recorded effort; its column by the model is next in the list
  bool scales_model = false;   // the drive's gain, by the model's torque: the other bound
  bool load = false;           // a carried mass and its position: contains wrong mass and centre of mass of the link
  bool pulls = false;          // a force in any direction
  bool moves_model = false;    // its columns move the model, so they are computed after the others
  int constant = -1;           // index of a constant column; -1: none
  int shape_parameter = -1;    // index of the parameter that is the shape; -1: none

  bool allows(const Eigen::VectorXd& coefficients, double reach = 0.0) const;
  bool is_dry() const { return level || by_load; }
  bool is_constant() const { return constant == 0; }  // and nothing else
  // A spring has a constant part. It always fits as well as a constant torque, so it is no rival of one.
  bool contains(const TermRow& smaller) const { return constant > 0 && smaller.is_constant(); }
  // A displaced zero, or a law that has a constant part: near one posture they are the same.
  bool is_like_zero() const { return effect->family == EffectFamily::kZero || constant >= 0; }
  bool is_of_bus() const { return late && whole; }  // common to all joints
  bool is_of_mass() const { return effect->family == EffectFamily::kMass; }
};

// All rows, those of joints first. If an effect has several rows, reports are read with the first one.
const std::vector<TermRow>& list_term_rows();
// First row with a property; there must be one.
const TermRow& find_term_row(bool TermRow::*property);

// (c(t) - c(t - T0)) / T0 [N m/s] at sample k of the full grid: mean of c' over the last T0.
double calc_late(const TorqueRecording& recording, long joint, long k, double delay);
// (y(t) - y(t - T0)) / T0 [N m/s] at sample k of the full grid: the same of efforts that are commands.
double calc_gone(const TorqueRecording& recording, long joint, long k, double delay);
// Which of the two is the regressor of late commands to this joint's drive.
using CalcLate = double (*)(const TorqueRecording& recording, long joint, long k, double delay);
CalcLate find_late(const TorqueData& data, int joint);
// (y(t + T0) - y(t)) / T0 [N m/s] at sample k of the full grid: regressor of a late log.
double calc_coming(const TorqueRecording& recording, long joint, long k, double delay);

// All terms to try: of each judged joint, and of the whole robot.
std::vector<Term> list_joint_terms(const TorqueData& data, int joint);
std::vector<Term> list_whole_terms(const TorqueData& data);

// Columns of a joint's term in its row: kept samples x columns.
Eigen::MatrixXd calc_joint_columns(const TorqueData& data, const TorqueRecording& recording, const Term& term);

// Columns of all terms of the whole robot in one recording: by joint, kept samples x columns, in the order of the
// terms.
std::vector<Eigen::MatrixXd> calc_whole_columns(const TorqueData& data, const TorqueRecording& recording,
                                                const std::vector<Term>& terms);

// Conversion between coefficients and parameters, by the functions of the term's row.
TermValues calc_values(const Term& term, const Eigen::VectorXd& coefficients, const Eigen::VectorXd& std);
Eigen::VectorXd calc_coefficients(const TermRow& row, const std::vector<double>& values);

}  // namespace hrp::diagnosis
