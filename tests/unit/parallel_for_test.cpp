// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <vector>

namespace hrp {
namespace {

TEST(ParallelFor, DoesEveryPieceOnceWhateverTheThreads) {
  for (int jobs : {1, 2, 7}) {
    std::vector<int> done(100, 0);
    parallel_for(jobs, 100, [&](int i) { ++done[static_cast<size_t>(i)]; });
    EXPECT_EQ(done, std::vector<int>(100, 1)) << jobs;
  }
}

// A piece that runs out of memory ended the program before: an exception must not leave a thread.
TEST(ParallelFor, AFailureOfOnePieceReachesTheCaller) {
  for (int jobs : {1, 4})
    EXPECT_THROW(parallel_for(jobs, 50,
                              [](int i) {
                                if (i == 20) throw std::bad_alloc();
                              }),
                 std::bad_alloc);
}

}  // namespace
}  // namespace hrp
