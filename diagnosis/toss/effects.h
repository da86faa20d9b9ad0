// SPDX-License-Identifier: BSD-3-Clause
// Effects of the table that the poses of a tossed body can show, and how the search treats them.
#pragma once

#include "diagnosis/model/effect.h"
#include "diagnosis/toss/data.h"

namespace hrp::diagnosis::toss {

// A fitted parameter of the table. Its bounds differ from the table's, because poses determine a body's mass much
// better than joints determine that of a link.
struct TossParameter {
  const EffectParameter* info;
  double step;       // for finite differences
  double low, high;  // bounds of a fit
};

// An effect of the table, as the search for tossed bodies treats it.
struct TossRow {
  EffectId id;
  Place place;
  std::vector<TossParameter> parameters;
  const char* unit = "";                                             // of parameters whose unit depends on the reading
  double (*find_nominal)(const World&, size_t parameter) = nullptr;  // if the effect replaces a value of the model
  bool flies = false;                                                // visible in windows without contact
  bool jumps = false;             // no small change shows: friction while all sticks, restitution while nothing bounces
  EffectId inside = kNoEffect;    // an effect that this one contains and replaces
  const char* refused = nullptr;  // why it is only ambiguous without an independent measurement
  // First parameter from the poses without a law of contact (strikes.h). Null: only a fit determines it.
  std::optional<Measured> (*get_measured)(const TossProblem&) = nullptr;
  // Start values for a fit without a measurement; `none` is the neutral effect. Null: starts at `none`.
  Hypothesis (*list_starts)(const TossProblem&, const Hypothesis& found, const Effect& none) = nullptr;
};

// All rows, and the row of an effect. Effects without a row are a broken contract (HRP_CHECK).
const std::vector<TossRow>& list_toss_rows();
const TossRow& get_toss_row(EffectId id);
inline const TossRow& get_toss_row(const Effect& effect) { return get_toss_row(effect.id); }

// The neutral effect, with values in the order of its row's parameters.
Effect make_neutral(const TossProblem& problem, EffectId id);
bool has_effect(const Hypothesis& hypothesis, EffectId id);

// Start values for a fit of the effect, beside the effects in `found`.
Hypothesis list_starts(const TossProblem& problem, const Hypothesis& found, EffectId id);

}  // namespace hrp::diagnosis::toss
