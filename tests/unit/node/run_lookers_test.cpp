// SPDX-License-Identifier: BSD-3-Clause
// Those who look at a run believe in the end that its scheduler signed. Before, anybody could tell them that it was
// over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/pubsub.h"
#include "common/messages/topics.h"
#include "common/node/run_token.h"
#include "servers/console/doctor/run.h"
#include "servers/console/run_control/run_control.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

const char kToken[] = "00112233445566778899aabbccddeeff";

// A run at step 7, and somebody who says after it that it has failed; who comes later hears both, in this order.
class Looker : public ::testing::Test {
 protected:
  Looker() { run_.entry.token = kToken; }
  void let_both_speak(const std::string& token_of_the_end) {
    msg::RunStatus runs, over;
    runs.phase(msg::RUN_RUNNING);
    runs.step(7);
    over.phase(msg::RUN_FAILED);
    over.message("it is burning");
    sign(token_of_the_end, topics::kRunStatus.type_name, &over);
    scheduler_.publish(runs);
    guest_.publish(over);
  }
  std::string ask_hrp_run() {
    testing::internal::CaptureStdout();
    EXPECT_EQ(show_status(bus_, run_, /*follow=*/false), 0);
    return testing::internal::GetCapturedStdout();
  }
  std::string ask_doctor() { return check_phase(bus_, run_.entry).says; }

  MemoryBus bus_;
  JoinedRun run_;
  Publisher<msg::RunStatus> scheduler_{bus_, topics::kRunStatus}, guest_{bus_, topics::kRunStatus};
};

TEST_F(Looker, DoesNotBelieveInAnEndThatIsNotSigned) {
  let_both_speak("guessed");
  EXPECT_THAT(ask_hrp_run(), HasSubstr("running epoch 0 step 7"));
  EXPECT_THAT(ask_doctor(), HasSubstr("it runs, step 7"));
}

TEST_F(Looker, BelievesInTheEndThatTheSchedulerSigned) {
  let_both_speak(kToken);
  EXPECT_THAT(ask_hrp_run(), HasSubstr("failed epoch 0 step 0"));
  EXPECT_THAT(ask_doctor(), HasSubstr("it is burning"));
}

TEST_F(Looker, WithoutTheTokenOfARunHasToBelieve) {
  run_.entry.token.clear();  // another user's run
  let_both_speak(kToken);
  EXPECT_THAT(ask_hrp_run(), HasSubstr("failed"));
}

}  // namespace
}  // namespace hrp::test
