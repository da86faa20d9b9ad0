// SPDX-License-Identifier: BSD-3-Clause
// docs/step_protocol.md, rule by rule, on a memory bus with stand-ins for physics and collision.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/node/log_samples.h"
#include "tests/unit/node/fake_servers.h"
#include "tests/unit/node/gathering_bus.h"

namespace hrp::test {
namespace {

using Answers = std::vector<msg::JointCommands>;
using ::testing::HasSubstr;

TEST(StepProtocol, RunsEveryStepOnceAndInOrder) {
  const FakeRunResult run = run_fake_set({});
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  ASSERT_EQ(run.states.size(), 301u);
  for (size_t k = 0; k < run.states.size(); ++k) EXPECT_EQ(run.states[k].header().step(), k);
}

TEST(StepProtocol, CommandsOfAStepActFromThatStepOn) {
  const FakeRunResult run = run_fake_set({});
  ASSERT_EQ(run.states.size(), 301u);
  // The engine takes over its reference at once: state k + 1 shows the command of the last control step up to k.
  for (size_t k = 0; k < 300; ++k) EXPECT_EQ(run.states[k + 1].positions()[0], static_cast<double>(k - k % 5) * 0.001);
}

TEST(StepProtocol, RepeatedAnswersDoNoHarm) {
  FakeRunOptions options;
  options.answerer = [](const msg::SensorData& m) { return Answers{make_good_answer(m), make_good_answer(m)}; };
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
}

TEST(StepProtocol, QuestionsAreRepeatedUntilAnswered) {
  FakeRunOptions options;
  int heard = 0;
  options.answerer = [&heard](const msg::SensorData& m) {
    // Deaf to the first question of step 100.
    if (m.header().step() == 100 && ++heard == 1) return Answers{};
    return Answers{make_good_answer(m)};
  };
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  EXPECT_EQ(heard, 2);
}

Answers spoil_at(uint64_t step, const msg::SensorData& sensors, const std::function<void(msg::JointCommands*)>& spoil) {
  msg::JointCommands answer = make_good_answer(sensors);
  if (sensors.header().step() == step) spoil(&answer);
  return {answer};
}

FakeRunResult run_spoiled(const std::string& on_fault, const std::function<void(msg::JointCommands*)>& spoil) {
  FakeRunOptions options;
  options.controller_section = "controller: {type: none, on_fault: " + on_fault + "}\n";
  options.answerer = [spoil](const msg::SensorData& m) { return spoil_at(150, m, spoil); };
  return run_fake_set(options);
}

void expect_stopped(const FakeRunResult& run, const std::string& reason) {
  EXPECT_EQ(run.status.phase(), msg::RUN_FAILED);
  EXPECT_THAT(run.status.message(), HasSubstr("controller"));
  EXPECT_THAT(run.status.message(), HasSubstr(reason));
  EXPECT_THAT(run.status.message(), HasSubstr("150"));
  EXPECT_EQ(run.states.back().header().step(), 150u);
}

const auto kNan = [](msg::JointCommands* m) { m->positions()[1] = std::nan(""); };
const auto kShort = [](msg::JointCommands* m) { m->positions({1.0}); };
const auto kStale = [](msg::JointCommands* m) { m->header().step(140); };
const auto kAhead = [](msg::JointCommands* m) { m->header().step(155); };

TEST(ControllerFault, NanStopsTheRunAndNamesTheJoint) {
  expect_stopped(run_spoiled("stop", kNan), "NaN in positions of joint 'joint1'");
}
TEST(ControllerFault, WrongNumberOfJointsStopsTheRun) {
  expect_stopped(run_spoiled("stop", kShort), "1 positions, the robot has 2");
}
TEST(ControllerFault, StaleStepStopsTheRun) { expect_stopped(run_spoiled("stop", kStale), "answered step 140"); }
TEST(ControllerFault, StepAheadStopsTheRun) { expect_stopped(run_spoiled("stop", kAhead), "answers step 155"); }

void expect_held(const FakeRunResult& run) {
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  EXPECT_THAT(run.status.message(), HasSubstr("held"));
  ASSERT_EQ(run.states.size(), 301u);
  EXPECT_EQ(run.states[155].positions()[0], 0.145) << "the last good command is that of step 145";
  EXPECT_EQ(run.states[160].positions()[0], 0.155) << "the next good command acts";
}

TEST(ControllerFault, NanIsHeldWhenTheScenarioSaysSo) { expect_held(run_spoiled("hold", kNan)); }
TEST(ControllerFault, WrongNumberOfJointsIsHeldWhenTheScenarioSaysSo) { expect_held(run_spoiled("hold", kShort)); }
TEST(ControllerFault, StaleStepIsHeldWhenTheScenarioSaysSo) { expect_held(run_spoiled("hold", kStale)); }

TEST(ControllerFault, SilenceStopsTheRunAfterTheTimeout) {
  FakeRunOptions options;
  options.controller_section = "controller: {type: none, on_fault: stop, timeout: 0.1}\n";
  options.answerer = [](const msg::SensorData& m) {
    return m.header().step() < 150 ? Answers{make_good_answer(m)} : Answers{};
  };
  expect_stopped(run_fake_set(options), "has not answered");
}

TEST(ControllerFault, SilenceIsHeldWhenTheScenarioSaysSo) {
  FakeRunOptions options;
  options.controller_section = "controller: {type: none, on_fault: hold, timeout: 0.1}\n";
  options.answerer = [](const msg::SensorData& m) {
    return m.header().step() < 150 ? Answers{make_good_answer(m)} : Answers{};
  };
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  EXPECT_EQ(run.states.back().positions()[0], 0.145);
}

TEST(EngineFault, StopsTheRunWithStepAndJoint) {
  FakeRunOptions options;
  options.fault_at_q = 0.1;  // reached with the command of step 105
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FAILED);
  EXPECT_THAT(run.status.message(), HasSubstr("step 105"));
  EXPECT_THAT(run.status.message(), HasSubstr("joint0"));
}

TEST(Epochs, AResetBeginsAgainAtStepZeroAndRepeatsTheRun) {
  FakeRunOptions options;
  bool reset = false;
  options.on_state = [&reset](const msg::RobotState& m, Publisher<msg::RunControl>& control) {
    if (reset || m.header().step() != 120) return;
    reset = true;
    msg::RunControl request;
    request.request(msg::REQUEST_RESET);
    control.publish(request);
  };
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  std::vector<msg::RobotState> second;
  for (const auto& state : run.states) {
    if (state.header().epoch() == 1) second.push_back(state);
  }
  ASSERT_EQ(second.size(), 301u);
  for (size_t k = 0; k < 120; ++k) EXPECT_EQ(second[k].hash(), run.states[k].hash());
}

// Nobody watches the scheduler: before, everybody waited for it for ever.
TEST(SchedulerFault, EndsTheRunInWords) {
  RobotDescription robot = make_two_joint_robot("");
  robot.scenario = "robot: [";
  MemoryBus bus;
  SchedulerNode scheduler({&bus, "scheduler", "test", ""}, {}, -1.0);
  scheduler.make_endpoints();
  Publisher<msg::RobotDescription> publisher(bus, topics::kRobotDescription);
  msg::RobotDescription message;
  to_message(robot, &message);
  publisher.publish(message);
  bus.dispatch_all(100);
  // A look after the patience with the goodbyes of others, of whom there are none.
  const auto now = std::chrono::steady_clock::now();
  for (int seconds = 0; seconds < 10; ++seconds) scheduler.on_idle(now + std::chrono::seconds(seconds));
  EXPECT_EQ(scheduler.outcome(), NodeOutcome::kFailed);
  EXPECT_NE(scheduler.failure().find("scheduler: "), std::string::npos) << scheduler.failure();
  EXPECT_NE(scheduler.failure().find("fake.yaml"), std::string::npos) << scheduler.failure();
}

msg::RunControl make_push_request(const std::string& link, double force) {
  msg::RunControl request;
  request.request(msg::REQUEST_PUSH);
  request.push().link(link);
  request.push().force().z(force);
  request.push().steps(20);
  return request;
}

// A run in which somebody pushes at step 50.
FakeRunResult run_pushed(const std::string& link, double force, std::string* refused, FakeRunOptions options = {}) {
  options.on_state = [&](const msg::RobotState& m, Publisher<msg::RunControl>& control) {
    if (m.header().step() == 50) control.publish(make_push_request(link, force));
  };
  options.join = [&](Bus& bus) -> std::shared_ptr<void> {
    return subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable, [refused](const msg::RunStatus& m) {
      if (!m.refused().empty()) *refused = m.refused();
    });
  };
  return run_fake_set(options);
}

TEST(RunControl, APushActsForItsStepsAndTheStatesTellOfIt) {
  std::string refused;
  const FakeRunResult run = run_pushed("link1", 12.0, &refused);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  EXPECT_EQ(refused, "");
  std::vector<uint64_t> steps;
  for (const msg::RobotState& state : run.states) {
    if (state.pushes().empty()) continue;
    steps.push_back(state.header().step());
    EXPECT_EQ(state.pushes()[0].link(), "link1");
    EXPECT_EQ(state.pushes()[0].force().z(), 12.0);
  }
  ASSERT_EQ(steps.size(), 20u);
  EXPECT_EQ(steps.back() - steps.front(), 19u);
  EXPECT_GT(steps.front(), 50u);
}

TEST(RunControl, ADynamicsServerThatTakesNoPushesSaysSo) {
  FakeRunOptions options;
  options.takes_pushes = false;
  std::string refused;
  const FakeRunResult run = run_pushed("link1", 12.0, &refused, options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED);
  EXPECT_THAT(run.status.message(), HasSubstr("takes no pushes"));
}

TEST(RunControl, APushThatCannotBeIsRefusedAndTheRunGoesOn) {
  std::string refused;
  FakeRunResult run = run_pushed("tail", 12.0, &refused);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  EXPECT_THAT(refused, HasSubstr("no link 'tail'"));
  run = run_pushed("link1", std::nan(""), &refused);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED) << run.status.message();
  EXPECT_THAT(refused, HasSubstr("finite"));
}

TEST(RunControl, AStopEndsTheRunCleanly) {
  FakeRunOptions options;
  options.on_state = [](const msg::RobotState& m, Publisher<msg::RunControl>& control) {
    if (m.header().step() != 100) return;
    msg::RunControl request;
    request.request(msg::REQUEST_STOP);
    control.publish(request);
  };
  const FakeRunResult run = run_fake_set(options);
  EXPECT_EQ(run.status.phase(), msg::RUN_FINISHED);
  EXPECT_LT(run.states.back().header().step(), 300u);
}

// Steps whose contact forces arrive, on a network that keeps them until they are flushed.
std::vector<uint64_t> find_steps_with_forces(FakeRunOptions options) {
  std::vector<uint64_t> steps;
  options.network = [](MemoryBus& bus) { return std::make_shared<GatheringBus>(bus); };
  options.join = [&](Bus& bus) -> std::shared_ptr<void> {
    return subscribe<msg::ContactForces>(bus, topics::kContactForces, Delivery::kReliable,
                                         [&](const msg::ContactForces& m) {
                                           if (steps.empty() || steps.back() != m.header().step())
                                             steps.push_back(m.header().step());  // else a repeat
                                         });
  };
  run_fake_set(options);
  return steps;
}

void expect_forces_through(const std::vector<uint64_t>& steps, uint64_t last) {
  ASSERT_EQ(steps.size(), last + 1);
  for (size_t k = 0; k < steps.size(); ++k) EXPECT_EQ(steps[k], k);
}

TEST(GatheredForces, ForcesOfAllStepsArriveAtTheEndOfTheLastGrant) {
  expect_forces_through(find_steps_with_forces({}), 300);
}

// A log that lacked the last steps before a fault would lack the fault.
TEST(GatheredForces, ForcesOfTheStepsBeforeAFaultArrive) {
  FakeRunOptions options;
  options.fault_at_q = 0.1;  // reached with the command of step 105
  expect_forces_through(find_steps_with_forces(options), 105);
}

// What a logger is sent of a run: "topic step" for every sample, in the order of their coming. Repeats are left out.
std::vector<std::string> find_log_samples(FakeRunOptions options, size_t* packets) {
  std::vector<std::string> seen;
  options.join = [&](Bus& bus) -> std::shared_ptr<void> {
    return subscribe<msg::View>(bus, topics::kLogSamples, Delivery::kReliable, [&](const msg::View& batch) {
      ++*packets;
      for (const msg::ViewSample& sample : batch.samples()) {
        uint64_t step = 0;  // encapsulation, epoch, step
        std::memcpy(&step, sample.bytes().data() + 12, sizeof step);
        const std::string name = sample.topic() + " " + std::to_string(step);
        if (std::find(seen.begin(), seen.end(), name) == seen.end()) seen.push_back(name);
      }
    });
  };
  run_fake_set(options);
  return seen;
}

size_t count_topic(const std::vector<std::string>& samples, const TopicSpec& topic) {
  return static_cast<size_t>(std::count_if(samples.begin(), samples.end(), [&](const std::string& sample) {
    return sample.rfind(topic.name + " ", 0) == 0;
  }));
}

// Contacts of the last step are an answer that nobody used: the log does not want them.
TEST(LogSamples, HaveAllThatDynamicsSaysAndHearsOfARunInFewPackets) {
  size_t packets = 0;
  const std::vector<std::string> samples = find_log_samples({}, &packets);
  EXPECT_EQ(count_topic(samples, topics::kRobotState), 301u);
  EXPECT_EQ(count_topic(samples, topics::kContactForces), 301u);
  EXPECT_GE(count_topic(samples, topics::kContactSet), 300u);
  EXPECT_EQ(count_topic(samples, topics::kSensorData), 61u);
  EXPECT_LT(packets, 300u);
}

TEST(LogSamples, OfTheStepsBeforeAFaultArrive) {
  FakeRunOptions options;
  options.fault_at_q = 0.1;  // reached with the command of step 105
  size_t packets = 0;
  const std::vector<std::string> samples = find_log_samples(options, &packets);
  EXPECT_EQ(count_topic(samples, topics::kRobotState), 106u);
  EXPECT_EQ(count_topic(samples, topics::kContactSet), 106u);
}

}  // namespace
}  // namespace hrp::test
