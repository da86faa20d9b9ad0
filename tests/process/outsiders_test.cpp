// SPDX-License-Identifier: BSD-3-Clause
// Processes that are not ours beside a run, many of them, and a disk that is full.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>

#include "common/messages/topics.h"
#include "tests/process/server_set.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

// "name number" pairs of the line of counts.
std::map<std::string, double> read_counts(const std::string& output) {
  std::istringstream words(output.substr(std::min(output.find("commands "), output.size())));
  std::map<std::string, double> counts;
  std::string name;
  for (double value = 0; words >> name >> value;) counts[name] = value;
  return counts;
}

// How a user of Cyclone DDS meets us on loopback.
const std::string kCycloneConfig = "file://" + source_dir() + "/idl/example_c/cyclone.xml";

class Foreign : public ::testing::TestWithParam<const char*> {};

// The controller of this test knows the IDL files only: the wire is what they say, with nothing of ours beside it.
TEST_P(Foreign, AControllerMadeFromTheIdlAloneRunsTheRobotAndReadsTheRosViews) {
  ScenarioChange change;
  change.steps = "{time_step: 0.001, control_period: 0.005, duration: 1}";
  const std::string scenario = write_scenario("foreign", change);
  ServerSet reference(std::string("foreign-reference-") + GetParam(), {scenario, "--in-process"});
  EXPECT_EQ(reference.wait(), 0) << reference.output();

  ServerSet set(std::string("foreign-") + GetParam(),
                {scenario, "--without", "controller", "--dds", GetParam(), "--realtime"});
  setenv("CYCLONEDDS_URI", kCycloneConfig.c_str(), 1);
  Program controller({bin_dir() + "/../tests/foreign_controller", std::to_string(set.find_domain())});
  unsetenv("CYCLONEDDS_URI");
  EXPECT_EQ(set.wait(), 0) << set.output() << controller.output();
  controller.send_signal(SIGTERM);
  EXPECT_EQ(controller.wait(), 0);

  std::map<std::string, double> counts = read_counts(controller.output());
  EXPECT_GE(counts["commands"], 200) << controller.output();
  EXPECT_GE(counts["forces"], 500) << controller.output();
  EXPECT_NEAR(counts["foot_force"], 58.0 * 9.81, 30.0) << "[N] the weight of the robot";
  // Views are published from when their readers are known on: not all of the 201, but most.
  EXPECT_GE(counts["joint_views"], 100) << controller.output();
  EXPECT_GE(counts["imu_views"], 100) << controller.output();
  EXPECT_GE(counts["wrench_views"], 100) << controller.output();
  EXPECT_EQ(counts["different"], 0) << controller.output();
  EXPECT_EQ(digest_log(set.log())["hrp/robot_state"], digest_log(reference.log())["hrp/robot_state"])
      << "the pose of the first sample is the pose that our own controller holds";
}

int count_readers(ServerSet& set, const char* topic) {
  for (const TopicSeen& seen : set.bus().find_topics()) {
    if (seen.name == topic) return seen.readers;
  }
  return 0;
}

// The shipped examples (docs/client_in_c.md), one as the controller and one that looks on. It is there before the
// controller lets the run begin: half a second is over sooner than a busy machine starts a program.
TEST_P(Foreign, TheExamplesInCHoldThePoseAndShowTheForces) {
  const std::string scenario = write_scenario("example");
  ServerSet reference(std::string("example-reference-") + GetParam(), {scenario, "--in-process"});
  EXPECT_EQ(reference.wait(), 0) << reference.output();
  ServerSet set(std::string("example-") + GetParam(),
                {scenario, "--without", "controller", "--dds", GetParam(), "--realtime"});
  setenv("CYCLONEDDS_URI", kCycloneConfig.c_str(), 1);
  const std::string domain = std::to_string(set.find_domain());
  ASSERT_TRUE(wait_until([&] { return count_readers(set, "hrp/contact_forces") == 1; })) << "the logger";
  Program watcher({bin_dir() + "/../tests/watch_forces", domain});
  ASSERT_TRUE(wait_until([&] { return count_readers(set, "hrp/contact_forces") == 2; }));
  Program controller({bin_dir() + "/../tests/hold_pose", domain});
  unsetenv("CYCLONEDDS_URI");
  EXPECT_EQ(set.wait(), 0) << set.output() << controller.output();
  EXPECT_EQ(controller.wait(), 0) << controller.output();
  EXPECT_EQ(watcher.wait(), 0) << watcher.output();
  EXPECT_THAT(watcher.output(), HasSubstr("t =  0.500 s   ground on L_ANKLE_R_LINK"));
  EXPECT_EQ(digest_log(set.log()), digest_log(reference.log())) << "our own controller holds the same pose";
}

TEST(Crowd, TwentyObserversOfBothVendorsChangeNothing) {
  ScenarioChange change;
  change.steps = "{time_step: 0.001, control_period: 0.005, duration: 2}";
  const std::string scenario = write_scenario("crowd", change);
  ServerSet alone("crowd-alone", {scenario, "--in-process"});
  EXPECT_EQ(alone.wait(), 0) << alone.output();

  ServerSet set("crowd", {scenario, "--paused"});  // six servers and the launcher
  const std::string domain = std::to_string(set.find_domain());
  std::vector<std::unique_ptr<Program>> observers;
  for (int i = 0; i < 20; ++i) {
    observers.push_back(std::make_unique<Program>(std::vector<std::string>{
        "hrp-topic", "--domain", domain, "--dds", i % 2 == 0 ? "cyclone" : "fast", "echo", "hrp/sensor_data"}));
  }
  // All of them are there before the run goes on.
  const auto count = [&set] { return count_readers(set, "hrp/sensor_data"); };
  ASSERT_TRUE(wait_until([&] { return count() >= 22; })) << count() << " readers, with controller and logger";
  ASSERT_TRUE(wait_until([&] { return set.run_status().phase() == msg::RUN_PAUSED; })) << set.output();
  Program go({"hrp-run", "--domain", domain, "run"});
  EXPECT_EQ(go.wait(), 0) << go.output();
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_EQ(digest_log(set.log()), digest_log(alone.log()));
  for (const auto& observer : observers) {
    observer->send_signal(SIGINT);
    (void)observer->wait();
    EXPECT_THAT(observer->output(), HasSubstr("positions"));
  }
}

// ---- somebody who does not know the token of the run --------------------------------------------------------------

template <typename Message>
void shout(Bus& bus, const TopicSpec& topic, const Message& message) {
  Publisher<Message> publisher(bus, topic);
  ASSERT_TRUE(wait_until([&] { return publisher.has_readers(); })) << topic.name;
  for (int i = 0; i < 20; ++i) {
    publisher.publish(message);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

TEST_P(Foreign, WhoeverDoesNotKnowTheTokenNeitherSteersNorEndsARun) {
  const std::string scenario = write_scenario("intruded");
  ServerSet reference(std::string("intruded-reference-") + GetParam(), {scenario, "--in-process"});
  EXPECT_EQ(reference.wait(), 0) << reference.output();
  ServerSet set(std::string("intruded-") + GetParam(), {scenario, "--dds", GetParam(), "--paused"});
  ASSERT_TRUE(wait_until([&] { return set.run_status().phase() == msg::RUN_PAUSED; })) << set.output();
  msg::RunControl stop;
  stop.request(msg::REQUEST_STOP);
  stop.signature(std::string(32, '0'));
  shout(set.bus(), topics::kRunControl, stop);
  msg::StepGrant grant;  // ends the log, runs on for ever, stands still
  grant.last(true);
  grant.epoch(std::numeric_limits<uint64_t>::max());
  grant.through_step(std::numeric_limits<uint64_t>::max());
  grant.for_process(set.find_server("hrp-dynamics"));
  shout(set.bus(), topics::kStepGrant, grant);
  msg::RunStatus over;
  over.phase(msg::RUN_FINISHED);
  shout(set.bus(), topics::kRunStatus, over);
  msg::ServerStatus fault;
  fault.server("dynamics");
  fault.phase(msg::SERVER_FAULT);
  shout(set.bus(), topics::kServerStatus, fault);
  msg::ServerStatus words;  // anybody may say something; nobody steers the terminal by it
  words.server("guest");
  words.phase(msg::SERVER_READY);
  words.message("\x1b[2J\x1b]0;hello\x07");
  shout(set.bus(), topics::kServerStatus, words);
  const std::string domain = std::to_string(set.find_domain());
  // Without the folder of the run's user: as somebody else.
  Program other({"/bin/sh", "-c",
                 "mkdir -m 700 " + get_test_folder() + "/nobody-" + GetParam() +
                     " && XDG_RUNTIME_DIR=" + get_test_folder() + "/nobody-" + GetParam() + " exec " + bin_dir() +
                     "/hrp-run --domain " + domain + " stop"});
  EXPECT_EQ(other.wait(), 2) << other.output();
  EXPECT_THAT(other.output(), HasSubstr("only the user who started this run may steer it"));
  Program go({"hrp-run", "--domain", domain, "run"});
  EXPECT_EQ(go.wait(), 0) << go.output();
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("not signed with the token of this run"));
  EXPECT_THAT(set.output(), HasSubstr("guest: \\x1b[2J\\x1b]0;hello\\x07"));
  EXPECT_EQ(set.output().find('\x1b'), std::string::npos);
  EXPECT_EQ(digest_log(set.log()), digest_log(reference.log())) << "not a bit of the run has changed";
}

INSTANTIATE_TEST_SUITE_P(Vendors, Foreign, ::testing::Values("cyclone", "fast"),
                         [](const auto& info) { return std::string(info.param); });

TEST(Replay, ARequestThatWasRecordedIsNotTakenTwice) {
  ScenarioChange change;
  change.steps = "{time_step: 0.001, control_period: 0.005, duration: 0}";
  ServerSet set("replayed", {write_scenario("replayed", change), "--realtime", "--quiet"});
  std::vector<uint8_t> recorded;
  ASSERT_TRUE(set.wait_for_step(10)) << set.output();
  const auto reader = set.bus().make_reader(topics::kRunControl, Delivery::kReliable, [&](Bytes sample) {
    if (recorded.empty()) recorded.assign(sample.data, sample.data + sample.size);
  });
  const std::string domain = std::to_string(set.find_domain());
  // hrp-run waits for the scheduler, not for this reader: a request may be over before discovery has brought the two
  // together.
  ASSERT_TRUE(wait_until([&] {
    Program pause({"hrp-run", "--domain", domain, "pause"});
    EXPECT_EQ(pause.wait(), 0) << pause.output();
    std::lock_guard<std::recursive_mutex> lock(set.bus().mutex());
    return !recorded.empty();
  }));
  Program go({"hrp-run", "--domain", domain, "run"});
  EXPECT_EQ(go.wait(), 0) << go.output();
  const auto writer = set.bus().make_writer(topics::kRunControl);
  ASSERT_TRUE(wait_until([&] { return writer->has_readers(); }));
  writer->write({recorded.data(), recorded.size()});
  const uint64_t step = set.run_status().step();
  EXPECT_TRUE(set.wait_for_step(step + 500)) << "it is not paused again";
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

// The limit of a file's size stands in for a full disk: the same failure of write(), and no right to mount is needed.
TEST(FullDisk, IsSaidAndTheLogHoldsWhatIsClaimed) {
  ScenarioChange change;
  change.steps = "{time_step: 0.001, control_period: 0.005, duration: 0}";
  const std::string scenario = write_scenario("full", change);
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{1 << 20, old.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);  // the children inherit it
  ServerSet set("full", {scenario, "--quiet"});
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  EXPECT_EQ(set.wait(), 1) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("logger"));
  EXPECT_THAT(set.output(), HasSubstr("File too large"));
  const std::string claim = "ends with step ";
  const size_t place = set.output().find(claim);
  ASSERT_NE(place, std::string::npos) << set.output();
  EXPECT_EQ(find_last_step(set.log()), std::stol(set.output().substr(place + claim.size()))) << set.output();
}

// Options of the network: refused at once, with the file or address, when they cannot be used.
struct BadNetwork {
  const char* name;
  std::vector<std::string> options;
  const char* said;
};
void PrintTo(const BadNetwork& bad, std::ostream* out) { *out << bad.name; }
class Network : public ::testing::TestWithParam<BadNetwork> {};

TEST_P(Network, OptionsThatCannotBeUsedAreRefused) {
  // Above kLastDomain: a run beside this test is never given it, and a claimed domain is refused before the options.
  std::vector<std::string> words{"hrp-scheduler", "--domain", "150"};
  words.insert(words.end(), GetParam().options.begin(), GetParam().options.end());
  Program server(words);
  EXPECT_NE(server.wait(), 0);
  EXPECT_THAT(server.output(), HasSubstr(GetParam().said));
}
INSTANTIATE_TEST_SUITE_P(
    Each, Network,
    ::testing::Values(
        BadNetwork{"cyclone_file", {"--dds", "cyclone", "--dds-config", "/no/such/secure.xml"}, "/no/such/secure.xml"},
        BadNetwork{"fast_file", {"--dds", "fast", "--dds-config", "/no/such/secure.xml"}, "/no/such/secure.xml"},
        BadNetwork{"cyclone_interface", {"--dds", "cyclone", "--network-interface", "203.0.113.7"}, "203.0.113.7"},
        BadNetwork{"fast_interface", {"--dds", "fast", "--network-interface", "203.0.113.7"}, "203.0.113.7"}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace hrp::test
