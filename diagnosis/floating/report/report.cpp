// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/report.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/fit/remaining.h"
#include "diagnosis/floating/report/check_findings.h"
#include "diagnosis/floating/report/effect_findings.h"
#include "diagnosis/floating/report/fit_figures.h"
#include "diagnosis/floating/report/mismatches.h"
#include "diagnosis/floating/report/unexplained.h"
#include "diagnosis/floating/report/verdict.h"

namespace hrp::diagnosis::floating {
namespace {

std::vector<Candidate> list_listed(const LeggedFit& fit) {
  std::vector<Candidate> out;
  std::copy_if(fit.effects.begin(), fit.effects.end(), std::back_inserter(out),
               [](const Candidate& c) { return c.is_listed(); });
  return out;
}

// The model explains how a foot that stands is tilted, by a joint's zero, its sole or the ground.
bool is_tilt_told(const ReportState& state, const std::string& foot) {
  const LeggedFit nominal = state.fitter.fit({});
  const std::vector<ChannelRows>& channels = state.fitter.channels();
  for (size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].info.name != foot || !channels[c].info.equation.is(EquationKind::kTilt)) continue;
    if (get_mean_square(state.fitter, state.model, c) < kHalf * get_mean_square(state.fitter, nominal, c)) return true;
  }
  return false;
}

// What checks have seen, but for what a finding tells.
void add_remaining(const std::vector<Remaining>& seen, ReportState* state) {
  Evidence& out = state->evidence;
  for (const Remaining& r : seen) {
    const bool told = r.where.contains("sensor") && std::any_of(out.findings.begin(), out.findings.end(),
                                                                [&](const Finding& f) { return f.where == r.where; });
    if (!told && !(r.where.contains("foot") && is_tilt_told(*state, r.where["foot"]))) out.remaining.push_back(r);
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
  out.missing = log.missing;
  out.warnings = log.notes;
  out.warnings.insert(out.warnings.end(), checks.notes.begin(), checks.notes.end());
  add_effect_findings(&state);
  add_check_findings(checks, &state);
  sort_findings(&out.findings);
  add_fit_figures(checks.units, &state);
  doubt_findings(&state);
  add_unexplained(&state);
  add_mismatches(&state);
  out.verdict = find_verdict(state);
  if (out.verdict != Verdict::kNoMismatch) add_remaining(checks.remaining, &state);
  if (out.findings.empty()) out.summary = make_summary(state);
  return std::move(state.evidence);
}

}  // namespace hrp::diagnosis::floating
