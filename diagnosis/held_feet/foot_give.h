// SPDX-License-Identifier: BSD-3-Clause
// What gives between the joints' encoders and the ground: a foot whose height by the chain of encoders falls as the
// ground carries more of it.
//
//   z_WF(q) = z_0 - F_z / k + sum_j dz/dq_j o_j,   o_j: zeros of the encoders, a nuisance
#pragma once

#include <vector>

#include "diagnosis/measurement/foot_loads.h"

namespace hrp::diagnosis::held_feet {

struct FootGive {
  size_t foot = 0;                   // of list_loaded_feet()
  double compliance = 0.0;           // [m/N] 1 / k
  double std = 0.0;                  // of it, with what parts of the recordings differ by
  double before = 0.0, after = 0.0;  // [m] spread of the foot's height, without and with it
  bool same_everywhere = false;      // no part of the recordings asks for another value
  std::vector<double> lever;         // [m/rad] by joint: root mean square of dz/dq while the foot is loaded
};

// Of feet that are loaded in recordings in which the position of every joint was measured; only what is significant.
std::vector<FootGive> find_foot_gives(const Experiment& experiment, const std::vector<LoadedFoot>& feet);

}  // namespace hrp::diagnosis::held_feet
