// SPDX-License-Identifier: BSD-3-Clause
// Converts findings of a report to terms of the missing torque, with the reported values.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/measurement/torque/terms.h"

namespace hrp::diagnosis {

// A term with the coefficients of a reported finding.
struct FoundTerm {
  Term term;
  Eigen::VectorXd theta;        // by column: missing torque = columns x theta [N m]
  size_t finding = 0;           // index in the report's list
  std::string parameter, unit;  // of the first coefficient; empty: shown with another term of the finding
  double value = 0.0;           // of that parameter
};

// Terms of joints in the order of the findings, then those of links. Leaves out findings that are no term of the
// torque: delays from the servo's law, sensor faults, joint zeros.
std::vector<FoundTerm> list_found_terms(const Experiment& experiment, const nlohmann::ordered_json& findings);

// Contribution of the terms to the torque of one recording: kept samples x joints [N m].
Eigen::MatrixXd predict_found(const TorqueData& data, const TorqueRecording& recording,
                              const std::vector<FoundTerm>& found);

}  // namespace hrp::diagnosis
