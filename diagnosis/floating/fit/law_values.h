// SPDX-License-Identifier: BSD-3-Clause
// What the coefficients of each candidate law mean: parameters as the report has them, and the values that are
// possible. Coefficients x are in the order of the candidate's terms, std are their deviations.
#pragma once

#include "diagnosis/floating/fit/candidates.h"

namespace hrp::diagnosis::floating {

using Estimates = std::vector<Estimate>;

// Parameter = its neutral value + coefficient.
Estimates make_plain(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
// Torque = (1 + coefficient) x reading: the reading is the torque times the factor 1 / (1 + coefficient).
Estimates make_reading_scale(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
// Mass [kg], mass times place [kg m].
Estimates make_payload(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
// Stiffness [N m/rad], -stiffness times rest [N m].
Estimates make_spring(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
// 1 / stiffness of a transmission [rad/(N m)].
Estimates make_elasticity(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
// A flat sole: 1 / stiffness and damping / stiffness about two axes and along z.
Estimates make_flat_sole(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
// A foot that touches in a point: 1 / stiffness along z [m/N].
Estimates make_point_foot(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
// Free laws: 1 / stiffness about two axes across a joint [rad/(N m)]; a force in world axes [N]; a downward force [N].
Estimates make_bend(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
Estimates make_pull(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);
Estimates make_hold(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std);

bool is_small_angle(const Candidate& c, const Eigen::VectorXd& x);
bool is_payload_near(const Candidate& c, const Eigen::VectorXd& x);
bool is_mass_within_link(const Candidate& c, const Eigen::VectorXd& x);
bool is_soft_sole(const Candidate& c, const Eigen::VectorXd& x);
bool is_soft_point(const Candidate& c, const Eigen::VectorXd& x);
bool is_stiff_enough(const Candidate& c, const Eigen::VectorXd& x);
bool is_bend(const Candidate& c, const Eigen::VectorXd& x);

// The candidate with its terms about the values x; false: x has no place that is possible.
bool refine_payload(const ColumnLayout& layout, const Eigen::VectorXd& x, Candidate* candidate);
bool refine_sole(const ColumnLayout& layout, const Eigen::VectorXd& x, Candidate* candidate);
bool refine_moved_mass(const ColumnLayout& layout, const Eigen::VectorXd& x, Candidate* candidate);

}  // namespace hrp::diagnosis::floating
