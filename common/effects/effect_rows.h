// SPDX-License-Identifier: BSD-3-Clause
// The parts of the table. Private to common/effects.
#pragma once

#include <vector>

#include "common/effects/effect_info.h"
#include "common/effects/effect_target.h"

namespace hrp {

std::vector<EffectInfo> list_friction_rows();
std::vector<EffectInfo> list_drive_rows();
std::vector<EffectInfo> list_transmission_rows();
std::vector<EffectInfo> list_link_rows();
std::vector<EffectInfo> list_world_rows();
std::vector<EffectInfo> list_sensor_rows();

EffectInfo make_row(EffectId id, const char* name, PlaceKind place, EffectFamily family, const char* phrase,
                    std::vector<EffectParameter> parameters);
// Three parameters of one name: a vector.
std::vector<EffectParameter> make_axes(const EffectParameter& parameter);

}  // namespace hrp
