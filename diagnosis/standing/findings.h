// SPDX-License-Identifier: BSD-3-Clause
// Converts findings about a standing robot to the names, units and words of the report.
#pragma once

#include <string>
#include <utility>

#include "diagnosis/report/json.h"
#include "diagnosis/standing/search.h"

namespace hrp::diagnosis::standing {

// Place of an effect in the report: kind and name.
std::pair<std::string, std::string> find_place(const StandProblem& problem, const Effect& effect);

// Parameters with standard deviations and intervals. For a sole's compliance, those of the foot with index `foot`.
std::vector<Estimate> make_parameters(const StandProblem& problem, const Effect& effect, const Eigen::VectorXd& fitted,
                                      size_t foot);

// Text of parameters with the half widths of their 95 % intervals.
std::string describe_values(const std::vector<Estimate>& parameters);

// Root mean square of the residuals of training or of other recordings, in units of each channel's noise.
double calc_fit(const StandProblem& problem, const StandOutcome& outcome, const Evaluation& evaluation, bool train);

}  // namespace hrp::diagnosis::standing
