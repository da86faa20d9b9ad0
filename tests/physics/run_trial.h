// SPDX-License-Identifier: BSD-3-Clause
// Trials that run for a while, and that are restored.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "servers/console/trial/trial.h"

namespace hrp {

inline void run(Trial* trial, double seconds) {
  const long steps = std::lround(seconds / trial->scenario().time_step);
  for (long i = 0; i < steps; ++i) ASSERT_TRUE(trial->step()) << trial->fault();
}

// Goes back to where it is now after `seconds`, and comes to the same bits again; returns their hash.
inline unsigned long long expect_same_bits_when_restored(Trial* trial, double seconds) {
  const TrialState kept = trial->save();
  run(trial, seconds);
  const unsigned long long hash = trial->engine().state_hash();
  trial->restore(kept);
  run(trial, seconds);
  EXPECT_EQ(trial->engine().state_hash(), hash);
  return hash;
}

}  // namespace hrp
