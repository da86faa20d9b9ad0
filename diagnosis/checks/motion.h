// SPDX-License-Identifier: BSD-3-Clause
// Motion of the joints, and the smallest effects that it can show, from the regressor of the missing torque.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/measurement/torque/terms.h"

namespace hrp::diagnosis {

// By joint: {"joint", "travel" [rad], "speed", "acceleration", "load": [low, high] [N m], "reversals", "effort",
// "tells":
// [{"effect", "least", "unit", "verdict", "hidden_by"}]}, and for recorded efforts "tells_unit": whether they show that
// they are torques.
//
// `least`: the smallest parameter that these motions can show, three standard deviations from
//   sigma^2 (X^T X / n)^-1 / N,
// X: columns of friction, rotor, gain and constant torque of the joint; n: samples; sigma: rms that they all leave; N:
// three times the half-cycles of the motion, as in the evidence. Verdicts by the torque of `least`: "clear" below a
// tenth of the effort's spread, "weak" below three tenths, else "hidden", by the most similar column.
nlohmann::ordered_json make_motion_checks(const Experiment& experiment);

}  // namespace hrp::diagnosis
