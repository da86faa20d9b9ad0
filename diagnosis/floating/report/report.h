// SPDX-License-Identifier: BSD-3-Clause
// The report on a legged robot:
//
//   effect_findings   findings of the search
//   lookalikes        effects that no recorded signal tells apart from a finding
//   check_findings    findings of the checks on whole recordings
//   fit_figures       how well the model fits, by signal and in all
//   unexplained       what the model leaves
//   mismatches        when the recordings depart from the nominal model
//   verdict           what all this amounts to
//   series            curves for the page
#pragma once

#include "diagnosis/floating/checks/checks.h"
#include "diagnosis/floating/checks/landings.h"
#include "diagnosis/floating/search/search.h"

namespace hrp::diagnosis::floating {

// `soles`: by foot, from landings; empty: none.
Evidence make_evidence(const LeggedLog& log, const Contacts& contacts, const LeggedFitter& fitter,
                       const LeggedOutcome& outcome, const std::vector<SoleLaw>& soles, const CheckResult& checks);

}  // namespace hrp::diagnosis::floating
