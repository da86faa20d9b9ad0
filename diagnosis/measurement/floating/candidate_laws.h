// SPDX-License-Identifier: BSD-3-Clause
// What the coefficients of a candidate mean: parameters as the table of effects names them, values that can be, and terms
// about the values that were found where an effect is not linear in them.
#pragma once

#include "diagnosis/measurement/floating/candidates.h"

namespace hrp::diagnosis::floating {

struct CandidateLaw {
  // Parameters as the report has them; none: no value is told.
  std::vector<Estimate> (*make_estimates)(const Candidate& candidate, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
  // Whether the values can be; a load lies within `reach` [m] of its link's origin. Null: all can.
  bool (*is_sensible)(const Candidate& candidate, const Eigen::VectorXd& x, double reach) = nullptr;
  // The candidate with its terms taken about the values x, so that they are exact there; false: x has no place that can
  // be. Null: the terms are exact everywhere.
  bool (*refine)(const ColumnLayout& layout, const Eigen::VectorXd& x, double reach, Candidate* candidate) = nullptr;
  // Of physics that the table of effects does not hold, and no scenario therefore: completes "hip_yaw: ". Null: a row of it.
  const char* unlisted = nullptr;
};

const CandidateLaw& get_plain_law();    // parameter = its neutral value + coefficient
const CandidateLaw& get_angle_law();    // the same, for angles that are small
const CandidateLaw& get_load_law();     // mass, mass times place
const CandidateLaw& get_moved_law();    // by how far a link's mass lies elsewhere
const CandidateLaw& get_spring_law();   // stiffness, -stiffness times rest
const CandidateLaw& get_give_law();     // 1 / stiffness of a transmission
const CandidateLaw& get_bush_law();     // a flat sole: 1 / stiffness and damping / stiffness about two axes and along z
const CandidateLaw& get_point_law();    // a foot that touches in a point: 1 / stiffness along z
const CandidateLaw& get_bend_law();     // unlisted: 1 / stiffness about two axes across a joint
const CandidateLaw& get_pull_law();     // unlisted: a force in world axes, and how it changes with the place
const CandidateLaw& get_hold_law();     // unlisted: downward forces on a foot, by time from lifting and landing

}  // namespace hrp::diagnosis::floating
