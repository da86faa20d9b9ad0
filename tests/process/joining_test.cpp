// SPDX-License-Identifier: BSD-3-Clause
// Programs find the run that they join: one, several, none, and none that fits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "common/bus/domain.h"
#include "tests/process/server_set.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kEndless = "{time_step: 0.001, control_period: 0.005, duration: 0}";

std::string write_endless(const std::string& name) {
  ScenarioChange change;
  change.steps = kEndless;
  return write_scenario(name, change);
}

bool says(const Program& program, const std::string& text) {
  return wait_until([&] { return program.output().find(text) != std::string::npos; });
}

// The line after "To join from another terminal:".
std::string find_join_command(const std::string& output) {
  const std::string mark = "To join from another terminal:\n  ";
  const size_t begin = output.find(mark);
  if (begin == std::string::npos) return "";
  return output.substr(begin + mark.size(), output.find('\n', begin + mark.size()) - begin - mark.size());
}

std::string name_of(const ::testing::TestParamInfo<const char*>& info) { return info.param; }

class Vendor : public ::testing::TestWithParam<const char*> {};

// As the README says it, in two terminals: no domain and no vendor is named.
TEST_P(Vendor, AControllerThatWaitsForARunJoinsTheOneThatStarts) {
  Program controller({"my-controller"});
  ASSERT_TRUE(says(controller, "no run on this machine")) << controller.output();
  EXPECT_THAT(controller.output(), HasSubstr("--without controller"));
  ServerSet set(std::string("joined-") + GetParam(),
                {write_scenario("joined"), "--without", "controller", "--dds", GetParam()});
  EXPECT_EQ(set.wait(), 0) << set.output() << controller.output();
  EXPECT_EQ(controller.wait(), 0) << controller.output();
  EXPECT_THAT(controller.output(), HasSubstr(std::string("(") + GetParam() + ")"));
  EXPECT_EQ(find_last_step(set.log()), 500);
}
INSTANTIATE_TEST_SUITE_P(Both, Vendor, ::testing::Values("cyclone", "fast"), name_of);

class FreePlace : public ::testing::TestWithParam<const char*> {};

TEST_P(FreePlace, TheCommandThatAWaitingRunPrintsFillsIt) {
  const std::string role = GetParam();
  ServerSet other("other-" + role, {write_endless("other"), "--quiet", "--realtime"});  // one that is not meant
  ServerSet set("place-" + role, {write_scenario("place"), "--without", role});
  ASSERT_TRUE(wait_until([&] { return !find_join_command(set.output()).empty() || set.has_ended(); })) << set.output();
  Program server({"/bin/sh", "-c", "exec " + find_join_command(set.output())});
  EXPECT_EQ(set.wait(), 0) << set.output() << server.output();
  EXPECT_EQ(server.wait(), 0) << server.output();
  EXPECT_EQ(find_last_step(set.log()), 500) << set.output();
  other.send_signal(SIGINT);
  EXPECT_EQ(other.wait(), 0) << other.output();
}
INSTANTIATE_TEST_SUITE_P(Each, FreePlace,
                         ::testing::Values("model_parser", "scheduler", "logger", "dynamics", "collision_checker",
                                           "controller"),
                         name_of);

TEST(NoRun, ToolsSayItAndEnd) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"hrp-topic", "list"}, {"hrp-run", "status"}, {"hrp-viewer"}, {"hrp-topic", "--run", "1", "list"}}) {
    Program tool(words);
    EXPECT_NE(tool.wait(), 0) << words[0];
    EXPECT_THAT(tool.output(), HasSubstr(words.size() > 2 ? "--run 1: no run" : "no run on this machine")) << words[0];
  }
}

TEST(SeveralRuns, AreListedAndOneIsChosenByItsProcess) {
  const std::string first = write_endless("first"), second = write_endless("second");
  ServerSet one("several-one", {first, "--without", "controller", "--quiet", "--realtime"});
  ServerSet two("several-two", {second, "--without", "controller", "--quiet", "--realtime", "--dds", "fast"});
  ASSERT_TRUE(wait_until([] {
    const auto runs = find_runs();
    return runs.size() == 2 && runs[0].waits_for == "controller" && runs[1].waits_for == "controller";
  }));
  for (const std::string program : {"my-controller", "hrp-topic list", "hrp-run status", "hrp-viewer"}) {
    Program tool({"/bin/sh", "-c", bin_dir() + "/" + program + " < /dev/null"});
    EXPECT_NE(tool.wait(), 0) << program;
    for (const ServerSet* set : {&one, &two}) {
      EXPECT_THAT(tool.output(), HasSubstr("--run " + std::to_string(set->process_id()))) << program;
      EXPECT_THAT(tool.output(), HasSubstr("log " + set->log()));
    }
    EXPECT_THAT(tool.output(), HasSubstr(first));
    EXPECT_THAT(tool.output(), HasSubstr(second));
    EXPECT_THAT(tool.output(), HasSubstr("waits for controller"));
    EXPECT_THAT(tool.output(), HasSubstr("(fast)"));
  }
  Program controller({"my-controller", "--run", std::to_string(two.process_id())});
  EXPECT_TRUE(two.wait_for_step(100)) << controller.output();
  EXPECT_EQ(one.run_status().step(), 0u);
  Program stop({"hrp-run", "--run", std::to_string(two.process_id()), "stop"});
  EXPECT_EQ(stop.wait(), 0) << stop.output();
  EXPECT_EQ(two.wait(), 0) << two.output();
  one.send_signal(SIGINT);
  EXPECT_EQ(one.wait(), 0) << one.output();
}

// A program on a terminal of its own, with `input` typed once `prompt` is shown. Returns what the terminal showed.
std::string run_on_terminal(const std::string& program, const std::string& prompt, const std::string& input) {
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child == 0) {
    execl("/bin/sh", "sh", "-c", program.c_str(), nullptr);
    _exit(127);
  }
  std::string shown;
  bool typed = false;
  char part[4096];
  for (ssize_t size; (size = read(terminal, part, sizeof part)) > 0;) {
    shown.append(part, static_cast<size_t>(size));
    if (typed || shown.find(prompt) == std::string::npos) continue;
    typed = write(terminal, input.data(), input.size()) == static_cast<ssize_t>(input.size());
  }
  close(terminal);
  waitpid(child, nullptr, 0);
  return shown;
}

TEST(SeveralRuns, AreAskedForOnATerminal) {
  ServerSet one("asked-one", {write_endless("asked_one"), "--quiet", "--realtime"}),
      two("asked-two", {write_endless("asked_two"), "--quiet", "--realtime"});
  ASSERT_TRUE(one.wait_for_step(1) && two.wait_for_step(1)) << one.output() << two.output();
  const std::string shown = run_on_terminal(bin_dir() + "/hrp-run status", "Which one? [1-2]", "2\n");
  EXPECT_THAT(shown, HasSubstr("asked_one"));
  EXPECT_THAT(shown, HasSubstr("running epoch 0"));
  for (ServerSet* set : {&one, &two}) {
    set->send_signal(SIGINT);
    EXPECT_EQ(set->wait(), 0) << set->output();
  }
}

TEST(Waiting, AControllerDoesNotDisturbARunThatHasOne) {
  ServerSet set("taken", {write_endless("taken"), "--quiet", "--realtime"});
  ASSERT_TRUE(set.wait_for_step(1)) << set.output();
  Program controller({"my-controller"});
  EXPECT_TRUE(says(controller, "no run leaves the place of controller free")) << controller.output();
  EXPECT_THAT(controller.output(), HasSubstr("--run " + std::to_string(set.process_id())));
  controller.send_signal(SIGINT);
  EXPECT_EQ(controller.wait(), 130);
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

TEST(Waiting, ASecondControllerStandsByAndTakesOverWhenTheFirstGoes) {
  ServerSet set("standby", {write_endless("standby"), "--without", "controller", "--quiet", "--realtime"});
  Program first({"my-controller"});
  ASSERT_TRUE(set.wait_for_step(50)) << set.output() << first.output();
  Program second({"my-controller", "--run", std::to_string(set.process_id())});
  ASSERT_TRUE(says(second, "the place of controller is taken")) << second.output();
  const uint64_t step = set.run_status().step();
  EXPECT_TRUE(set.wait_for_step(step + 50)) << "the run is not disturbed\n" << set.output();
  first.send_signal(SIGKILL);
  EXPECT_EQ(first.wait(), -SIGKILL);
  ASSERT_TRUE(says(second, "joins domain")) << second.output();
  EXPECT_TRUE(set.wait_for_step(set.run_status().step() + 50)) << set.output() << second.output();
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_EQ(second.wait(), 0) << second.output();
}

TEST(Waiting, IsSaidWithWhatAndWhereAndWhichRunsThereAre) {
  const DomainClaim claim = claim_free_domain("an empty domain");
  const std::string domain = std::to_string(claim.domain());
  struct {
    std::vector<std::string> words;
    const char* what;
  } const waiters[] = {{{"my-controller", "--domain", domain, "--dds", "fast"}, "robot_description from model_parser"},
                       {{"hrp-topic", "--domain", domain, "--dds", "fast", "echo", "contact_forces"}, "contact_forces"},
                       {{"hrp-run", "--domain", domain, "--dds", "fast", "status"}, "the scheduler"}};
  for (const auto& waiter : waiters) {
    std::string command = bin_dir();
    for (const std::string& word : waiter.words) command += (&word == &waiter.words[0] ? "/" : " ") + word;
    Program program(
        {"/bin/sh", "-c", "trap 'kill $child' TERM; " + command + " & child=$!; wait"});  // no child of the holder
    EXPECT_TRUE(says(program, "an empty domain")) << waiter.words[0];
    EXPECT_THAT(program.output(), HasSubstr(std::string("waits for ") + waiter.what));
    EXPECT_THAT(program.output(), HasSubstr("domain " + domain + " (fast)"));
    EXPECT_THAT(program.output(), HasSubstr("--run " + std::to_string(getpid())));
  }
}

TEST(Waiting, EndsWithARunThatWasKilledWithoutAWord) {
  ServerSet set("killed-launcher",
                {write_endless("killed_launcher"), "--without", "controller", "--quiet", "--realtime"});
  Program controller({"my-controller"});
  ASSERT_TRUE(set.wait_for_step(100)) << set.output() << controller.output();
  set.send_signal(SIGSTOP);  // so that it tells nobody
  for (const ProcessSeen& server : find_processes()) {
    if (server.parent_id == set.process_id()) kill(server.process_id, SIGKILL);
  }
  set.send_signal(SIGKILL);
  EXPECT_EQ(set.wait(), -SIGKILL);
  EXPECT_EQ(controller.wait(), 1);
  EXPECT_THAT(controller.output(), HasSubstr("the run has gone"));
  EXPECT_TRUE(find_runs().empty());
}

TEST(ByHand, AnEntireSetOfServersIsARunThatToolsFind) {
  int free_domain = 0;
  {
    const DomainClaim claim = claim_free_domain("found a free one");
    free_domain = claim.domain();
  }
  const std::string domain = std::to_string(free_domain);
  Program scheduler({"hrp-scheduler", "--domain", domain, "--wait-for", "dynamics"});
  ASSERT_TRUE(wait_until([&] { return find_runs().size() == 1 || scheduler.has_ended(); })) << scheduler.output();
  Program dynamics({"hrp-dynamics"}), checker({"hrp-collision-checker"}), controller({"my-controller"});
  Program parser({"hrp-model-parser", write_scenario("by_hand")});
  for (Program* program : {&scheduler, &dynamics, &checker, &controller, &parser})
    EXPECT_EQ(program->wait(), 0) << program->output();
}

}  // namespace
}  // namespace hrp::test
