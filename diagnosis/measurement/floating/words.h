// SPDX-License-Identifier: BSD-3-Clause
// Numbers in sentences, and what findings are made of.
#pragma once

#include <string>
#include <vector>

#include "common/effects/effect_info.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis::floating {

std::string format(const char* pattern, double a, double b = 0, double c = 0, double d = 0);

// One number with its deviation.
Estimate make_one(const std::string& name, const std::string& unit, double value, double std);

// A finding of that effect and its family; grade, share and words are the caller's.
Finding make_finding(EffectId effect, const Where& where, std::vector<Estimate> parameters);

// `motion` would tell it from the finding.
Alternative make_alternative(EffectId effect, const Where& where, std::vector<Estimate> parameters,
                             const std::string& motion);

}  // namespace hrp::diagnosis::floating
