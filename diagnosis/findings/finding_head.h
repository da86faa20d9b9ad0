// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// What a finding of a report begins with: as sure as any, and as heavy as its share. Words and alternatives are the
// caller's.
nlohmann::ordered_json make_finding_head(const EffectInfo& effect, const nlohmann::ordered_json& where,
                                         const nlohmann::ordered_json& parameters, Grade grade, double share);

// Another effect that would explain the same, as a report states it. `motion`: that would tell the two apart; may be
// empty.
nlohmann::ordered_json state_alternative(const EffectInfo& effect, const nlohmann::ordered_json& where,
                                         const nlohmann::ordered_json& parameters, const std::string& motion = "");

}  // namespace hrp::diagnosis
