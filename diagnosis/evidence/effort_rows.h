// SPDX-License-Identifier: BSD-3-Clause
// Efforts along the recorded motion as further residuals of a fit through simulation. Simulated positions alone leave
// parameters that predict efforts badly where two of them do the same to a position, and the other way round.
#pragma once

#include <memory>

#include "diagnosis/measurement/torque.h"
#include "diagnosis/search/fit_residuals.h"

namespace hrp::diagnosis {

class EffortRows {
 public:
  // Bodies move as the effects of `links` make them, beside what a hypothesis of the fit says of them.
  EffortRows(const Experiment& experiment, const TorqueData& data, const Hypothesis& links = {});

  // Of all residuals of `simulated`, and of efforts beside. Both count alike at the hypothesis `at`: their sum then falls
  // where the product of the two errors does. `joint`: of one alone, or of all (-1).
  CalcResiduals add_to(const CalcResiduals& simulated, const std::vector<int>& train, const Hypothesis& at, int joint = -1) const;

 private:
  struct Bodies {
    const Experiment* experiment;
    const TorqueData* data;
    std::vector<Eigen::MatrixXd> tau;  // by recording of the data
  };
  std::shared_ptr<const Bodies> bodies_;
};

}  // namespace hrp::diagnosis
