// SPDX-License-Identifier: BSD-3-Clause
// What a term of the missing torque is, one row each: effect, place, columns, physical range, cost, motion that would tell.
// Evidence, grades, words and pages read it; a new term is a row, and its column.
#pragma once

#include <Eigen/Dense>
#include <limits>

#include "diagnosis/measurement/torque_terms.h"

namespace hrp::diagnosis {

struct TermRow {
  TermKind kind = TermKind::kViscous;
  EffectId effect = EffectId::kNamed;
  PlaceKind place = PlaceKind::kJoint;  // kJoint, kLink; kNone: the base
  int columns = 1;
  // Columns in the joint's row: kept samples x columns; null of terms that are in the rows of every joint.
  Eigen::MatrixXd (*calc_columns)(const TorqueData& data, const TorqueRecording& recording, const Term& term) = nullptr;
  // [nats] before its parameters pay by cross-validation: what every drive has costs least.
  double cost = 3.0;
  const char* motion = "";     // that would tell it from others
  // Of a real machine: friction brakes, rotors have mass, delays are positive and short. First coefficient, or the norm.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool by_norm = false;
  double material = 0.0;       // norm: less no drive and no encoder is free of
  bool whole = false;          // in the rows of every joint
  bool needs_drive = false;    // a joint without a motor has none
  bool usual = false;          // every drive has it
  bool of_motor_and_gear = false;  // losses and rotors: where they are known the drive is
  bool scanned = false;        // of several shapes in one joint one is tried
  bool late = false;           // commands that come late
  bool factor = false;         // 1 + coefficient multiplies: far from one is unlikely

  bool allows(const Eigen::VectorXd& coefficients) const;
};

const TermRow& get_term_row(TermKind kind);

// All of them, in the order of the enumeration.
const std::vector<TermRow>& list_term_rows();

}  // namespace hrp::diagnosis
