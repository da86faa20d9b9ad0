// SPDX-License-Identifier: BSD-3-Clause
// A report in the making, and what its parts ask of the fit.
#pragma once

#include "diagnosis/floating/checks/landings.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/floating/search/search.h"

namespace hrp::diagnosis::floating {

struct ReportState {
  const LeggedLog& log;
  const Contacts& contacts;
  const LeggedFitter& fitter;
  const LeggedOutcome& outcome;
  const std::vector<SoleLaw>& soles;  // by foot, or empty
  LeggedFit model;                    // the chosen effects that a scenario can hold, and a mass that the checks found
  Evidence evidence;
};

// Whether physics outside the table of effects explains something.
bool has_free_law(const LeggedOutcome& outcome);

// Whether any equation keeps a mismatch.
bool is_anything_left(const ReportState& state);

}  // namespace hrp::diagnosis::floating
