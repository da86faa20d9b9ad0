// SPDX-License-Identifier: BSD-3-Clause
// Six real processes: the same bits however they run, and failures that are said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <thread>

#include "common/bus/make_bus.h"
#include "common/messages/topics.h"
#include "tests/process/run_and_digest.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

const std::string kEndless = "{time_step: 0.001, control_period: 0.005, duration: 0}";

std::string make_odd_controller(const std::string& mode) {
  return "controller=" + bin_dir() + "/hrp-odd-controller-" + mode;
}

// ---- the same bits ------------------------------------------------------------------------------------------------

class SameBits : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    reference_ = run_and_digest("reference", write_scenario("same"), {"--in-process", "--force"});
  }
  static std::map<std::string, TopicDigest> reference_;
};
std::map<std::string, TopicDigest> SameBits::reference_;

TEST_F(SameBits, TheReferenceHoldsEveryStep) {
  EXPECT_EQ(reference_["hrp/robot_state"].count, 501u);
  EXPECT_EQ(reference_["hrp/contact_set"].count, 500u);
  EXPECT_EQ(reference_["hrp/joint_commands"].count, 100u);
}
TEST_F(SameBits, InOneProcessAgain) {
  EXPECT_EQ(run_and_digest("again", write_scenario("same"), {"--in-process"}), reference_);
}
TEST_F(SameBits, InSixProcessesOnCyclone) {
  EXPECT_EQ(run_and_digest("cyclone", write_scenario("same"), {"--dds", "cyclone"}), reference_);
}
TEST_F(SameBits, InSixProcessesOnFast) {
  EXPECT_EQ(run_and_digest("fast", write_scenario("same"), {"--dds", "fast"}), reference_);
}
TEST_F(SameBits, OnAMixOfBoth) {
  EXPECT_EQ(run_and_digest("mix", write_scenario("same"), {"--dds-for", "dynamics=fast", "--dds-for", "logger=fast"}),
            reference_);
}
TEST_F(SameBits, WithAControllerThatSleepsAtRandom) {
  EXPECT_EQ(run_and_digest("sleepy", write_scenario("same"), {"--program", make_odd_controller("sleepy")}), reference_);
}
TEST_F(SameBits, WithTwoObserversAttached) {
  std::vector<std::unique_ptr<Bus>> buses;
  std::vector<std::unique_ptr<Reader>> readers;
  const auto attach = [&](ServerSet& set) {
    for (const char* vendor : {"cyclone", "fast"}) {
      BusOptions options;
      options.vendor = vendor;
      options.domain = set.find_domain();
      buses.push_back(make_bus(options));
      for (const TopicSpec& topic : {topics::kRobotState, topics::kContactForces, topics::kSensorData}) {
        readers.push_back(buses.back()->make_reader(topic, Delivery::kBestEffort, [](Bytes) {}));
      }
    }
  };
  EXPECT_EQ(run_and_digest("observed", write_scenario("same"), {}, attach), reference_);
  readers.clear();
}

class StalledLogger : public SameBits, public ::testing::WithParamInterface<const char*> {};

TEST_P(StalledLogger, TheRunWaitsForItAndItsLogHoldsEveryStep) {
  const auto stall = [](ServerSet& set) {
    ASSERT_TRUE(set.wait_for_step(1)) << set.output();
    ASSERT_EQ(kill(set.find_server("hrp-logger"), SIGSTOP), 0);
    EXPECT_TRUE(set.wait_for_step(500)) << set.output();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));  // others that did not wait for it would be gone
    ASSERT_EQ(kill(set.find_server("hrp-logger"), SIGCONT), 0);
  };
  EXPECT_EQ(run_and_digest(std::string("stalled-") + GetParam(), write_scenario("same"), {"--dds", GetParam()}, stall),
            reference_);
}
INSTANTIATE_TEST_SUITE_P(Vendors, StalledLogger, ::testing::Values("cyclone", "fast"));

// ---- ends ---------------------------------------------------------------------------------------------------------

void expect_nothing_left(int domain) {
  EXPECT_TRUE(wait_until([domain] { return find_servers(domain).empty(); }));
}

void expect_next_run_works() {
  ServerSet next("next", {write_scenario("next"), "--force"});
  EXPECT_EQ(next.wait(), 0) << next.output();
}

struct Victim {
  const char* role;
  const char* program;
};
void PrintTo(const Victim& victim, std::ostream* out) { *out << victim.role; }

class Killed : public ::testing::TestWithParam<Victim> {};

TEST_P(Killed, TheSetStopsWithNameAndStepAndLeavesAGoodLog) {
  const Victim victim = GetParam();
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet set(std::string("killed-") + victim.role, {write_scenario("endless", change)});
  const int domain = set.find_domain();
  std::mt19937 random(static_cast<unsigned>(victim.role[0]) * 7919u);  // fixed: the moment differs from role to role
  ASSERT_TRUE(set.wait_for_step(200 + random() % 3000)) << set.output();
  ASSERT_EQ(kill(set.find_server(victim.program), SIGKILL), 0);
  EXPECT_EQ(set.wait(), 1);
  EXPECT_THAT(set.output(), HasSubstr(victim.role));
  EXPECT_THAT(set.output(), HasSubstr("SIGKILL"));
  const long step = find_named_step(set.output());
  EXPECT_GE(step, 0) << set.output();
  EXPECT_GE(find_last_step(set.log()), step) << "the log is complete up to the step that was named\n" << set.output();
  expect_nothing_left(domain);
  expect_next_run_works();
}

INSTANTIATE_TEST_SUITE_P(EachServer, Killed,
                         ::testing::Values(Victim{"model_parser", "hrp-model-parser"},
                                           Victim{"scheduler", "hrp-scheduler"}, Victim{"logger", "hrp-logger"},
                                           Victim{"dynamics", "hrp-dynamics"},
                                           Victim{"collision_checker", "hrp-collision-checker"},
                                           Victim{"controller", "hrp-controller"}),
                         [](const auto& info) { return std::string(info.param.role); });

TEST(End, ServersDoNotOutliveAKilledLauncher) {
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet set("orphans", {write_scenario("orphans", change)});
  const int domain = set.find_domain();
  ASSERT_TRUE(set.wait_for_step(100)) << set.output();
  set.send_signal(SIGKILL);
  EXPECT_EQ(set.wait(), -SIGKILL);
  expect_nothing_left(domain);
}

TEST(End, ServersDoNotOutliveALauncherThatIsKilledWhileItStartsThem) {
  ScenarioChange change;
  change.steps = kEndless;
  const std::string scenario = write_scenario("early-orphans", change);
  for (int delay = 0; delay <= 60;
       delay += 5) {  // [ms]; the last server is there after some 10 ms, the first step after 100
    ServerSet set("early-orphans-" + std::to_string(delay), {scenario, "--dds", delay % 2 == 0 ? "cyclone" : "fast"});
    std::this_thread::sleep_for(std::chrono::milliseconds(delay));
    set.send_signal(SIGSTOP);  // its children are counted before it goes
    std::vector<pid_t> servers;
    for (const ProcessSeen& process : find_processes()) {
      if (process.parent_id == set.process_id()) servers.push_back(process.process_id);
    }
    set.send_signal(SIGKILL);
    EXPECT_EQ(set.wait(), -SIGKILL);
    EXPECT_TRUE(wait_until([&] {
      return std::all_of(servers.begin(), servers.end(), [](pid_t server) { return kill(server, 0) != 0; });
    })) << servers.size()
        << " servers, killed after " << delay << " ms";
  }
}

// A busy machine may let the launcher sleep until everybody has gone, and with them what they said last.
class SleepingLauncher : public testing::TestWithParam<std::string> {};

TEST_P(SleepingLauncher, KnowsFromTheSchedulerThatTheRunEndedWell) {
  ServerSet set("asleep-" + GetParam(), {write_scenario("asleep"), "--realtime", "--dds", GetParam()});
  const int domain = set.find_domain();
  ASSERT_TRUE(wait_until([&] { return find_servers(domain).size() == 6; }));
  set.send_signal(SIGSTOP);
  ASSERT_TRUE(wait_until([&] { return find_servers(domain).empty(); }));
  set.send_signal(SIGCONT);
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("complete up to step 500"));
}
INSTANTIATE_TEST_SUITE_P(Vendors, SleepingLauncher, testing::Values("cyclone", "fast"),
                         [](const auto& info) { return info.param; });

TEST(End, CtrlCEndsCleanly) {
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet set("interrupted", {write_scenario("interrupted", change)});
  ASSERT_TRUE(set.wait_for_step(300)) << set.output();
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("complete up to step"));
  EXPECT_GE(find_last_step(set.log()), 300);
}

// With the policy "batch", a thread that is woken waits until the one that runs on its core does.
TEST(Scheduling, NoThreadOfAServerPushesAnotherOneOffItsCore) {
  ServerSet set("scheduling", {write_scenario("scheduling", {"{type: hold}", "{duration: 0}"}), "--quiet"});
  ASSERT_TRUE(set.wait_for_step(100)) << set.output();
  for (const char* program :
       {"hrp-dynamics", "hrp-collision-checker", "hrp-controller", "hrp-logger", "hrp-scheduler"}) {
    const std::string threads = "/proc/" + std::to_string(set.find_server(program)) + "/task";
    size_t count = 0;
    for (const auto& thread : std::filesystem::directory_iterator(threads)) {
      EXPECT_EQ(sched_getscheduler(std::stoi(thread.path().filename().string())), SCHED_BATCH) << program;
      ++count;
    }
    EXPECT_GT(count, 1u) << program << " has those of its DDS, too";
  }
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

TEST(SideBySide, TwoSimulationsDoNotSeeEachOther) {
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet one("one", {write_scenario("one", change)}), two("two", {write_scenario("two", change)});
  ASSERT_TRUE(one.wait_for_step(200)) << one.output();
  ASSERT_TRUE(two.wait_for_step(200)) << two.output();
  EXPECT_NE(one.find_domain(), two.find_domain());
  one.send_signal(SIGINT);
  EXPECT_EQ(one.wait(), 0) << one.output();
  const uint64_t step = two.run_status().step();
  EXPECT_TRUE(two.wait_for_step(step + 200)) << "the other one goes on\n" << two.output();
  two.send_signal(SIGINT);
  EXPECT_EQ(two.wait(), 0) << two.output();
}

// ---- controllers that fail ----------------------------------------------------------------------------------------

struct Oddity {
  const char* mode;
  const char* said;
};
void PrintTo(const Oddity& oddity, std::ostream* out) { *out << oddity.mode; }
class OddController : public ::testing::TestWithParam<Oddity> {};

TEST_P(OddController, IsNamedAndStopsTheRun) {
  ScenarioChange change;
  change.controller = "{type: hold, on_fault: stop, timeout: 0.3}";
  ServerSet set(std::string("odd-stop-") + GetParam().mode,
                {write_scenario("odd", change), "--program", make_odd_controller(GetParam().mode)});
  EXPECT_EQ(set.wait(), 1) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("controller"));
  EXPECT_THAT(set.output(), HasSubstr(GetParam().said));
  EXPECT_THAT(set.output(), HasSubstr("step 100"));
}

TEST_P(OddController, IsNamedAndHeldWhenTheScenarioSaysSo) {
  ScenarioChange change;
  change.controller = "{type: hold, on_fault: hold, timeout: 0.3}";
  ServerSet set(std::string("odd-hold-") + GetParam().mode,
                {write_scenario("odd", change), "--program", make_odd_controller(GetParam().mode)});
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_THAT(set.output(), HasSubstr(GetParam().said));
  EXPECT_EQ(find_last_step(set.log()), 500);
}

INSTANTIATE_TEST_SUITE_P(Each, OddController,
                         ::testing::Values(Oddity{"nan", "NaN"}, Oddity{"short", "joints"}, Oddity{"stale", "stale"},
                                           Oddity{"silent", "has not answered"}),
                         [](const auto& info) { return std::string(info.param.mode); });

// ---- steering and rejoining ---------------------------------------------------------------------------------------

TEST(Steering, PauseStepRunAndReset) {
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet set("steered", {write_scenario("steered", change)});
  const std::string domain = std::to_string(set.find_domain());
  const auto steer = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"hrp-run", "--domain", domain});
    Program tool(words);
    EXPECT_EQ(tool.wait(), 0) << tool.output();
  };
  ASSERT_TRUE(set.wait_for_step(100)) << set.output();
  steer({"pause"});
  ASSERT_TRUE(wait_until([&] { return set.run_status().phase() == msg::RUN_PAUSED; }));
  const uint64_t paused_at = set.run_status().step();
  steer({"step", "7"});
  EXPECT_TRUE(wait_until([&] { return set.run_status().step() == paused_at + 7; })) << set.run_status().step();
  steer({"reset"});
  EXPECT_TRUE(wait_until([&] { return set.run_status().epoch() == 1 && set.run_status().step() == 0; }));
  steer({"run"});
  EXPECT_TRUE(set.wait_for_step(100));
  EXPECT_EQ(set.run_status().epoch(), 1u);
  steer({"stop"});
  EXPECT_EQ(set.wait(), 0) << set.output();
}

TEST(Steering, AResumedRunKeepsItsPaceAndBadSpeedsAreRefused) {
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet set("paced", {write_scenario("paced", change), "--realtime"});
  const std::string domain = std::to_string(set.find_domain());
  const auto steer = [&](std::vector<std::string> words, int status) {
    words.insert(words.begin(), {"hrp-run", "--domain", domain});
    Program tool(words);
    EXPECT_EQ(tool.wait(), status) << tool.output();
    return tool.output();
  };
  ASSERT_TRUE(set.wait_for_step(10)) << set.output();
  steer({"pause"}, 0);
  for (const char* speed : {"nan", "-1", "1e-9", "inf"})
    EXPECT_THAT(steer({"run", "--speed", speed}, 2), HasSubstr("refused: speed is"));
  EXPECT_EQ(set.run_status().phase(), msg::RUN_PAUSED);
  steer({"run"}, 0);
  EXPECT_EQ(set.run_status().speed(), 1.0);
  EXPECT_EQ(set.run_status().phase(), msg::RUN_RUNNING);
  steer({"stop"}, 0);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

TEST(Rejoining, AControllerOfOnesOwnMayComeLateAndComeBack) {
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet set("own", {write_scenario("own", change), "--without", "controller"});
  const std::string domain = std::to_string(set.find_domain());
  ASSERT_TRUE(wait_until([&] { return set.run_status().late() == "controller"; })) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("hrp/sensor_data"));
  EXPECT_THAT(set.output(), HasSubstr("my-controller --run " + std::to_string(set.process_id())));
  uint64_t step = 0;
  {
    Program controller({"my-controller", "--domain", domain});
    ASSERT_TRUE(set.wait_for_step(100)) << set.output() << controller.output();
    controller.send_signal(SIGKILL);
    controller.wait();
    ASSERT_TRUE(wait_until([&] { return set.run_status().late() == "controller"; }));
    step = set.run_status().step();
  }
  Program again({"my-controller", "--domain", domain, "--dds", "fast"});
  EXPECT_TRUE(set.wait_for_step(step + 100)) << again.output();
  EXPECT_EQ(set.run_status().epoch(), 0u) << "resumed, not reset";
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

TEST(Rejoining, ARestartedDynamicsServerBeginsANewEpoch) {
  ScenarioChange change;
  change.steps = kEndless;
  ServerSet set("restarted", {write_scenario("restarted", change), "--keep-going"});
  ASSERT_TRUE(set.wait_for_step(200)) << set.output();
  ASSERT_EQ(kill(set.find_server("hrp-dynamics"), SIGKILL), 0);
  EXPECT_TRUE(wait_until([&] { return set.run_status().epoch() == 1 && set.run_status().step() > 100; }))
      << set.output();
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

}  // namespace
}  // namespace hrp::test
