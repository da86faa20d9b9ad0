// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/state.h"

#include "common/base/bit_hash.h"

namespace hrp {

unsigned long long calc_state_hash(const State& state) {
  const double attitude[4] = {state.R_WB.w(), state.R_WB.x(), state.R_WB.y(), state.R_WB.z()};
  BitHash hash;
  hash.add(attitude, 4);
  hash.add(state.p_WB.data(), 3);
  hash.add(state.V_WB.data(), 6);
  hash.add(state.q.data(), static_cast<size_t>(state.q.size()));
  hash.add(state.qd.data(), static_cast<size_t>(state.qd.size()));
  return hash.get();
}

}  // namespace hrp
