// SPDX-License-Identifier: BSD-3-Clause
// No log is lost: not to another run, to a full disk or to a kill; and the summary speaks of this run's logs alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "common/mcap/reader.h"
#include "tests/process/server_set.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kEndless[] = "{time_step: 0.001, control_period: 0.005, duration: 0}";
constexpr char kShort[] = "{time_step: 0.001, control_period: 0.005, duration: 0.1}";

std::string write_steps(const std::string& name, const std::string& steps) {
  ScenarioChange change;
  change.steps = steps;
  return write_scenario(name, change);
}

TEST(Logs, OfTwoRunsToOneFileTheSecondIsRefusedAndTheFirstIsKept) {
  ServerSet first("shared", {write_steps("first", kEndless)});
  ASSERT_TRUE(first.wait_for_step(100)) << first.output();
  ServerSet second("shared", {write_steps("second", kShort), "--in-process", "--force"});
  EXPECT_EQ(second.wait(), 2) << second.output();
  EXPECT_THAT(second.output(), HasSubstr("shared.mcap is being written by another program"));
  first.send_signal(SIGINT);
  EXPECT_EQ(first.wait(), 0) << first.output();
  EXPECT_GE(find_last_step(first.log()), 100);
}

TEST(Logs, AreNotOverwrittenUnlessForced) {
  const std::string scenario = write_steps("again", kShort);
  EXPECT_EQ(ServerSet("again", {scenario, "--in-process"}).wait(), 0);
  const auto before = digest_log(get_test_folder() + "/again.mcap");
  ServerSet refused("again", {scenario, "--duration", "0.05"});
  EXPECT_EQ(refused.wait(), 2);
  EXPECT_THAT(refused.output(), HasSubstr("again.mcap is there already"));
  EXPECT_THAT(refused.output(), HasSubstr("--force"));
  EXPECT_EQ(digest_log(refused.log()), before);
  ServerSet forced("again", {scenario, "--in-process", "--force", "--duration", "0.05"});
  EXPECT_EQ(forced.wait(), 0) << forced.output();
  EXPECT_EQ(find_last_step(forced.log()), 50);
  EXPECT_THAT(forced.output(), HasSubstr("play back  hrp-viewer " + forced.log()));
}

TEST(Logs, AForcedRunThatIsRefusedCostsNoLogAndTellsNothingOfIt) {
  EXPECT_EQ(ServerSet("old", {write_steps("old", kShort), "--in-process"}).wait(), 0);
  const auto before = digest_log(get_test_folder() + "/old.mcap");
  const std::string urdf = get_test_folder() + "/no_mass.urdf";
  std::ofstream(urdf)
      << "<robot name=\"bad\"><link name=\"base\"><inertial><mass value=\"-1\"/></inertial></link></robot>\n";
  const std::string scenario = get_test_folder() + "/no_mass.yaml";
  std::ofstream(scenario) << "robot: " << urdf << "\nservo: {default: {kp: 1, kd: 0}}\n";
  ServerSet failed("old", {scenario, "--force"});
  EXPECT_EQ(failed.wait(), 2) << failed.output();
  EXPECT_THAT(failed.output(), Not(HasSubstr("state hash")));
  EXPECT_THAT(failed.output(), Not(HasSubstr("complete up to")));
  EXPECT_EQ(digest_log(failed.log()), before);
}

TEST(Logs, AResetRunNamesBothFilesAndAddsTheirTimes) {
  ServerSet set("parts", {write_steps("parts", kEndless), "--realtime"});
  const std::string domain = std::to_string(set.find_domain());
  ASSERT_TRUE(set.wait_for_step(200)) << set.output();
  EXPECT_EQ(Program({"hrp-run", "--domain", domain, "reset"}).wait(), 0);
  ASSERT_TRUE(wait_until([&] { return set.run_status().epoch() == 1 && set.run_status().step() >= 100; }));
  EXPECT_EQ(Program({"hrp-run", "--domain", domain, "stop"}).wait(), 0);
  EXPECT_EQ(set.wait(), 0) << set.output();
  const std::string second = get_test_folder() + "/parts.1.mcap";
  EXPECT_THAT(set.output(), HasSubstr("in 2 parts"));
  for (const std::string& log : {set.log(), second}) {
    EXPECT_THAT(set.output(), HasSubstr("log        " + log + "\n           complete up to step " +
                                        std::to_string(find_last_step(log)) + ","));
  }
  const double simulated = std::stod(set.output().substr(set.output().find("simulated  ") + 11));
  EXPECT_NEAR(simulated, 0.001 * static_cast<double>(find_last_step(set.log()) + find_last_step(second)), 0.2)
      << "status reports come every 0.1 s, and one belongs to each part";
}

TEST(Logs, AKillBeforeTheFirstChunkLeavesALogThatSaysSo) {
  ServerSet set("killed-early", {write_steps("killed-early", kEndless), "--paused"});
  const pid_t logger = set.find_server("hrp-logger");
  std::error_code ignored;
  ASSERT_TRUE(wait_until([&] { return fs::exists(set.log()) && fs::file_size(set.log(), ignored) > 1000; }));
  kill(logger, SIGKILL);
  EXPECT_EQ(set.wait(), 1) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("holds no step"));
  EXPECT_THAT(set.output(), Not(HasSubstr("play back"))) << "there is nothing to play";
  EXPECT_FALSE(mcap::Reader(set.log()).channels().empty()) << "it can be opened, and tells its topics";
}

// Wherever the kill falls, the file can be opened: it holds the beginning of a log before the servers are there.
TEST(Logs, AKillOfEverybodyAtOnceLeavesNoFileThatCannotBeOpened) {
  for (int delay : {0, 10, 20, 40, 80}) {  // [ms] after the file was seen; the set needs some 100 ms to its first step
    const std::string name = "killed-all-" + std::to_string(delay);
    ServerSet set(name, {write_steps(name, kEndless)});
    ASSERT_TRUE(wait_until([&] { return fs::exists(set.log()) || set.has_ended(); })) << set.output();
    std::this_thread::sleep_for(std::chrono::milliseconds(delay));
    set.send_signal(SIGSTOP);  // starts nobody any more
    for (const ProcessSeen& server : find_processes()) {
      if (server.parent_id == set.process_id()) kill(server.process_id, SIGKILL);
    }
    set.send_signal(SIGKILL);
    EXPECT_EQ(set.wait(), -SIGKILL);
    if (!fs::exists(set.log())) continue;  // the logger had not taken it yet
    EXPECT_GT(fs::file_size(set.log()), 0u) << name;
    EXPECT_NO_THROW(mcap::Reader{set.log()}) << name;
    ServerSet next(name, {write_steps(name, kShort), "--in-process", "--force"});
    EXPECT_EQ(next.wait(), 0) << next.output();
  }
}

TEST(Logs, ATerminalThatIsClosedEndsARunLikeCtrlC) {
  ServerSet set("hung-up", {write_steps("hung-up", kEndless)});
  const int domain = set.find_domain();
  ASSERT_TRUE(set.wait_for_step(100)) << set.output();
  set.send_signal(SIGHUP);
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_TRUE(mcap::Reader(set.log()).indexed()) << "closed";
  EXPECT_GE(find_last_step(set.log()), 100);
  EXPECT_TRUE(wait_until([domain] { return find_servers(domain).empty(); }));
}

TEST(Logs, ARunUnderNohupOutlivesItsTerminal) {
  signal(SIGHUP, SIG_IGN);  // as nohup does; the children inherit it
  ServerSet set("nohup", {write_steps("nohup", kEndless)});
  signal(SIGHUP, SIG_DFL);
  ASSERT_TRUE(set.wait_for_step(100)) << set.output();
  set.send_signal(SIGHUP);
  EXPECT_TRUE(set.wait_for_step(set.run_status().step() + 1000)) << set.output();
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

// The shim notes how much of the log fdatasync() has brought to the disk; a power cut loses what came after.
void cut_power(const std::string& log, const std::string& synced) {
  std::ifstream file(synced);
  uintmax_t size = 0;
  file >> size;
  fs::resize_file(log, std::min(size, fs::file_size(log)));
}

class PowerCut : public ::testing::TestWithParam<const char*> {};

TEST_P(PowerCut, LosesNoStepOfADurableLogThatIsSaidToBeOnDisk) {
  const std::string name = std::string("power-") + GetParam(), synced = get_test_folder() + "/" + name + ".synced";
  setenv("HRP_TEST_SYNCED", synced.c_str(), 1);
  setenv("LD_PRELOAD", (bin_dir() + "/../tests/libpower_cut.so").c_str(), 1);
  ServerSet set(name, {write_steps(name, kEndless), "--durable", "--dds", GetParam()});
  unsetenv("LD_PRELOAD");
  unsetenv("HRP_TEST_SYNCED");
  ASSERT_TRUE(set.wait_for_step(2000)) << set.output();
  kill(set.find_server("hrp-logger"), SIGKILL);
  EXPECT_EQ(set.wait(), 1) << set.output();
  cut_power(set.log(), synced);
  const long said = find_named_step(set.output());
  EXPECT_GE(said, 1000) << "the scheduler lets nobody run more than some windows of 64 steps ahead of the disk\n"
                        << set.output();
  EXPECT_GE(find_last_step(set.log()), said) << set.output();
}
INSTANTIATE_TEST_SUITE_P(Vendors, PowerCut, ::testing::Values("cyclone", "fast"));

// The limit of a file's size stands in for a full disk, as in outsiders_test.
TEST(Logs, ADiskThatIsFullFromTheStartIsSaidAndLeavesNoFile) {
  const std::string scenario = write_steps("full-early", kEndless);
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{4096, old.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  ServerSet set("full-early", {scenario, "--quiet"});
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  EXPECT_EQ(set.wait(), 1) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("File too large"));
  EXPECT_FALSE(fs::exists(set.log()));
}

TEST(Logs, ANameFromTheScenarioIsNumberedWhenItIsTaken) {
  const std::string folder = get_test_folder();
  std::ifstream plain(write_steps("named", kShort));
  const std::string text((std::istreambuf_iterator<char>(plain)), {});
  std::ofstream(folder + "/named.yaml") << text << "\nlogging: {file: " << folder << "/named.mcap}\n";
  for (const char* log : {"/named.mcap", "/named-2.mcap", "/named-3.mcap"}) {
    Program run({"hrp-simulate", folder + "/named.yaml", "--in-process", "--no-plot"});
    EXPECT_EQ(run.wait(), 0) << run.output();
    EXPECT_THAT(run.output(), HasSubstr(folder + log + "\n"));
    EXPECT_EQ(find_last_step(folder + log), 100);
  }
}

}  // namespace
}  // namespace hrp::test
