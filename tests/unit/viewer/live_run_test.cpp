// SPDX-License-Identifier: BSD-3-Clause
// Requests of a page reach the scheduler, whichever of the two was there first.
#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/domain.h"
#include "common/bus/memory/memory_bus.h"
#include "common/messages/topics.h"
#include "common/node/run_token.h"
#include "servers/viewer/live_run.h"
#include "tests/unit/run_folder.h"

namespace hrp::test {
namespace {

const char kToken[] = "00112233445566778899aabbccddeeff";

class Steering : public OwnRunFolder {
 protected:
  std::unique_ptr<Reader> listen() {
    return subscribe<msg::RunControl>(bus_, topics::kRunControl, Delivery::kReliable,
                                      [this](const msg::RunControl& m) { heard_.push_back(m); });
  }
  static msg::RunControl make_pause() {
    msg::RunControl pause;
    pause.request(msg::REQUEST_PAUSE);
    return pause;
  }
  // True when a request was given up.
  bool send_for(LiveRun* run, std::chrono::milliseconds time) {
    bool given_up = false;
    for (const auto end = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < end;) {
      given_up |= run->send_requests();
      bus_.spin(std::chrono::milliseconds(5));
    }
    return given_up;
  }

  MemoryBus bus_;
  std::vector<msg::RunControl> heard_;
};

TEST_F(Steering, KeepsARequestForASchedulerThatIsFoundLate) {
  LiveRun run(bus_, /*read_only=*/false);
  run.request(make_pause());
  EXPECT_FALSE(send_for(&run, std::chrono::milliseconds(150)));
  const auto reader = listen();
  EXPECT_FALSE(send_for(&run, std::chrono::milliseconds(1200)));
  ASSERT_GE(heard_.size(), 2u) << "it is sent again, as a first one may be lost";
  std::set<uint64_t> nonces;
  for (const msg::RunControl& control : heard_) nonces.insert(control.nonce());
  EXPECT_EQ(nonces.size(), 1u) << "the scheduler has to know it again";
}

TEST_F(Steering, SaysWhenNobodyListens) {
  LiveRun run(bus_, /*read_only=*/false);
  run.request(make_pause());
  EXPECT_TRUE(send_for(&run, std::chrono::milliseconds(1200)));
}

// A viewer of `--domain N` that was started with the run, and was faster.
TEST_F(Steering, SignsWithTheTokenOfARunThatWasRegisteredLater) {
  JoinedRun joined;
  joined.entry.domain = 77;
  LiveRun run(bus_, /*read_only=*/false, joined);
  const auto reader = listen();
  DomainClaim claim = claim_domain(77, "late.yaml");
  RunEntry entry = claim.entry();
  entry.token = kToken;
  claim.describe(entry);
  run.request(make_pause());
  send_for(&run, std::chrono::milliseconds(50));
  ASSERT_FALSE(heard_.empty());
  EXPECT_TRUE(is_signed(kToken, topics::kRunControl.type_name, heard_.front()));
}

TEST_F(Steering, ChangesNothingWhenItIsReadOnly) {
  LiveRun run(bus_, /*read_only=*/true);
  const auto reader = listen();
  run.request(make_pause());
  EXPECT_FALSE(send_for(&run, std::chrono::milliseconds(100)));
  EXPECT_TRUE(heard_.empty());
}

}  // namespace
}  // namespace hrp::test
