// SPDX-License-Identifier: BSD-3-Clause
// How far a parameter differs between parts of the recordings: a law that is right but not alone has another best value
// in every regime, and no noise says so.
#pragma once

#include "diagnosis/evidence/torque_model.h"

namespace hrp::diagnosis {

// Standard deviation by column of a joint's part of the model (its own terms, then the whole robot's), beside what
// noise makes of it:
// - Between parts: recordings; quarters by time, speed, position, load. Variance between parts by random effects
//   (DerSimonian and Laird 1986), as the value in one more part would differ (Higgins, Thompson and Spiegelhalter 2009).
//   Of these ways of dividing, the one that differs most.
// - Drift: from the middle of a recording to its ends, where it is certain.
// - Considered, not estimated (Schmidt 1966): a torque constant is known to 2 %, an instant to half a sample. Smaller
//   errors get no name, but they move the other parameters. Dry friction differs by a tenth over a turn; of a joint that
//   moved by a part of it, only that part is known.
Eigen::VectorXd calc_spread_between(const TorqueDesign& design, const TorqueModel& model, size_t joint);

// Variance between groups from a value and its own variance for each.
double calc_variance_between(const std::vector<double>& values, const std::vector<double>& variances);

}  // namespace hrp::diagnosis
