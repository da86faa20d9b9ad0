// SPDX-License-Identifier: BSD-3-Clause
// Real drives: viscous and dry friction, rotor inertia, friction that grows with load, delays and more in every joint
// at once, and on top of them what no list has. Sets of a few effects explain nothing there. Here every joint gets,
// along the recorded paths, all effects that help to predict what they were not fitted to; only those are findings
// whose parameters are the same in all recordings, halves and regimes.
#pragma once

#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

// True when some effects are certain: `outcome` is then partly explained. `nominal` is in the outcome already. Gives up
// at once where a joint is at the noise, as no joint with a real drive would be.
bool search_drives(const Problem& problem, const Progress& progress, Outcome* outcome);

}  // namespace hrp::diagnosis
