// SPDX-License-Identifier: BSD-3-Clause
// What the sensors behind the gears say: faults of their own, and what the links beyond them have.
#pragma once

#include <memory>

#include "diagnosis/evidence/link_model.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

struct LinkVerdict {
  Evidence evidence;      // findings, remaining, fit.signals, explained; without verdict
  bool mismatch = false;  // some reading is off by more than its noise and a share of its spread
  bool agrees = false;    // with what is known, all of which these sensors see
  bool to_noise = false;  // what is left is noise everywhere
  double noise_before = 0.0, noise_after = 0.0;  // held out, over the noise behind the filter, over all readings

  // These sensors would show an effect of that size, and do not.
  bool excludes(const std::string& effect, const Where& where, double value) const;
  // Bias and scale of a joint's torque sensor that were found; 0 and 1 else.
  std::pair<double, double> find_torque_fault(int joint) const;

  std::shared_ptr<const LinkDesign> design;
  LinkTerms model;
  LinkFit fit;
};

// `known`: effects that encoders and efforts have told for certain. They stay where these sensors do not contradict:
// what is found comes on top.
LinkVerdict judge_links(const Experiment& experiment, const TorqueData& motion, const LinkSensors& sensors,
                        const std::vector<Effect>& known);

}  // namespace hrp::diagnosis
