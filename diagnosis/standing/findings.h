// SPDX-License-Identifier: BSD-3-Clause
// Findings about a standing robot in the report's names, units and words.
#pragma once

#include <string>
#include <utility>

#include "diagnosis/report/json.h"
#include "diagnosis/standing/search.h"

namespace hrp::diagnosis::standing {

// The place in the report's words: kind and name.
std::pair<std::string, std::string> find_place(const StandProblem& problem, const Effect& effect);

// Parameters with deviations and intervals; of a sole's compliance those of one foot.
Json make_parameters(const StandProblem& problem, const Effect& effect, const Eigen::VectorXd& fitted,
                     size_t foot);

std::string describe_values(const Json& parameters);

// Root mean square over the recordings of one role in units of each channel's noise.
double calc_fit(const StandProblem& problem, const StandOutcome& outcome, const Evaluation& evaluation, bool train);

}  // namespace hrp::diagnosis::standing
