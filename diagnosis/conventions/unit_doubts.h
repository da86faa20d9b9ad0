// SPDX-License-Identifier: BSD-3-Clause
// What the report says of efforts whose unit the motion does not tell, or of which it tells a lower bound only.
#pragma once

#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

// Whether any joint's effort was recorded.
bool has_effort(const Experiment& experiment);

// Joints whose motion does not tell the unit of their recorded effort. One log has one unit, so torques at one joint
// are torques at all. Counts of drives differ, so the unit of others' counts says nothing. With the scale that each has
// without a rotor; 1 if there is none.
std::vector<EffortUnit> list_untold_units(const TorqueData& as_logged, const std::vector<EffortUnit>& units);

// Marks findings at these joints: their torques and inertias are in the unit of the log. A rotor much larger than the
// bodies may be that unit.
void doubt_untold_units(const Experiment& as_logged, const std::vector<EffortUnit>& untold, Reports* reports);

// Marks findings at joints whose unit is a lower bound: their torques and inertias grow with it.
void doubt_least_units(const Experiment& as_logged, const std::vector<EffortUnit>& units, Reports* reports);

// Findings beside units that the motion tells: torques and inertias at a joint are as uncertain as its unit, masses and
// forces as the load that was found together with the units, friction that grows with the load as the load's torque.
// Where no load shows beside units, or a unit is hardly known, they are ambiguous, with the units as alternatives.
void doubt_beside_units(const Experiment& as_logged, const std::vector<EffortUnit>& units, Reports* reports);

// Where no effort was logged, stated gains give it: a constant force along gravity then scales the torque of weight as
// a wrong gain does, and is ambiguous. Certain findings stay: gains that explain everything to the noise are right.
void doubt_upright_forces(const Experiment& experiment, Json* report);

}  // namespace hrp::diagnosis
