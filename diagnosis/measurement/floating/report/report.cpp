// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/report/report.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "diagnosis/measurement/floating/report/check_findings.h"
#include "diagnosis/measurement/floating/report/effect_findings.h"
#include "diagnosis/measurement/floating/report/fit_figures.h"
#include "diagnosis/measurement/floating/report/mismatches.h"
#include "diagnosis/measurement/floating/report/unexplained.h"
#include "diagnosis/measurement/floating/report/verdict.h"

namespace hrp::diagnosis::floating {
namespace {

std::vector<Candidate> list_listed(const LeggedFit& fit) {
  std::vector<Candidate> out;
  std::copy_if(fit.effects.begin(), fit.effects.end(), std::back_inserter(out),
               [](const Candidate& c) { return c.is_listed(); });
  return out;
}

// What checks have seen, but for sensors that a finding is of.
void add_remaining(const std::vector<Remaining>& seen, Evidence* out) {
  for (const Remaining& r : seen) {
    const bool told = r.where.contains("sensor") &&
                      std::any_of(out->findings.begin(), out->findings.end(), [&](const Finding& f) { return f.where == r.where; });
    if (!told) out->remaining.push_back(r);
  }
}

}  // namespace

Evidence make_evidence(const LeggedLog& log, const Contacts& contacts, const LeggedFitter& fitter,
                       const LeggedOutcome& outcome, const std::vector<SoleLaw>& soles, const CheckResult& checks) {
  ReportState state{log, contacts, fitter, outcome, soles, fitter.fit(list_listed(outcome.chosen)), {}};
  Evidence& out = state.evidence;
  out.method =
      "equations of motion along the recorded motion, with every signal that was recorded; means of 40 ms, products "
      "of even with odd samples";
  out.missing = log.missing, out.warnings = log.notes;
  out.warnings.insert(out.warnings.end(), checks.notes.begin(), checks.notes.end());
  add_effect_findings(&state);
  add_check_findings(checks, &state);
  sort_findings(&out.findings);
  add_fit_figures(checks.units, &state);
  doubt_findings(&state);
  add_unexplained(&state);
  add_mismatches(&state);
  out.verdict = find_verdict(state);
  if (out.verdict != Verdict::kNoMismatch) add_remaining(checks.remaining, &out);
  if (out.findings.empty()) out.summary = make_summary(state);
  return std::move(state.evidence);
}

}  // namespace hrp::diagnosis::floating
