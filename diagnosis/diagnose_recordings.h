// SPDX-License-Identifier: BSD-3-Clause
// A diagnosis of recordings of any length: checks, a first answer within seconds, the search on the stretches that tell
// most, the judgement on all.
#pragma once

#include "diagnosis/report/first.h"

namespace hrp::diagnosis {

struct DiagnosisOptions {
  int jobs = 1;
  double patience = 1.0;  // times the usual work of a search
};

// `write_first` gets the first answer, marked `preliminary`: the missing torque of a few stretches.
Reports diagnose_recordings(const Experiment& experiment, const DiagnosisOptions& options, const Progress& progress,
                            const std::function<void(const Reports&)>& write_first);

// Rates, gaps, clocks, motion, and what it can tell, as text.
std::string check_recordings(const Experiment& experiment);

}  // namespace hrp::diagnosis
