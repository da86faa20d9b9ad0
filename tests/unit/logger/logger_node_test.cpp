// SPDX-License-Identifier: BSD-3-Clause
// The logger on a bus: readiness, the last step, a full disk.
#include "servers/logger/node.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <random>
#include <thread>

#include "common/base/diagnostics.h"
#include "common/bus/memory/memory_bus.h"
#include "common/messages/topics.h"
#include "common/node/log_samples.h"
#include "hrp_idl/collision.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"
#include "tests/unit/mcap/small_log.h"

namespace hrp {
namespace {

using mcap::TemporaryFile;

class LoggerNodeTest : public testing::Test {
 protected:
  explicit LoggerNodeTest(bool gathered = false) : file_("node.mcap") {
    status_reader_ = subscribe<msg::ServerStatus>(bus_, topics::kServerStatus, Delivery::kReliable,
                                                  [this](const msg::ServerStatus& status) { status_ = status; });
    LoggerOptions options;
    options.path = file_.path();
    options.gathered = gathered;
    logger_ = std::make_unique<LoggerNode>(NodeContext{&bus_, "logger", "hrp-logger", ""}, options);
    logger_->make_endpoints();
  }

  template <typename Message>
  void send(const TopicSpec& topic, const Message& message) {
    Publisher<Message>(bus_, topic).publish(message);
    bus_.dispatch_all();
  }

  template <typename Message>
  void send_step(const TopicSpec& topic, uint64_t step, Message message = Message()) {
    message.header().epoch(1);
    message.header().step(step);
    message.header().time(static_cast<double>(step) * 0.001);
    send(topic, message);
  }

  void send_description() {
    msg::RobotDescription robot;
    robot.scenario_path("test.yaml");
    robot.scenario("robot: none.urdf\nsteps: {time_step: 0.001, control_period: 0.002}\n");
    send(topics::kRobotDescription, robot);
  }

  // Random numbers do not compress: the file grows by what is sent.
  void send_all(uint64_t step) {
    msg::RobotState state;
    for (int i = 0; i < 50; ++i) state.positions().push_back(std::generate_canonical<double, 53>(random_));
    send_step(topics::kRobotState, step, state);
    send_step<msg::ContactForces>(topics::kContactForces, step);
    send_step<msg::ContactSet>(topics::kContactSet, step);
    if (step % 2 != 0) return;
    send_step<msg::SensorData>(topics::kSensorData, step);
    send_step<msg::JointCommands>(topics::kJointCommands, step);
  }

  // The disk has a thread of its own, and is looked at when there is nothing else to do.
  void wait_for_step(uint64_t step) {
    while (status_.step() < step && status_.phase() != msg::SERVER_FAULT) {
      logger_->on_idle(std::chrono::steady_clock::now());
      bus_.dispatch_all();
      std::this_thread::yield();
    }
  }

  uint64_t find_last_step() {
    mcap::Reader reader(file_.path());
    uint64_t last = 0;
    reader.read_messages([&](const mcap::Message& message) {
      last = message.sequence;
      return true;
    });
    return last;
  }

  TemporaryFile file_;
  MemoryBus bus_;
  std::mt19937 random_{5};
  msg::ServerStatus status_;
  std::unique_ptr<Reader> status_reader_;
  std::unique_ptr<LoggerNode> logger_;
};

TEST_F(LoggerNodeTest, IsReadyWhenEveryTopicHasSpoken) {
  send_description();
  send_step<msg::RobotState>(topics::kRobotState, 0);
  EXPECT_EQ(status_.phase(), msg::SERVER_STARTING);
  send_all(0);
  EXPECT_EQ(status_.phase(), msg::SERVER_READY);
}

TEST_F(LoggerNodeTest, TheLastGrantedStepReachesTheDiskByItself) {
  send_description();
  for (uint64_t step = 0; step <= 40; ++step) send_all(step);
  wait_for_step(31);
  EXPECT_EQ(status_.step(), 31u);
  msg::StepGrant grant;
  grant.epoch(1);
  grant.through_step(40);
  grant.last(true);
  send(topics::kStepGrant, grant);
  EXPECT_EQ(status_.step(), 40u) << status_.message();
  EXPECT_EQ(find_last_step(), 40u);
}

// A last step that cannot be would close the file too early.
TEST_F(LoggerNodeTest, ALastStepThatWasPassedOrTakenBackIsAFault) {
  send_description();
  for (uint64_t step = 0; step <= 40; ++step) send_all(step);
  msg::StepGrant grant;
  grant.epoch(1);
  grant.last(true);
  grant.through_step(20);
  send(topics::kStepGrant, grant);
  EXPECT_EQ(status_.phase(), msg::SERVER_FAULT);
  EXPECT_THAT(status_.message(),
              ::testing::HasSubstr("step_grant names step 20 as the last of epoch 1, but step 40 is there"));
}

TEST_F(LoggerNodeTest, TwoLastStepsOfOneEpochAreAFault) {
  send_description();
  send_all(0);
  msg::StepGrant grant;
  grant.epoch(1);
  grant.last(true);
  for (const uint64_t last : {100, 90}) {
    grant.through_step(last);
    send(topics::kStepGrant, grant);
  }
  EXPECT_EQ(status_.phase(), msg::SERVER_FAULT);
  EXPECT_THAT(status_.message(), ::testing::HasSubstr("names step 90 as the last of epoch 1, after step 100"));
}

TEST_F(LoggerNodeTest, ALogThatEndsBeforeTheRunIsAFault) {
  send_description();
  for (uint64_t step = 0; step <= 40; ++step) send_all(step);
  msg::RunStatus run;
  run.phase(msg::RUN_FINISHED);
  run.epoch(1);
  run.step(50);
  send(topics::kRunStatus, run);
  for (int look = 0; look < 100 && status_.phase() != msg::SERVER_FAULT; ++look) {
    logger_->on_idle(std::chrono::steady_clock::now());
    bus_.dispatch_all();
  }
  EXPECT_EQ(status_.phase(), msg::SERVER_FAULT);
  EXPECT_EQ(status_.message(), "the run ended with step 50, but nothing after step 40 reached the log");
  EXPECT_EQ(find_last_step(), 40u);
}

TEST_F(LoggerNodeTest, AnAnswerThatNeverCameIsNamedAtTheEnd) {
  send_description();
  for (uint64_t step = 0; step <= 40; ++step) {
    send_step<msg::RobotState>(topics::kRobotState, step);
    send_step<msg::ContactForces>(topics::kContactForces, step);
    send_step<msg::ContactSet>(topics::kContactSet, step);
    if (step % 2 == 0) send_step<msg::SensorData>(topics::kSensorData, step);
    if (step % 2 == 0 && step < 30) send_step<msg::JointCommands>(topics::kJointCommands, step);
  }
  msg::StepGrant grant;
  grant.epoch(1);
  grant.through_step(40);
  grant.last(true);
  send(topics::kStepGrant, grant);
  wait_for_step(40);
  EXPECT_EQ(status_.message(), "no hrp/joint_commands from controller since step 30; the log goes on without it");
  EXPECT_EQ(find_last_step(), 40u);
}

// Seen in a run of ten million steps whose processes got no time for seconds: the log had gone on without what came
// then.
TEST_F(LoggerNodeTest, WhatDynamicsHadAndTheLoggerHasNotIsWaitedForThoughItComesSecondsLate) {
  send_description();
  for (uint64_t step = 0; step <= 300; ++step) {
    send_step<msg::RobotState>(topics::kRobotState, step);
    send_step<msg::ContactForces>(topics::kContactForces, step);
    if (step != 100) send_step<msg::ContactSet>(topics::kContactSet, step);
    if (step % 2 == 0) send_step<msg::SensorData>(topics::kSensorData, step);
    if (step % 2 == 0) send_step<msg::JointCommands>(topics::kJointCommands, step);
  }
  const auto start = std::chrono::steady_clock::now();
  for (int look = 0; look < 900; ++look) logger_->on_idle(start + look * std::chrono::milliseconds(10));
  bus_.dispatch_all();
  EXPECT_EQ(status_.message(), "");
  send_step<msg::ContactSet>(topics::kContactSet, 100);
  wait_for_step(287);
  EXPECT_EQ(status_.step(), 287u);
  logger_.reset();
  uint64_t contact_sets = 0;
  mcap::Reader reader(file_.path());
  reader.read_messages([&](const mcap::Message&) { return ++contact_sets > 0; }, {topics::kContactSet.name});
  EXPECT_GE(contact_sets, 288u);
}

TEST_F(LoggerNodeTest, AFullDiskIsAFaultAndTheLogStaysReadable) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{100000, old.rlim_max};  // stands in for a full disk
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  send_description();
  for (uint64_t step = 0; step < 2000; ++step) send_all(step);
  wait_for_step(2000);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  EXPECT_EQ(status_.phase(), msg::SERVER_FAULT);
  EXPECT_NE(status_.message().find("File too large"), std::string::npos) << status_.message();
  // What it said is on disk is there.
  EXPECT_GT(status_.step(), 31u);
  EXPECT_EQ(find_last_step(), status_.step());
}

// A logger of a process of its own, and what dynamics gathers for it.
class GatheredLogTest : public LoggerNodeTest {
 protected:
  GatheredLogTest() : LoggerNodeTest(true) {}

  template <typename Message>
  void add(const TopicSpec& topic, uint64_t step) {
    Message message;
    message.header().epoch(1);
    message.header().step(step);
    message.header().time(static_cast<double>(step) * 0.001);
    std::vector<char> buffer;
    const Bytes bytes = encode(message, &buffer);
    samples_.look_for_reader();
    samples_.add(topic.name, bytes);
  }

  // All that dynamics says and hears of a step; the commands come from the controller.
  void add_step(uint64_t step) {
    add<msg::RobotState>(topics::kRobotState, step);
    add<msg::ContactForces>(topics::kContactForces, step);
    if (step % 2 == 0) add<msg::SensorData>(topics::kSensorData, step);
    add<msg::ContactSet>(topics::kContactSet, step);
    if (step % 2 == 0) send_step<msg::JointCommands>(topics::kJointCommands, step);
  }

  void flush() {
    samples_.flush();
    bus_.dispatch_all();
    logger_->make_endpoints();
  }

  int count_readers(const TopicSpec& topic) {
    for (const TopicSeen& seen : bus_.find_topics()) {
      if (seen.name == topic.name) return seen.readers;
    }
    return 0;
  }

  LogSamples samples_{bus_};
};

TEST_F(GatheredLogTest, HoldsTheSameStepsAndReadsTheirTopicsNoMore) {
  send_description();
  for (uint64_t step = 0; step <= 40; ++step) {
    add_step(step);
    if (step % 8 == 0) flush();
  }
  flush();
  EXPECT_EQ(count_readers(topics::kRobotState), 0);
  EXPECT_EQ(count_readers(topics::kContactSet), 0);
  EXPECT_EQ(count_readers(topics::kJointCommands), 1);
  wait_for_step(31);
  EXPECT_EQ(status_.step(), 31u) << status_.message();
}

// Else a sample that was lost on its way would be missing in the log.
TEST_F(GatheredLogTest, ReadsTopicsUntilTheStepsBeforeAreWritten) {
  send_description();
  for (uint64_t step = 0; step < 8; ++step) {
    if (step != 5) send_all(step);
  }
  for (uint64_t step = 8; step < 20; ++step) add_step(step);
  flush();
  EXPECT_EQ(count_readers(topics::kRobotState), 1);
  send_all(5);
  for (uint64_t step = 20; step < 40; ++step) add_step(step);
  flush();
  EXPECT_EQ(count_readers(topics::kRobotState), 0);
  wait_for_step(31);
  EXPECT_EQ(status_.step(), 31u) << status_.message();
}

TEST_F(GatheredLogTest, ReadsTopicsAgainWhenNothingIsGatheredAnyMore) {
  send_description();
  for (uint64_t step = 0; step < 8; ++step) add_step(step);
  flush();
  for (uint64_t step = 8; step < 16; ++step) add_step(step);
  flush();
  EXPECT_EQ(count_readers(topics::kRobotState), 0);
  const auto start = std::chrono::steady_clock::now();
  for (int look = 0; look < 110; ++look) logger_->on_idle(start + look * std::chrono::milliseconds(10));
  logger_->make_endpoints();
  EXPECT_EQ(count_readers(topics::kRobotState), 1);
  for (uint64_t step = 16; step < 40; ++step) send_all(step);
  wait_for_step(31);
  EXPECT_EQ(status_.step(), 31u) << status_.message();
}

TEST(LoggerNode, AnUnwritableFileIsSaidAtTheStart) {
  MemoryBus bus;
  EXPECT_THROW(LoggerNode({&bus, "logger", "hrp-logger", ""}, {"no/such/folder/run.mcap", ""}), InputError);
}

}  // namespace
}  // namespace hrp
