// SPDX-License-Identifier: BSD-3-Clause
// The folder of runs is private, what dead runs left is gone, and the run that is meant is chosen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/bus/bus.h"
#include "common/bus/domain.h"
#include "common/messages/topics.h"
#include "common/node/join.h"
#include "tests/catch_complaint.h"
#include "tests/unit/run_folder.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RunFolder : public test::OwnRunFolder {
 protected:
  std::string find_refusal() {
    return catch_complaint<BusError>([&] { claim_free_domain("test"); });
  }
};

int find_mode(const std::string& path) {
  struct stat info {};
  return lstat(path.c_str(), &info) == 0 ? info.st_mode & 0777 : -1;
}

TEST_F(RunFolder, IsMadeForTheUserAlone) {
  const DomainClaim claim = claim_free_domain("test");
  EXPECT_EQ(find_mode(folder_), 0700);
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_EQ(find_mode(entry.path()), 0600) << entry.path();
}

TEST_F(RunFolder, IsClosedWhenItWasOpenToOthers) {
  ASSERT_EQ(mkdir(folder_.c_str(), 0777), 0);
  ASSERT_EQ(chmod(folder_.c_str(), 0777), 0);
  const DomainClaim claim = claim_free_domain("test");
  EXPECT_EQ(find_mode(folder_), 0700);
}

TEST_F(RunFolder, IsNoSymlink) {
  fs::create_directory(parent_ + "/elsewhere");
  fs::create_directory_symlink(parent_ + "/elsewhere", folder_);
  EXPECT_THAT(find_refusal(), HasSubstr("symlink"));
  EXPECT_TRUE(fs::is_empty(parent_ + "/elsewhere"));
  EXPECT_THAT(find_runs(), IsEmpty());
}

TEST_F(RunFolder, IsNotSomebodyElses) {
  if (geteuid() != 0) GTEST_SKIP() << "NOT TESTED: giving a folder away needs root";
  ASSERT_EQ(mkdir(folder_.c_str(), 0777), 0);
  ASSERT_EQ(chown(folder_.c_str(), 12345, 12345), 0);
  EXPECT_THAT(find_refusal(), HasSubstr("belongs to user 12345"));
}

// In /tmp, where anybody may be first: the next place is taken.
TEST_F(RunFolder, IsElsewhereWhenThePlaceInTmpMayBeTaken) {
  unsetenv("XDG_RUNTIME_DIR");
  const auto folders = find_run_folders();
  if (folders[0].find("/tmp/") != 0) GTEST_SKIP() << "NOT TESTED: this system gives each user a private folder";
  EXPECT_EQ(folders.size(), 2u);
}

TEST_F(RunFolder, IsNotTakenFromAPlaceThatOthersMayWrite) {
  ASSERT_EQ(chmod(parent_.c_str(), 0777), 0);
  EXPECT_NE(find_run_folders()[0], folder_);
}

TEST_F(RunFolder, AFileThatIsASymlinkIsNotFollowed) {
  const int domain = claim_free_domain("test").domain();
  const std::string victim = parent_ + "/victim";
  std::ofstream(victim) << "precious";
  fs::create_symlink(victim, folder_ + "/domain_" + std::to_string(domain));
  EXPECT_THROW(claim_domain(domain, "test"), BusError);
  std::string text;
  std::getline(std::ifstream(victim) >> std::ws, text);
  EXPECT_EQ(text, "precious");
}

TEST_F(RunFolder, ShowsWhatARunSaysOfItself) {
  DomainClaim claim = claim_free_domain("a.yaml");
  RunEntry entry = claim.entry();
  entry.vendor = "fast";
  entry.log = "/tmp/x y.mcap";
  entry.waits_for = "controller";
  entry.free_places = {"controller", "logger"};
  entry.token = "secret";
  claim.describe(entry);
  const auto runs = find_runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].domain, claim.domain());
  EXPECT_EQ(runs[0].process_id, getpid());
  EXPECT_EQ(format_entry(runs[0]), format_entry(claim.entry()));
  EXPECT_THAT(runs[0].free_places, ElementsAre("controller", "logger"));
  EXPECT_THAT(describe_entries(runs), HasSubstr("log /tmp/x y.mcap"));
  EXPECT_EQ(describe_entries(runs).find("secret"), std::string::npos) << "a token is not for the screen";
}

TEST_F(RunFolder, ANameWithControlCharactersStaysOneHarmlessLine) {
  const DomainClaim claim = claim_free_domain("a\nprocess 1\n\033[2J.yaml");
  const auto runs = find_runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].process_id, getpid());
  EXPECT_EQ(runs[0].scenario, "a?process 1??[2J.yaml");
}

TEST_F(RunFolder, KeepsNothingOfARunThatWasKilled) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const DomainClaim claim = claim_free_domain("to be killed");
    (void)!write(ready[1], "x", 1);
    pause();
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  EXPECT_EQ(find_runs().size(), 1u);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_FALSE(fs::is_empty(folder_)) << "what it left behind";
  EXPECT_THAT(find_runs(), IsEmpty());
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RunFolder, APlaceIsTakenOnceAndFreeAgainAfterwards) {
  DomainClaim claim = claim_free_domain("one.yaml");
  RunEntry entry = claim.entry();
  entry.free_places = {"controller", "logger"};
  claim.describe(entry);
  {
    const auto place = claim_place(claim.domain(), "controller");
    ASSERT_TRUE(place);
    EXPECT_FALSE(claim_place(claim.domain(), "controller"));
    EXPECT_THAT(find_runs()[0].free_places, ElementsAre("logger"));
  }
  EXPECT_THAT(find_runs()[0].free_places, ElementsAre("controller", "logger"));
}

TEST_F(RunFolder, TwoUsersOfAMachineNeverGetTheSameDomain) {
  const DomainClaim ours = claim_free_domain("ours");
  const std::string other = parent_ + "/other";
  ASSERT_EQ(mkdir(other.c_str(), 0700), 0);
  setenv("XDG_RUNTIME_DIR", other.c_str(), 1);
  const DomainClaim theirs = claim_free_domain("theirs");
  EXPECT_NE(theirs.domain(), ours.domain()) << "nothing has bound a port yet";
  EXPECT_THROW(claim_domain(ours.domain(), "theirs"), BusError);
  EXPECT_EQ(find_runs().size(), 1u) << "of the refused claim nothing stays";
  setenv("XDG_RUNTIME_DIR", parent_.c_str(), 1);
}

// Another user's run has its folder elsewhere, but the same ports.
TEST_F(RunFolder, ADomainWhosePortsSomebodyUsesIsNotHandedOut) {
  const int count = kLastDomain - kFirstDomain + 1;
  const int first = kFirstDomain + getpid() % count;
  const int file = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(7400 + 250 * first + 10));
  (void)bind(file, reinterpret_cast<sockaddr*>(&address), sizeof address);  // or somebody has it already
  EXPECT_NE(claim_free_domain("test").domain(), first);
  close(file);
}

TEST_F(RunFolder, ADomainIsClaimedOnce) {
  const DomainClaim claim = claim_free_domain("one.yaml");
  try {
    claim_domain(claim.domain(), "two.yaml");
    FAIL() << "claimed twice";
  } catch (const BusError& error) {
    EXPECT_THAT(error.what(), HasSubstr("one.yaml"));
  }
}

RunEntry make_entry(int domain, long process, std::vector<std::string> free_places = {}) {
  RunEntry entry;
  entry.domain = domain;
  entry.process_id = process;
  entry.vendor = "fast";
  entry.free_places = std::move(free_places);
  return entry;
}

TEST(Choice, TheOnlyRunIsJoinedOnItsVendor) {
  const RunChoice choice = choose_run({}, {make_entry(7, 100)});
  ASSERT_TRUE(choice.run);
  EXPECT_EQ(make_join_bus_options(*choice.run, {}).domain, 7);
  EXPECT_EQ(make_join_bus_options(*choice.run, {}).vendor, "fast");
}

TEST(Choice, AServerJoinsTheOnlyRunThatLeavesItsPlaceFree) {
  const std::vector<RunEntry> runs{make_entry(7, 100), make_entry(8, 101, {"controller"})};
  EXPECT_EQ(choose_run({}, runs, "controller").run->entry.domain, 8);
  EXPECT_FALSE(choose_run({}, runs, "logger").run);
  EXPECT_TRUE(choose_run({}, runs, "logger").may_come);
  EXPECT_FALSE(choose_run({}, runs).run) << "who looks has to say which";
  EXPECT_FALSE(choose_run({}, runs).may_come);
}

TEST(Choice, WhatIsNamedCounts) {
  const std::vector<RunEntry> runs{make_entry(7, 100), make_entry(8, 101)};
  JoinOptions by_process;
  by_process.run = 101;
  EXPECT_EQ(choose_run(by_process, runs).run->entry.domain, 8);
  by_process.run = 102;
  EXPECT_THAT(choose_run(by_process, runs).problem, HasSubstr("--run 102: no run"));
  JoinOptions by_domain;
  by_domain.domain = 7;
  by_domain.vendor = "cyclone";
  EXPECT_EQ(choose_run(by_domain, runs, "controller").run->entry.vendor, "cyclone");
  by_domain.domain = 50;
  EXPECT_FALSE(choose_run(by_domain, runs).run->registered);
}

TEST(TopicNames, TheEndOfANameWillDoWhenItIsTheOnlyOne) {
  const std::vector<std::string> names{"hrp/contact_forces",     "rt/imu/chest", "rt/wrench/left_foot",
                                       "rt/imu/left_foot",       "hrp/forces",   "hrp/sensor_data",
                                       "hrp/partner/sensor_data"};
  EXPECT_THAT(topics::find_meant_topics("contact_forces", names), ElementsAre("hrp/contact_forces"));
  EXPECT_THAT(topics::find_meant_topics("/hrp/contact_forces", names), ElementsAre("hrp/contact_forces"));
  EXPECT_THAT(topics::find_meant_topics("imu/chest", names), ElementsAre("rt/imu/chest"));
  EXPECT_THAT(topics::find_meant_topics("left_foot", names), ElementsAre("rt/wrench/left_foot", "rt/imu/left_foot"));
  EXPECT_THAT(topics::find_meant_topics("forces", names), ElementsAre("hrp/forces")) << "whole parts of a name only";
  EXPECT_THAT(topics::find_meant_topics("sensor_data", names), ElementsAre("hrp/sensor_data")) << "the first robot's";
  EXPECT_THAT(topics::find_meant_topics("partner/sensor_data", names), ElementsAre("hrp/partner/sensor_data"));
  EXPECT_THAT(topics::find_meant_topics("odour", names), IsEmpty());
}

}  // namespace
}  // namespace hrp
