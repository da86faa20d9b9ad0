// SPDX-License-Identifier: BSD-3-Clause
// What the truth of a dirty world says beside the list of what is in it.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/generator/draft.h"

namespace hrp::cases {

// How much of its place's mismatch each listed effect causes, on a held-out recording: mean square of its torque over
// that of everything that is missing there; of effects on top also by the positions that they move. Of what a dirty
// world has everywhere also `over_noise`: the torque over the noise of the joint's effort.
nlohmann::ordered_json make_influences(const Draft& draft);

// The same of what a dirty world has everywhere, of a recording's `columns` as they truly were, velocities and efforts
// included. Nothing on top is counted as missing. Joints that move by less than `least_travel` [rad] are left out.
nlohmann::ordered_json make_background_influences(const RobotPlan& robot, const Dirt& dirt,
                                                  const std::vector<Column>& columns, double least_travel);

// Root mean square, by joint signal, of held-out recordings against a simulation of all listed effects with their true
// values: what a perfect answer leaves. `recorded`: columns as written, by recording; others are empty.
nlohmann::ordered_json make_listed_error(const Draft& draft, const std::vector<std::vector<Column>>& recorded);

}  // namespace hrp::cases
