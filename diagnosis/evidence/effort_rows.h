// SPDX-License-Identifier: BSD-3-Clause
// Adds the efforts along the recorded motion to the residuals of a fit through simulation. Two parameters may change
// the simulated positions alike but the efforts differently, or the reverse. Fitting both kinds of residuals separates
// such parameters.
#pragma once

#include <memory>

#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/search/fit_residuals.h"

namespace hrp::diagnosis {

// Computes the effort residuals of a fit. Keeps the inverse dynamics of the bodies for all recordings.
class EffortRows {
 public:
  // The effects of `links` change the bodies, in addition to the effects of the fitted hypothesis.
  EffortRows(const Experiment& experiment, const TorqueData& data, const Hypothesis& links = {});

  // Appends weighted effort residuals to the residuals of `simulated`. At the hypothesis `at`, both kinds have the same
  // sum of squares over the recordings `train`. Near `at`, their sum then falls exactly where the product of the two
  // errors falls. `joint`: adds the efforts of this joint only; -1: of all judged joints.
  CalcResiduals add_to(const CalcResiduals& simulated, const std::vector<int>& train, const Hypothesis& at,
                       int joint = -1) const;

 private:
  struct Bodies {
    const Experiment* experiment;
    const TorqueData* data;
    Hypothesis links;                  // beside every hypothesis that is fitted
    std::vector<Eigen::MatrixXd> tau;  // by recording of `data`: inverse dynamics [N m], sample x joint
  };
  std::shared_ptr<const Bodies> bodies_;
};

}  // namespace hrp::diagnosis
