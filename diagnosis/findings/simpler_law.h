// SPDX-License-Identifier: BSD-3-Clause
// Names the simpler law unless the recordings distinguish the richer one from it.
#pragma once

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// A Stribeck curve is Coulomb friction with an excess F_s - F_c at rest, which ends at the speed v_s. If the intervals
// contain both F_s = F_c and v_s = 0, Coulomb friction is named (at most `supported`), with the curve as alternative.
// The same if the interval of F_s contains F_c and ends within a twentieth above it, whatever v_s is; then the grade
// stays. Its viscous part becomes a separate finding if its interval excludes 0. A sole of stiffness K (1 + (angle /
// hardening_angle)^2) is linear if 1 / hardening_angle^2 is not significant. Then `foot_compliance` is named, with the
// hardening sole as alternative.
void name_simpler_laws(nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
