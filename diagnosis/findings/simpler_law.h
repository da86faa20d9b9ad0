// SPDX-License-Identifier: BSD-3-Clause
// The simpler law is named unless the recordings tell the richer one from it.
#pragma once

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// A Stribeck curve is Coulomb friction with an excess F_s - F_c at rest that ends at the speed v_s. Where the intervals
// hold both F_s = F_c and v_s = 0, Coulomb friction is named, at most `supported`, and the curve is its alternative. Its
// viscous part is a finding of its own if its interval excludes none.
// A sole of stiffness K (1 + (angle / hardening_angle)^2) gives linearly where 1 / hardening_angle^2 is not told from
// none: then `foot_compliance` is named, and the hardening sole is its alternative.
void name_simpler_laws(nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
