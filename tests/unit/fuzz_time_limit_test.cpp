// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <ctime>
#include <thread>

#include "tests/fuzz/time_limit.h"

using namespace std::chrono_literals;

// The fuzz target of this test: the first byte says what to do, the second for how many units of 10 ms.
extern "C" int __real_LLVMFuzzerTestOneInput(const uint8_t* data, size_t) {
  if (data[0] == 'w') std::this_thread::sleep_for(data[1] * 10ms);
  const std::clock_t end = std::clock() + data[1] * (CLOCKS_PER_SEC / 100);  // of this process's processor time
  while (data[0] == 'c' && std::clock() < end) {
  }
  return 0;
}

namespace hrp::test {
namespace {

// In a process of its own, with a limit of 0.5 s: what each input does.
void feed(char what, uint8_t time, int inputs) {
  limit_processor_time(500ms);
  const uint8_t input[] = {static_cast<uint8_t>(what), time};
  for (int i = 0; i < inputs; ++i) __wrap_LLVMFuzzerTestOneInput(input, sizeof input);
  std::exit(0);
}

TEST(FuzzTimeLimit, AnInputThatComputesBeyondTheLimitEndsTheTarget) {
  EXPECT_EXIT(feed('c', 100, 1), testing::KilledBySignal(SIGABRT), "one input took more processor time than the limit");
}

TEST(FuzzTimeLimit, AnInputThatOnlyWaitsTakesNoTime) { EXPECT_EXIT(feed('w', 100, 1), testing::ExitedWithCode(0), ""); }

TEST(FuzzTimeLimit, EachInputHasTheWholeLimit) { EXPECT_EXIT(feed('c', 25, 4), testing::ExitedWithCode(0), ""); }

}  // namespace
}  // namespace hrp::test
