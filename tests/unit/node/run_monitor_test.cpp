// SPDX-License-Identifier: BSD-3-Clause
// The launcher believes in the end that its scheduler signed, whatever others write to run_status afterwards.
#include <gtest/gtest.h>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/topics.h"
#include "common/node/run_token.h"
#include "servers/console/launcher/monitor.h"

namespace hrp::test {
namespace {

const char kToken[] = "00112233445566778899aabbccddeeff";

class Monitor : public ::testing::Test {
 protected:
  void send(msg::RunPhase phase, const std::string& token = "") {
    msg::RunStatus status;
    status.phase(phase);
    status.message(phase == msg::RUN_FAILED ? "logger: the disk is full" : "");
    sign(token, topics::kRunStatus.type_name, &status);
    publisher_.publish(status);
    bus_.spin(std::chrono::milliseconds(0));
  }

  MemoryBus bus_;
  RunMonitor monitor_{bus_, kToken};
  Publisher<msg::RunStatus> publisher_{bus_, topics::kRunStatus};
};

TEST_F(Monitor, DoesNotBelieveInAnEndThatIsNotSigned) {
  send(msg::RUN_RUNNING);
  send(msg::RUN_FINISHED);
  send(msg::RUN_FAILED, "guessed");
  EXPECT_FALSE(monitor_.has_ended());
}

// Before, such a run ended with status 0: its failure was forgotten.
TEST_F(Monitor, KeepsAFailureWhateverIsSaidAfterwards) {
  send(msg::RUN_FAILED, kToken);
  for (const auto phase : {msg::RUN_WAITING, msg::RUN_RUNNING, msg::RUN_PAUSED}) send(phase);
  send(msg::RUN_FINISHED, kToken);  // recorded earlier, and sent again
  EXPECT_TRUE(monitor_.has_ended());
  EXPECT_EQ(monitor_.run_status().phase(), msg::RUN_FAILED);
  EXPECT_EQ(monitor_.run_status().message(), "logger: the disk is full");
}

TEST_F(Monitor, HearsThatARunWhichWentWellFailedInTheEnd) {
  send(msg::RUN_FINISHED, kToken);
  send(msg::RUN_RUNNING);
  EXPECT_EQ(monitor_.run_status().phase(), msg::RUN_FINISHED);
  send(msg::RUN_FAILED, kToken);
  EXPECT_EQ(monitor_.run_status().phase(), msg::RUN_FAILED);
}

// Looked at ten times a second, a run of 40 s that takes 0.8 s seemed a tenth faster than it was, a short one
// endlessly.
TEST_F(Monitor, NotesTheFirstStepWhenItIsReportedAndNotWhenSomebodyLooks) {
  Publisher<msg::ServerStatus> servers(bus_, topics::kServerStatus);
  const auto report = [&](const char* server, uint64_t step) {
    msg::ServerStatus status;
    status.server(server);
    status.step(step);
    servers.publish(status);
    bus_.spin(std::chrono::milliseconds(0));
    return RunMonitor::Clock::now();
  };
  const auto otherwise = RunMonitor::Clock::time_point{};
  report("dynamics", 0);
  report("logger", 16);
  EXPECT_EQ(monitor_.find_first_step(otherwise), otherwise);
  const auto before = RunMonitor::Clock::now();
  const auto after = report("dynamics", 16);
  report("dynamics", 32);
  EXPECT_GE(monitor_.find_first_step(otherwise), before);
  EXPECT_LE(monitor_.find_first_step(otherwise), after);
}

}  // namespace
}  // namespace hrp::test
