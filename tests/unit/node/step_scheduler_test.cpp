// SPDX-License-Identifier: BSD-3-Clause
// Pace and steering of a run, with a clock that the test moves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "servers/scheduler/step_scheduler.h"

namespace hrp::test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

// A run of 1 ms steps whose dynamics is as fast as it is allowed to be.
class PacedRun {
 public:
  explicit PacedRun(double speed) : scheduler_(make_options(speed)) {
    scheduler_.set_run(0.001, 0);
    report(0);
  }
  // Steps that are granted while `time` passes on the wall clock.
  uint64_t let_pass(milliseconds time) {
    const uint64_t before = scheduler_.grant().through_step;
    for (const auto end = now_ + time; now_ < end; now_ += milliseconds(1)) report(scheduler_.grant().through_step);
    return scheduler_.grant().through_step - before;
  }
  StepScheduler& scheduler() { return scheduler_; }
  StepScheduler::Clock::time_point now() const { return now_; }

 private:
  static SchedulerOptions make_options(double speed) {
    SchedulerOptions options;
    options.roles = {"dynamics"};
    options.speed = speed;
    return options;
  }
  void report(uint64_t step) {
    ServerReport report;
    report.role = "dynamics";
    report.process_id = 1;
    report.state = ServerState::kReady;
    report.step = step;
    scheduler_.take_report(report, now_);
    scheduler_.update(now_);
  }
  StepScheduler scheduler_;
  StepScheduler::Clock::time_point now_{std::chrono::seconds(1000)};
};

// 1 ms steps: at real time a second grants 1000 of them, and at most one window (64) more or less at its ends.
TEST(Pace, APauseDoesNotChangeIt) {
  PacedRun run(1.0);
  EXPECT_NEAR(static_cast<double>(run.let_pass(milliseconds(1000))), 1000, 64);
  run.scheduler().request_pause();
  (void)run.let_pass(milliseconds(1));
  EXPECT_EQ(run.let_pass(milliseconds(500)), 0u);
  EXPECT_EQ(run.scheduler().request_run(std::nullopt, run.now()), "");
  EXPECT_NEAR(static_cast<double>(run.let_pass(milliseconds(1000))), 1000, 64) << "as before the pause";
}

TEST(Pace, IsChangedByANewSpeedAlone) {
  PacedRun run(1.0);
  (void)run.let_pass(milliseconds(100));
  EXPECT_EQ(run.scheduler().request_run(4.0, run.now()), "");
  EXPECT_NEAR(static_cast<double>(run.let_pass(milliseconds(1000))), 4000, 128);
  EXPECT_EQ(run.scheduler().request_run(0.0, run.now()), "");
  EXPECT_GT(run.let_pass(milliseconds(1000)), 50000u) << "without a limit";
}

TEST(Pace, SpeedsThatNobodyCanMeanAreRefusedAndChangeNothing) {
  PacedRun run(1.0);
  run.scheduler().request_pause();
  (void)run.let_pass(milliseconds(100));
  for (double speed : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0, -1e-300, 1e-300, 1e-9, 9e-4, 1e7}) {
    EXPECT_THAT(run.scheduler().request_run(speed, run.now()), HasSubstr("expected 0.001 to 1e6")) << speed;
    EXPECT_EQ(run.let_pass(milliseconds(10)), 0u) << "still paused";
  }
  EXPECT_EQ(run.scheduler().speed(), 1.0);
}

TEST(Fault, WithoutARoleOrAReasonStillEndsTheRunInWords) {
  PacedRun run(0.0);
  ServerReport report;
  report.state = ServerState::kFault;
  run.scheduler().take_report(report, run.now());
  EXPECT_EQ(run.scheduler().state(), RunState::kFailed);
  EXPECT_EQ(run.scheduler().failure(), "a server without a name: failed without a reason");
}

TEST(Steps, NoneOrBillionsAreRefused) {
  PacedRun run(0.0);
  run.scheduler().request_pause();
  (void)run.let_pass(milliseconds(10));
  for (uint64_t steps : {uint64_t{0}, uint64_t{1000001}, uint64_t(-5)}) {
    EXPECT_THAT(run.scheduler().request_steps(steps), HasSubstr("expected 1 to 1000000"));
    EXPECT_EQ(run.let_pass(milliseconds(10)), 0u);
  }
  EXPECT_EQ(run.scheduler().request_steps(7), "");
  EXPECT_EQ(run.let_pass(milliseconds(10)), 7u);
}

// A run with a logger, whose reports the test gives.
struct LoggedRun {
  StepScheduler scheduler;
  StepScheduler::Clock::time_point now{std::chrono::seconds(1000)};
  explicit LoggedRun(const std::string& follower = "logger", uint64_t end = 0) : scheduler(make_options(follower)) {
    scheduler.set_run(0.001, end);
    report("dynamics", 0);
    report(follower, 0);
  }
  static SchedulerOptions make_options(const std::string& follower) {
    SchedulerOptions options;
    options.roles = {"dynamics", follower};
    return options;
  }
  void report(const std::string& role, uint64_t step) {
    ServerReport report;
    report.role = role;
    report.process_id = 1;
    report.state = ServerState::kReady;
    report.step = step;
    scheduler.take_report(report, now);
    scheduler.update(now);
  }
};

TEST(Stop, TheStepsThatWereGrantedAreDoneAndLoggedBeforeTheRunEnds) {
  LoggedRun run;
  const uint64_t granted = run.scheduler.grant().through_step;
  run.scheduler.request_end(run.now);
  run.report("dynamics", granted / 2);
  EXPECT_EQ(run.scheduler.grant().through_step, granted);
  EXPECT_TRUE(run.scheduler.grant().last);
  run.report("dynamics", granted);
  run.report("logger", granted - 1);
  EXPECT_EQ(run.scheduler.state(), RunState::kRunning) << "a step is not in the log yet";
  run.report("logger", granted);
  EXPECT_EQ(run.scheduler.state(), RunState::kFinished);
  EXPECT_EQ(run.scheduler.step(), granted);
}

TEST(Vision, ThatARunWaitsForIsNeverFarBehindIt) {
  LoggedRun run("vision", 1000);
  for (uint64_t step = 0; step < 1000; step = std::min<uint64_t>(1000, run.scheduler.grant().through_step)) {
    if (step == run.scheduler.step() && step > 0) break;
    run.report("dynamics", step);
  }
  EXPECT_EQ(run.scheduler.grant().through_step, 512u) << "eight windows beyond what was seen";
  EXPECT_EQ(run.scheduler.late(), "vision");
  run.report("vision", 500);
  run.report("dynamics", 640);
  run.report("dynamics", 768);
  run.report("dynamics", 896);
  run.report("vision", 700);
  run.report("dynamics", 1000);
  EXPECT_EQ(run.scheduler.state(), RunState::kRunning) << "the last pictures are not there";
  run.report("vision", 1000);
  EXPECT_EQ(run.scheduler.state(), RunState::kFinished);
}

TEST(Stop, ALoggerThatSaysNothingDoesNotKeepTheRun) {
  LoggedRun run;
  run.scheduler.request_end(run.now);
  run.report("dynamics", run.scheduler.grant().through_step);
  EXPECT_EQ(run.scheduler.state(), RunState::kRunning);
  run.now += milliseconds(2001);
  run.scheduler.update(run.now);
  EXPECT_EQ(run.scheduler.state(), RunState::kFinished);
}

TEST(Stop, AskedTwiceItComesAtOnce) {
  LoggedRun run;
  run.scheduler.request_end(run.now);
  EXPECT_NE(run.scheduler.state(), RunState::kFinished);
  run.scheduler.request_end(run.now);
  EXPECT_EQ(run.scheduler.state(), RunState::kFinished);
}

TEST(Stop, ARunThatWaitsForSomebodyEndsAtOnce) {
  LoggedRun run;
  run.now += milliseconds(700);
  run.scheduler.update(run.now);
  ASSERT_EQ(run.scheduler.late(), "dynamics");
  run.scheduler.request_end(run.now);
  EXPECT_EQ(run.scheduler.state(), RunState::kFinished);
}

}  // namespace
}  // namespace hrp::test
