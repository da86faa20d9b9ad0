// SPDX-License-Identifier: BSD-3-Clause
// Effects as columns of the missing torque (torque.h), and back from coefficients to parameters.
//
// Of one joint, in its own row; s is the smooth sign of its velocity:
//   viscous b v; dry c s; growing with load mu |tau| s; of a gear that the load drives
//   backwards mu |tau| s where tau s < 0; Stribeck (f_s - f_c) exp(-(v / v_s)^2) s; rotor J a;
//   true torque k times the effort: (1 - k) y, or (1/k - 1) tau; constant; spring k (q - rest); lag or delay T dy/dt;
//   hysteresis k q_y z, z the state of a Bouc-Wen element along the recorded motion, for several yield angles q_y;
//   late commands T (c(t) - c(t - T0)) / T0 with c = kp r + kd r', for several T0, of which the one nearest to T fits
//   best; an effort that is logged T late -T (y(t + T0) - y(t)) / T0; cogging A sin(p q + phase).
// The factor k by either column: errors of tau (accelerations) draw the second one down, physics that is left out draws
// the first one up; the truth is between the two (errors in variables, Frisch's bounds).
// Of the whole robot, in every row: mass, centre of mass and load of a link (regressor of inverse dynamics), a constant
// force (-J^T F), an encoder's zero (-d tau / d q_j), the base turned against gravity (d tau / d roll, pitch), a
// share of gravity that no drive carries (tau without gravity less tau), and commands that are late at all joints alike: the column above in every row, as on one bus.
#pragma once

#include "common/effects/effect_info.h"
#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

struct TermRow;
class WholeColumns;  // measurement/whole_columns.cpp

// An effect at a place, with a shape: columns of the missing torque.
struct Term {
  const TermRow* row = nullptr;
  int place = 0;       // joint, or link
  double shape = 0.0;  // Stribeck velocity [rad/s], cogging [1/rad], delay T0 [s], yield angle [rad]

  int columns() const;
  bool whole() const;  // rows of every joint, else of `place` alone
  const EffectInfo& effect() const;
};

// Parameters of a term, in the order of the effect's row, with their standard deviations.
struct TermValues {
  std::vector<double> value, std;
};

// Shapes of friction that grows with the load: with the bodies' torque behind the gear, or with all that the drive gives.
constexpr double kLoadOfBodies = 0.0, kLoadOfDrive = 1.0;

// What a term is: its row in the table of effects, and what only torque along a recorded motion asks. A new term is a
// row (term_rows.cpp, whole_columns.cpp) and its column; evidence, grades, words and pages read the fields.
struct TermRow {
  const EffectInfo* effect = nullptr;
  PlaceKind place = PlaceKind::kJoint;  // kJoint, kLink; kNone: the base
  int columns = 1;
  // Columns in the joint's row: kept samples x columns; null of terms that are in the rows of every joint.
  Eigen::MatrixXd (*calc_columns)(const TorqueData& data, const TorqueRecording& recording, const Term& term) = nullptr;
  // Columns in the rows of every joint at one moment: joint x columns.
  void (WholeColumns::*fill_columns)(const Term& term, Eigen::Ref<Eigen::MatrixXd> columns) = nullptr;
  // Shapes to be tried at a joint or link; none: no such term there. Null: one term, without a shape.
  std::vector<double> (*list_shapes)(const TorqueData& data, int place) = nullptr;
  // Parameters from coefficients x with deviations s, and the other way round; null: they are the same.
  TermValues (*make_values)(const Term& term, const Eigen::VectorXd& x, const Eigen::VectorXd& s) = nullptr;
  Eigen::VectorXd (*make_coefficients)(const std::vector<double>& values) = nullptr;
  // [nats] before its parameters pay by cross-validation: what every drive has costs least.
  double cost = 3.0;
  const char* motion = "";     // that would tell it from others
  // Of a real machine: friction brakes, rotors have mass, delays are positive and short. First coefficient, or the norm.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool by_norm = false;
  bool within_reach = false;   // the coefficients are a place [m] of something that belongs to the link
  double material = 0.0;       // norm: less no drive and no encoder is free of
  bool whole = false;          // in the rows of every joint
  bool needs_drive = false;    // a joint without a motor has none
  bool usual = false;          // every drive has it
  bool of_motor_and_gear = false;  // losses and rotors: where they are known the drive is
  bool scanned = false;        // of several shapes in one joint one is tried
  bool only_beside_all = false;  // tried only where it pays beside all other terms: they say much of it, too
  bool late = false;           // commands that come late
  bool of_log = false;         // a fault of the recorded effort, not of the joint
  bool factor = false;         // 1 + coefficient multiplies: far from one is unlikely
  bool level = false;          // dry friction while the joint moves, whatever the load
  bool by_load = false;        // dry friction that grows with the load
  bool excess = false;         // friction at rest above a level: no law without one, reported with it
  bool memory = false;         // follows where the joint has been: beside dry friction, whose pre-sliding looks like it
  double least_shape = 0.0;    // a term of this shape or a smaller one is for comparison only
  bool backwards = false;      // of a gear while the load drives it
  bool scales_effort = false;  // the drive's gain by the recorded effort; its column by the model follows in the list
  bool scales_model = false;   // the drive's gain by the model's torque: the other bound
  bool load = false;           // a mass that is carried, and where: all that can be wrong with a link's mass and its centre
  bool moves_model = false;    // its columns move the model that the others are computed with
  int constant = -1;           // column that is the same at all times; -1: none
  int shape_parameter = -1;    // the effect's parameter that the shape is; -1: none, the coefficients say all

  bool allows(const Eigen::VectorXd& coefficients, double reach = 0.0) const;
  bool is_dry() const { return level || by_load; }
  bool is_constant() const { return constant == 0; }          // and nothing else
  bool is_of_bus() const { return late && whole; }            // of all joints alike
  bool is_of_mass() const { return effect->family == EffectFamily::kMass; }
};

// All of them, those of joints first. Of rows of one effect the first is the one that reports are read by.
const std::vector<TermRow>& list_term_rows();
// The first that has a property; there must be one.
const TermRow& find_term_row(bool TermRow::*property);

// (c(t) - c(t - T0)) / T0 at sample k of the full grid: the mean of c' over the last T0.
double calc_late(const TorqueRecording& recording, long joint, long k, double delay);
// (y(t + T0) - y(t)) / T0 [N m/s] at sample k of the full grid: what a log that comes late has still to tell.
double calc_coming(const TorqueRecording& recording, long joint, long k, double delay);

// Everything that is tried: terms of each joint that is judged, and terms of the whole robot.
std::vector<Term> list_joint_terms(const TorqueData& data, int joint);
std::vector<Term> list_whole_terms(const TorqueData& data);

// Columns of a joint's term in its row: kept samples x columns.
Eigen::MatrixXd calc_joint_columns(const TorqueData& data, const TorqueRecording& recording, const Term& term);

// Columns of all whole-robot terms in the rows of one recording: by joint, kept samples x all columns, terms in order.
std::vector<Eigen::MatrixXd> calc_whole_columns(const TorqueData& data, const TorqueRecording& recording,
                                                const std::vector<Term>& terms);

TermValues calc_values(const Term& term, const Eigen::VectorXd& coefficients, const Eigen::VectorXd& std);
Eigen::VectorXd calc_coefficients(const TermRow& row, const std::vector<double>& values);

}  // namespace hrp::diagnosis
