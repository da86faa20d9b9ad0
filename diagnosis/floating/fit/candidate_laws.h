// SPDX-License-Identifier: BSD-3-Clause
// The table of laws that the search of a legged robot can name. Each row is an effect of the table of effects
// (common/effects), and what this engine adds to it: which values are possible here, and what the coefficients of its
// columns mean. Rules about single effects, such as what looks like what, refer to the rows.
#pragma once

#include "diagnosis/floating/fit/candidates.h"

namespace hrp::diagnosis::floating {

struct CandidateLaw {
  // Parameters as the report has them; empty: no value is told.
  std::vector<Estimate> (*make_estimates)(const Candidate& candidate, const Eigen::VectorXd& x,
                                          const Eigen::VectorXd& std);
  EffectId effect = kNoEffect;
  bool vector = false;            // coefficients are axes of one quantity, where there are several
  bool positive = false;          // the first coefficient cannot be negative
  double least = 0;               // what the first coefficient must exceed to be worth a name
  double low = -1e9, high = 1e9;  // of the first coefficient
  bool linearized = false;  // a delay or a turn of a reading: the correction of a recording is exact, the column is not
  double worth = 0;         // share of an equation's spread that it must take away
  // Coefficients by which it is certain and of one size in all regimes; none: those of its kind.
  std::vector<long> core{};
  // Whether the values are possible; a load lies within kReach of its link's origin. Null: all are.
  bool (*is_sensible)(const Candidate& candidate, const Eigen::VectorXd& x) = nullptr;
  // Takes the terms (of a sole: the prior) about the values x, where they are exact then; false: x has no place that is
  // possible. Null: they are exact everywhere.
  bool (*refine)(const ColumnLayout& layout, const Eigen::VectorXd& x, Candidate* candidate) = nullptr;
  // A free law: physics that the table of effects does not hold, so that no scenario can. Completes "hip_yaw: ".
  const char* unlisted = nullptr;

  const EffectInfo& info() const { return get_effect(effect); }  // of a law that is listed
};

struct LawTable {
  // Of a link.
  CandidateLaw payload, mass_error, com_error;
  // Of a joint: its encoder, its transmission, its friction, its drive.
  CandidateLaw joint_offset, backlash, elasticity;
  CandidateLaw viscous, coulomb, load_friction, rotor_inertia;
  CandidateLaw torque_constant, spring, lag, delay;
  // Of a sensor.
  CandidateLaw sensor_bias, sensor_scale, sensor_delay, sensor_misalignment;
  // Of a foot: a flat sole, or a foot that touches in a point. Of the ground.
  CandidateLaw flat_sole, point_foot, ground_slope;
  // Free laws of a joint, a link, a foot.
  CandidateLaw bend, pull, hold;
  // Of the efforts of all joints.
  CandidateLaw effort_scale;
};
const LawTable& get_laws();

}  // namespace hrp::diagnosis::floating
