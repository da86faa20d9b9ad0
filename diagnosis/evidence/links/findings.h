// SPDX-License-Identifier: BSD-3-Clause
// Findings from sensors behind the gears: faults of these sensors, and effects of the links beyond them.
#pragma once

#include <memory>

#include "diagnosis/evidence/links/model.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Result of all sensors behind the gears, with the model and the design that it comes from.
struct LinkVerdict {
  Evidence evidence;      // findings, remaining, fit.signals, explained; no verdict
  bool mismatch = false;  // a reading differs by more than its noise and 3 % of its spread, or there is a finding
  bool agrees = false;    // the known effects agree with these sensors
  bool to_noise = false;  // all residuals are noise
  double noise_before = 0.0, noise_after = 0.0;  // held-out rms over all readings; unit: filtered noise

  // True if these sensors resolve an effect of size `value` (six standard errors) and find less than half of it.
  bool excludes(const std::string& effect, const Where& where, double value) const;
  // Bias and scale that were found for a joint's torque sensor; (0, 1) if none.
  std::pair<double, double> find_torque_fault(int joint) const;

  std::shared_ptr<const LinkDesign> design;
  LinkTerms model;
  LinkFit fit;
};

// Judges the sensors with the `known` effects in the prediction. These come from encoders and efforts and are certain.
// If they make the held-out prediction more than 2 % worse, they are left out.
LinkVerdict judge_links(const Experiment& experiment, const TorqueData& motion, const LinkSensors& sensors,
                        const std::vector<Effect>& known);

}  // namespace hrp::diagnosis
