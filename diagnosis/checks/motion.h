// SPDX-License-Identifier: BSD-3-Clause
// Motion of the joints, and what it can tell of each effect, from the regressor of the missing torque.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/measurement/torque_terms.h"

namespace hrp::diagnosis {

// By joint: {"joint", "travel" [rad], "speed", "acceleration", "load": [low, high] [N m], "reversals", "effort", "tells":
// [{"effect", "least", "unit", "verdict", "hidden_by"}]}.
//
// `least`: the smallest parameter that these motions would show, three standard deviations of
//   sigma^2 (X^T X / n)^-1 / N,
// X: columns of friction, rotor, gain and constant torque of the joint; sigma: what they all leave; N: half-cycles of the
// motion times three, as in the evidence. Verdicts: "clear" when its torque is below a tenth of the effort's spread,
// "weak" below three tenths, else "hidden", by the column that is most like it.
nlohmann::ordered_json make_motion_checks(const Experiment& experiment);

}  // namespace hrp::diagnosis
