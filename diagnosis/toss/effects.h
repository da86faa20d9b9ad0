// SPDX-License-Identifier: BSD-3-Clause
// Which effects of the table the poses of a tossed body may show, and what a search has to know about them there.
#pragma once

#include "diagnosis/model/effect.h"
#include "diagnosis/toss/data.h"

namespace hrp::diagnosis::toss {

// A parameter of the table as poses tell it: they resolve a body's mass far better than joints do a link's.
struct TossParameter {
  const EffectParameter* info;
  double step;       // of finite differences
  double low, high;  // of a fit
};

struct TossRow {
  EffectId id;
  Place place;
  std::vector<TossParameter> parameters;
  const char* unit = "";          // where the table leaves it to the reading
  double (*find_nominal)(const World&, size_t parameter) = nullptr;  // where the effect sets what the model has
  bool flies = false;             // shows in windows without contact
  bool jumps = false;             // no small change shows: neither friction where all sticks nor bouncing where nothing does
  EffectId inside = EffectId::kNamed;  // an effect that this one contains: it is tried in its place
  const char* refused = nullptr;  // why it is not named for sure where nothing measures it
  // The first parameter as the poses give it without a law of contact (strikes.h); null: only a fit does.
  std::optional<Measured> (*get_measured)(const TossProblem&) = nullptr;
  // Where to start a fit that nothing measures, from the absent effect `none`; null: there.
  Hypothesis (*list_starts)(const TossProblem&, const Hypothesis& found, const Effect& none) = nullptr;
};

const std::vector<TossRow>& list_toss_rows();
const TossRow& get_toss_row(EffectId id);
inline const TossRow& get_toss_row(const Effect& effect) { return get_toss_row(effect.id); }

// The effect with values that change nothing; values in the order of its row's parameters.
Effect make_neutral(const TossProblem& problem, EffectId id);
bool has_effect(const Hypothesis& hypothesis, EffectId id);
Hypothesis list_starts(const TossProblem& problem, const Hypothesis& found, EffectId id);

}  // namespace hrp::diagnosis::toss
