// SPDX-License-Identifier: BSD-3-Clause
// A node that has ended hears nothing any more: a sample that comes while it is taken apart would find half of it.
#include <gtest/gtest.h>

#include "common/bus/memory/memory_bus.h"
#include "common/node/runner.h"
#include "servers/logger/node.h"
#include "servers/scheduler/node.h"

namespace hrp::test {
namespace {

// Counts the readers that are there.
class CountingBus : public Bus {
 public:
  std::unique_ptr<Writer> make_writer(const TopicSpec& topic) override { return bus_.make_writer(topic); }
  std::unique_ptr<Reader> make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) override {
    return std::make_unique<CountedReader>(bus_.make_reader(topic, delivery, std::move(callback)), &readers);
  }
  std::vector<TopicSeen> find_topics() override { return bus_.find_topics(); }
  std::string vendor() const override { return "memory"; }
  void spin(std::chrono::milliseconds timeout) override { bus_.spin(timeout); }
  int readers = 0;

 private:
  class CountedReader : public Reader {
   public:
    CountedReader(std::unique_ptr<Reader> reader, int* count) : reader_(std::move(reader)), count_(count) { ++*count_; }
    ~CountedReader() override { --*count_; }

   private:
    std::unique_ptr<Reader> reader_;
    int* count_;
  };
  MemoryBus bus_;
};

class EndedNode : public ::testing::Test {
 protected:
  void run(Node& node) {
    for (int i = 0; i < 3; ++i) node.make_endpoints();
    EXPECT_GT(bus_.readers, 0);
    g_stop_signal = true;
    EXPECT_EQ(run_process(node, bus_, "test"), kExitOk) << node.failure();
    g_stop_signal = false;
    EXPECT_EQ(bus_.readers, 0) << "while the node is still whole";
  }
  CountingBus bus_;
};

TEST_F(EndedNode, SchedulerHasNoReaderLeft) {
  SchedulerNode node({&bus_, "scheduler", "test", ""}, {}, -1.0);
  run(node);
}

TEST_F(EndedNode, LoggerHasNoReaderLeft) {
  LoggerOptions options;
  options.path = "/dev/null";
  LoggerNode node({&bus_, "logger", "test", ""}, options);
  run(node);
}

}  // namespace
}  // namespace hrp::test
