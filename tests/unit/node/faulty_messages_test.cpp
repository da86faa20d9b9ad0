// SPDX-License-Identifier: BSD-3-Clause
// The step protocol on a network that is late, repeats, forgets or mixes up.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/unit/node/fake_servers.h"
#include "tests/unit/node/faulty_bus.h"

namespace hrp::test {
namespace {

struct FaultyRun {
  FakeRunResult result;
  int faults = 0;
};

FaultyRun run_with(const MessageFaults& faults, unsigned seed) {
  FaultyRun run;
  std::shared_ptr<FaultyBus> network;
  FakeRunOptions options;
  options.network = [&](MemoryBus& bus) { return network = std::make_shared<FaultyBus>(bus, faults, seed); };
  run.result = run_fake_set(options);
  run.faults = network->count();
  return run;
}

bool is_same(const msg::RobotState& a, const msg::RobotState& b) {
  return a.header().step() == b.header().step() && a.header().time() == b.header().time() &&
         a.positions() == b.positions() && a.velocities() == b.velocities();
}

// Each run of 300 steps passes on some 2000 samples. HRP_FAULTY_SEEDS makes it more.
unsigned find_seeds() {
  const char* text = std::getenv("HRP_FAULTY_SEEDS");
  return text ? static_cast<unsigned>(std::atoi(text)) : 100u;
}
const unsigned kSeeds = find_seeds();

void expect_same_run(const MessageFaults& faults, unsigned seeds = kSeeds) {
  const FakeRunResult undisturbed = run_fake_set({});
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const FaultyRun run = run_with(faults, seed);
    ASSERT_EQ(run.result.status.phase(), msg::RUN_FINISHED) << "seed " << seed << ": " << run.result.status.message();
    ASSERT_EQ(run.result.states.size(), undisturbed.states.size()) << "seed " << seed;
    for (size_t k = 0; k < undisturbed.states.size(); ++k)
      ASSERT_TRUE(is_same(run.result.states[k], undisturbed.states[k])) << "seed " << seed << ", step " << k;
    EXPECT_GT(run.faults, 20) << "seed " << seed << ": the network was hardly disturbed";
  }
}

TEST(FaultyMessages, LateSamplesChangeNoBit) { expect_same_run({0.3, 0, 0, 0}); }
TEST(FaultyMessages, RepeatedSamplesChangeNoBit) { expect_same_run({0, 0.3, 0, 0}); }
TEST(FaultyMessages, LateRepeatsChangeNoBit) { expect_same_run({0.5, 0.3, 0, 0}); }
// Questions are asked again, in real time: few seeds.
TEST(FaultyMessages, LostSamplesAreAskedForAgain) { expect_same_run({0, 0, 0, 0.05}, 2); }

// DDS keeps the order of a writer. A network that breaks it may end a run with a reason, but never change it unsaid.
TEST(FaultyMessages, SamplesOutOfOrderNeverChangeARunUnsaid) {
  const FakeRunResult undisturbed = run_fake_set({});
  int ended = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const FaultyRun run = run_with({0.5, 0.2, 0.3, 0}, seed);
    if (run.result.status.phase() == msg::RUN_FAILED) {
      EXPECT_NE(run.result.status.message(), "") << "seed " << seed;
      ++ended;
      continue;
    }
    EXPECT_EQ(run.result.status.phase(), msg::RUN_FINISHED) << "seed " << seed;
    for (const msg::RobotState& state : run.result.states) {
      ASSERT_LT(state.header().step(), undisturbed.states.size());
      EXPECT_TRUE(is_same(state, undisturbed.states[state.header().step()]))
          << "seed " << seed << ", step " << state.header().step();
    }
  }
  RecordProperty("ended_with_a_reason", ended);
}

}  // namespace
}  // namespace hrp::test
