// SPDX-License-Identifier: BSD-3-Clause
// What the rows of the table of standing robots (effects.h) are made with. Private to effect_rows.cpp, which has the
// rows of joints, links, feet and ground, and to sensor_rows.cpp.
#pragma once

#include <vector>

#include "diagnosis/standing/effects.h"

namespace hrp::diagnosis::standing {

// `neutral`, `step`: by coefficient, in its unit; `step` of finite differences.
StandRow make_row(EffectId id, std::vector<double> neutral, std::vector<double> step, bool positive = false);

// One start for each value of a coefficient.
std::vector<Start> list_at(size_t coefficient, const std::vector<double>& values);

// One row per reading of a joint, force sensor or IMU, with steps of the reading's size.
void add_sensor_rows(std::vector<StandRow>* rows);

}  // namespace hrp::diagnosis::standing
