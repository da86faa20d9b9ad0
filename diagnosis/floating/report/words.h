// SPDX-License-Identifier: BSD-3-Clause
// Numbers in sentences, and what findings are made of.
#pragma once

#include <string>
#include <vector>

#include "common/base/format.h"
#include "common/effects/effect_info.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis::floating {

// One number with its deviation.
Estimate make_one(const std::string& name, const std::string& unit, double value, double std);

// The first parameter of an effect. `reading_unit`: of a sensor, where the parameter has the unit of its reading.
Estimate make_value(const EffectInfo& effect, double value, double std, const std::string& reading_unit = "");

// A finding of that effect and its family; grade, share and words are the caller's.
Finding make_finding(const EffectInfo& effect, const Where& where, std::vector<Estimate> parameters);

// `motion` would tell it from the finding.
Alternative make_alternative(const EffectInfo& effect, const Where& where, std::vector<Estimate> parameters,
                             const std::string& motion);

// "stiffness 800 +- 20 N m/rad, rest 0.1 +- 0.01 rad", with 95 % intervals.
std::string describe(const std::vector<Estimate>& parameters);

// "l_knee" of {"joint": "l_knee"}.
std::string get_place(const Where& where);

}  // namespace hrp::diagnosis::floating
