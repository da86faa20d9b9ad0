// SPDX-License-Identifier: BSD-3-Clause
// Numbers in sentences, and what findings are made of.
#pragma once

#include <string>
#include <vector>

#include "common/base/format.h"
#include "common/effects/effect_info.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis::floating {

// The first parameter of an effect. `reading_unit`: of a sensor, where the parameter has the unit of its reading.
Estimate make_value(const EffectInfo& effect, double value, double std, const std::string& reading_unit = "");

// "stiffness 800 +- 20 N m/rad, rest 0.1 +- 0.01 rad", with 95 % intervals.
std::string describe(const std::vector<Estimate>& parameters);

// "l_knee" of {"joint": "l_knee"}.
std::string get_place(const Where& where);

}  // namespace hrp::diagnosis::floating
