// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/state.h"

#include <cstring>

namespace hrp {
namespace {

// FNV-1a, 64 bits, over the bytes of n doubles.
unsigned long long add_to_hash(unsigned long long hash, const double* values, Eigen::Index n) {
  for (Eigen::Index i = 0; i < n; ++i) {
    unsigned char bytes[sizeof(double)];
    std::memcpy(bytes, values + i, sizeof(double));
    for (unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211ULL;
  }
  return hash;
}

}  // namespace

unsigned long long calc_state_hash(const State& state) {
  const double attitude[4] = {state.R_WB.w(), state.R_WB.x(), state.R_WB.y(), state.R_WB.z()};
  unsigned long long hash = 14695981039346656037ULL;
  hash = add_to_hash(hash, attitude, 4);
  hash = add_to_hash(hash, state.p_WB.data(), 3);
  hash = add_to_hash(hash, state.V_WB.data(), 6);
  hash = add_to_hash(hash, state.q.data(), state.q.size());
  return add_to_hash(hash, state.qd.data(), state.qd.size());
}

}  // namespace hrp
