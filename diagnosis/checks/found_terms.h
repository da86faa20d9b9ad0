// SPDX-License-Identifier: BSD-3-Clause
// Findings of a report as terms of the missing torque, with the values that were reported.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/measurement/torque_terms.h"

namespace hrp::diagnosis {

struct FoundTerm {
  Term term;
  Eigen::VectorXd theta;    // by column: missing torque = columns x theta
  size_t finding = 0;       // in the report's list
  std::string parameter, unit;  // of the first coefficient; empty: shown with another term of the same finding
  double value = 0.0;       // of the parameter
};

// Terms of joints first, in the order of the findings, then those of links. What is no term of the torque (delays told by
// the servo's law, faults of sensors, a joint's zero) is left out.
std::vector<FoundTerm> list_found_terms(const Experiment& experiment, const nlohmann::ordered_json& findings);

// What the terms add to the nominal torque of one recording: kept samples x joints [N m].
Eigen::MatrixXd predict_found(const TorqueData& data, const TorqueRecording& recording, const std::vector<FoundTerm>& found);

}  // namespace hrp::diagnosis
