// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

// What a finding of a report begins with: as sure as any, and as heavy as its share. Words and alternatives are the
// caller's.
Json make_finding_head(const EffectInfo& effect, const Json& where, const Json& parameters, Grade grade, double share);

// Another effect that would explain the same, as a report states it.
Json state_alternative(const EffectInfo& effect, const Json& where, const Json& parameters);

}  // namespace hrp::diagnosis
