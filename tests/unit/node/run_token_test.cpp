// SPDX-License-Identifier: BSD-3-Clause
// Requests and grants are believed when they are signed with the run's token, and when they can be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <limits>

#include "common/node/run_token.h"
#include "tests/unit/node/fake_servers.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kHuge = std::numeric_limits<uint64_t>::max();
const char kToken[] = "00112233445566778899aabbccddeeff";

TEST(Signature, IsThatOfTheStandard) {
  // HMAC-SHA256, RFC 4231 test case 2, first 16 bytes.
  EXPECT_EQ(calc_signature("Jefe", "what do ya want for nothing?", 28), "5bdcc146bf60754e6a042426089575c7");
}

TEST(Signature, CoversEveryFieldAndTheType) {
  msg::RunControl control;
  control.request(msg::REQUEST_STEP);
  control.steps(3);
  control.nonce(make_nonce());
  sign(kToken, "RunControl", &control);
  EXPECT_TRUE(is_signed(kToken, "RunControl", control));
  EXPECT_FALSE(is_signed(kToken, "StepGrant", control));
  EXPECT_FALSE(is_signed("another token", "RunControl", control));
  control.steps(4);
  EXPECT_FALSE(is_signed(kToken, "RunControl", control));
  EXPECT_TRUE(is_signed("", "RunControl", control)) << "a run without a token checks nothing";
}

TEST(Signature, TokensAndNoncesDiffer) {
  EXPECT_NE(make_run_token(), make_run_token());
  EXPECT_NE(make_nonce(), make_nonce());
  UsedNonces used;
  EXPECT_TRUE(used.take(7));
  EXPECT_FALSE(used.take(7));
}

msg::StepGrant make_grant(uint64_t epoch, uint64_t through_step, bool last = false) {
  msg::StepGrant grant;
  grant.epoch(epoch);
  grant.through_step(through_step);
  grant.last(last);
  grant.for_process(getpid());
  return grant;
}

// A set of 300 steps, in which somebody sends a grant at step 100.
FakeRunResult run_with_grant(const std::string& token, msg::StepGrant grant, const std::string& signed_with) {
  FakeRunOptions options;
  options.token = token;
  sign(signed_with, topics::kStepGrant.type_name, &grant);
  std::weak_ptr<Publisher<msg::StepGrant>> publisher;
  options.join = [&](Bus& bus) {
    auto made = std::make_shared<Publisher<msg::StepGrant>>(bus, topics::kStepGrant);
    publisher = made;
    return made;
  };
  options.on_state = [&](const msg::RobotState& state, Publisher<msg::RunControl>&) {
    if (state.header().step() == 100) publisher.lock()->publish(grant);
  };
  return run_fake_set(options);
}

struct Forged {
  const char* name;
  msg::StepGrant grant;
  const char* said;  // when it has to be believed
};
void PrintTo(const Forged& forged, std::ostream* out) { *out << forged.name; }
class Grant : public ::testing::TestWithParam<Forged> {};

TEST_P(Grant, ThatIsNotSignedChangesNothing) {
  const FakeRunResult run = run_with_grant(kToken, GetParam().grant, "guessed");
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  EXPECT_EQ(run.states.size(), 301u);
  EXPECT_EQ(run.states.back().header().epoch(), 0u);
}

TEST_P(Grant, ThatIsSignedAndCannotBeIsAFaultWithItsName) {
  for (const std::string token : {"", kToken}) {
    const FakeRunResult run = run_with_grant(token, GetParam().grant, token);
    EXPECT_EQ(run.status.phase(), msg::RUN_FAILED) << "with token '" << token << "'";
    EXPECT_THAT(run.status.message(), HasSubstr("dynamics: step_grant"));
    EXPECT_THAT(run.status.message(), HasSubstr(GetParam().said));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, Grant,
    ::testing::Values(
        Forged{"far_epoch", make_grant(kHuge, 10), "names epoch 18446744073709551615, this run is at epoch 0"},
        Forged{"far_step", make_grant(0, kHuge), "allows steps up to 18446744073709551615"},
        Forged{"next_epoch_far_step", make_grant(1, kHuge), "allows steps up to 18446744073709551615 at step 0"},
        Forged{"early_last", make_grant(0, 150, true), "after it had said that step 150 is the last"}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(Refusal, ThatIsNotSignedIsBelievedByNobodyWithTheToken) {
  msg::RunStatus status;
  status.refused("no such request");
  EXPECT_FALSE(may_believe(kToken, {}, status));
  EXPECT_TRUE(may_believe("", {}, status));
  sign(kToken, topics::kRunStatus.type_name, &status);
  EXPECT_TRUE(may_believe(kToken, {}, status));
}

TEST(Request, WithTheTokenThatCannotBeIsRefusedWithASignature) {
  FakeRunOptions options;
  options.token = kToken;
  bool believed = false;
  options.join = [&](Bus& bus) -> std::shared_ptr<Reader> {
    return subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable, [&](const msg::RunStatus& m) {
      believed |= !m.refused().empty() && may_believe(kToken, {}, m);
    });
  };
  options.on_state = [](const msg::RobotState& m, Publisher<msg::RunControl>& control) {
    msg::RunControl run;
    run.request(msg::REQUEST_RUN);
    run.change_speed(true);
    run.speed(-1.0);
    sign(kToken, topics::kRunControl.type_name, &run);
    if (m.header().step() == 100) control.publish(run);
  };
  run_fake_set(options);
  EXPECT_TRUE(believed);
}

// Who steers may send a request again until it is heard.
TEST(Request, ThatIsSentThreeTimesIsTakenOnce) {
  for (const std::string token : {"", kToken}) {
    FakeRunOptions options;
    options.token = token;
    size_t answers = 0;
    options.join = [&](Bus& bus) -> std::shared_ptr<Reader> {
      return subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable,
                                       [&](const msg::RunStatus& m) { answers += m.refused().empty() ? 0 : 1; });
    };
    msg::RunControl impossible;  // as each that is taken is refused, refusals count them
    impossible.request(msg::REQUEST_RUN);
    impossible.change_speed(true);
    impossible.speed(-1.0);
    impossible.nonce(make_nonce());
    sign(token, topics::kRunControl.type_name, &impossible);
    options.on_state = [&](const msg::RobotState& m, Publisher<msg::RunControl>& control) {
      if (m.header().step() == 100 || m.header().step() == 150 || m.header().step() == 200) control.publish(impossible);
    };
    run_fake_set(options);
    EXPECT_EQ(answers, 1u) << "with token '" << token << "'";
  }
}

// Aloud, and unsigned: the owner of the run must not take it for an answer to a request of his own.
TEST(Request, WithoutTheTokenIsRefusedAloud) {
  FakeRunOptions options;
  options.token = kToken;
  std::string refused;
  bool believed = false;
  options.join = [&](Bus& bus) -> std::shared_ptr<Reader> {
    return subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable, [&](const msg::RunStatus& m) {
      if (!m.refused().empty()) {
        refused = m.refused();
        believed |= may_believe(kToken, {}, m);
      }
    });
  };
  options.on_state = [](const msg::RobotState& m, Publisher<msg::RunControl>& control) {
    msg::RunControl stop;
    stop.request(msg::REQUEST_STOP);
    if (m.header().step() == 100) control.publish(stop);
  };
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.states.size(), 301u);
  EXPECT_THAT(refused, HasSubstr("only the user who started this run may steer it"));
  EXPECT_FALSE(believed);
}

TEST(Request, WithTheTokenIsFollowed) {
  FakeRunOptions options;
  options.token = kToken;
  options.on_state = [](const msg::RobotState& m, Publisher<msg::RunControl>& control) {
    msg::RunControl stop;
    stop.request(msg::REQUEST_STOP);
    sign(kToken, topics::kRunControl.type_name, &stop);
    if (m.header().step() == 100) control.publish(stop);
  };
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED);
  EXPECT_LT(run.states.back().header().step(), 300u);
}

}  // namespace
}  // namespace hrp::test
