// SPDX-License-Identifier: BSD-3-Clause
// Friction and rotors of legs that stand, in the body's balance by legs (leg_forces.h).
//
// Every drive has them, of a size that nobody states, and legs that stand pass all of them on to six equations. Beside
// none of them, whatever makes torques smaller would explain these equations best. So the rows keep only what no
// viscous, dry or load-dependent friction and no rotor of a leg's joint can make: each equation less its regression on
// these columns, over all six equations together (Frisch and Waugh, Econometrica 1933). What the joints lose is told by
// legs that swing.
//
// A joint that stands may hold its friction in either direction, and nothing shows which. What that makes, with efforts
// that are off by some percent, is how exact an equation is (ChannelInfo::error).
#pragma once

#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"

namespace hrp::diagnosis::floating {

void leave_out_leg_friction(const ColumnLayout& layout, std::vector<ChannelRows>* channels);

}  // namespace hrp::diagnosis::floating
