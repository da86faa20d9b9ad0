// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/verdict.h"

#include <algorithm>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/fit/candidates.h"
#include "diagnosis/floating/report/unexplained.h"

namespace hrp::diagnosis::floating {
namespace {

// With so little explained of all equations, and so much of the held-out error left, another cause may pass for what
// was found.
bool leaves_most(const ReportState& state) {
  const Evidence& e = state.evidence;
  const double after = e.fit.validate_after;
  return (is_anything_left(state) || after > kUnlikely) && e.explained < kPart &&
         after > kMostly * e.fit.validate_before;
}

bool may_doubt(const Finding& f) {
  const EffectInfo* row = find_effect(f.effect);
  // A zero has no shape: the mean of any unknown force is one.
  const bool shaped = row && is_expected(*row) && row->family != EffectFamily::kZero;
  return f.share < kMostly && !shaped && f.grade != Grade::kAmbiguous;
}

}  // namespace

void doubt_findings(ReportState* state) {
  if (!leaves_most(*state) && !has_free_law(state->outcome)) return;
  for (Finding& f : state->evidence.findings) {
    if (!may_doubt(f)) continue;
    f.grade = Grade::kAmbiguous;
    f.probability = std::min(f.probability, kHalf);
    f.statement += " Most of what stands out is left beside it: another cause may be behind both.";
  }
}

Verdict find_verdict(const ReportState& state) {
  const Evidence& e = state.evidence;
  const bool left = is_anything_left(state);
  if (e.findings.empty()) {
    const bool something = has_free_law(state.outcome) || left || !list_unsteady(state).empty();
    return something ? Verdict::kUnexplained : Verdict::kNoMismatch;
  }
  if (state.outcome.effects.empty()) return Verdict::kPartlyExplained;  // by checks alone
  // What leaves nearly all explains nothing, but for a finding that takes much of its own equation's mismatch.
  const bool gone = e.fit.validate_after < kNearlyAll * e.fit.validate_before ||
                    std::any_of(e.findings.begin(), e.findings.end(), [](const Finding& f) { return f.share > kMuch; });
  if (!left && gone && e.fit.validate_after < kUnlikely) return Verdict::kExplained;
  const bool mostly = e.explained >= kMostly * e.ceiling && !leaves_most(state);
  return mostly ? Verdict::kMostlyExplained : Verdict::kPartlyExplained;
}

std::string make_summary(const ReportState& state) {
  std::string compared;
  for (const ChannelRows& c : state.fitter.channels()) {
    const std::string kind = get_name(c.info.equation.kind);
    if (c.rows() > 0 && compared.find(kind) == std::string::npos) compared += (compared.empty() ? "" : ", ") + kind;
  }
  const bool agrees = state.evidence.verdict == Verdict::kNoMismatch;
  return (agrees ? "Nothing stands out of what could be compared: "
                 : "Something is missing that no known effect explains; compared were: ") +
         compared + ".";
}

}  // namespace hrp::diagnosis::floating
