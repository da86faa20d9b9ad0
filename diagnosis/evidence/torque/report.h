// SPDX-License-Identifier: BSD-3-Clause
// Parts of a report that all engines share which judge joints by their missing torque.
#pragma once

#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

// Missing torques by joint, each over the spread of its effort: root mean square over the joints, before and after.
void fill_torque_fit(const std::vector<SignalFit>& torque, Fit* fit);

// The model with the grades of the findings that its effects stand for: [{effect, where, parameters, grade}].
Json list_torque_model(const Experiment& experiment, const Hypothesis& model, const Json& findings);

// The same after the entries of `body`: findings of links, feet and sensors that another method has found.
Json list_whole_model(const Experiment& experiment, const Hypothesis& model, const Json& findings, const Json& body);

}  // namespace hrp::diagnosis
