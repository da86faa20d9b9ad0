// SPDX-License-Identifier: BSD-3-Clause
// Recorded angles that are not the joint's (measurement/gear_ratios.h): whether another ratio explains the efforts
// better than every effect of the list does with angles as logged, and what a report says of it.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/measurement/gear_ratios.h"
#include "diagnosis/report/first.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

struct Ratios {
  std::vector<GearRatio> found;    // recordings are converted
  std::vector<GearRatio> doubted;  // efforts ask for it, and recordings disagree about it, or another zero does as well
};

Ratios find_gear_ratios(const Experiment& experiment, int jobs);

Experiment convert_ratios(Experiment experiment, const Ratios& ratios);

// In one sentence.
std::string describe(const Experiment& experiment, const GearRatio& ratio);

Json make_ratio_finding(const Experiment& as_logged, const GearRatio& ratio);

// What is named at a joint with a doubted ratio, or at any link: ambiguous, with the ratio as the alternative. Asks for
// it.
void doubt_ratios(const Experiment& as_logged, const Ratios& ratios, Reports* reports);

}  // namespace hrp::diagnosis
