// SPDX-License-Identifier: BSD-3-Clause
// Curves of the equations that say most: what they lacked, and what is left.
#pragma once

#include "diagnosis/floating/search/search.h"

namespace hrp::diagnosis::floating {

nlohmann::ordered_json make_series(const Experiment& experiment, const LeggedFitter& fitter,
                                   const LeggedOutcome& outcome, const Evidence& evidence);

}  // namespace hrp::diagnosis::floating
