// SPDX-License-Identifier: BSD-3-Clause
// Numbers in sentences, and what findings are made of.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis::floating {

std::string format(const char* pattern, double a, double b = 0, double c = 0, double d = 0);

// One number with its deviation.
Estimate make_one(const std::string& name, const std::string& unit, double value, double std);

// `motion` would tell it from the finding.
Alternative make_alternative(const std::string& effect, const Where& where, std::vector<Estimate> parameters,
                             const std::string& motion);

}  // namespace hrp::diagnosis::floating
