// SPDX-License-Identifier: BSD-3-Clause
// Finds the limit, or the dead zone, of a drive that gives less torque than its log says. Many drives log what they
// were asked for.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/measurement/load_or_unit.h"

namespace hrp::diagnosis {

// The limit [N m or N] beyond which the effort of a joint is not there: one, or none. What is beyond it must be the
// whole of what is missing there, and take nine tenths of the squares that friction, a rotor and friction of the load
// leave: a wrong centre of mass took half.
std::vector<double> find_limits(const TorqueData& data, int joint);

// The width [N m or N] below which the effort of a joint does nothing, and which is missing of larger ones: one, or
// none, by the same rule, which must also hold for the samples in which the drive brakes: elsewhere, dry friction takes
// as much.
std::vector<double> find_dead_zones(const TorqueData& data, int joint);
// Torque [N m or N] per logged unit of a drive with a dead zone, by the same rule; empty: it has none. Without the
// zone, the unit would be less: small efforts give nothing.
std::optional<double> find_unit_beside_dead_zone(const UnitRows& rows);

}  // namespace hrp::diagnosis
