// SPDX-License-Identifier: BSD-3-Clause
// What every bus promises, asked of each vendor and of each mix of vendors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "common/base/check.h"
#include "common/messages/pubsub.h"
#include "tests/conformance/bus_pair.h"
#include "tests/unit/messages/every_message.h"
#include "tests/unit/messages/random_sample.h"

namespace hrp::conformance {
namespace {

Bytes as_bytes(const std::vector<uint8_t>& bytes) { return {bytes.data(), bytes.size()}; }
std::vector<uint8_t> as_vector(Bytes sample) { return {sample.data, sample.data + sample.size}; }

// Sends samples to the echo, at most `window` ahead of the answers, and checks each answer.
class EchoRun {
 public:
  EchoRun(Bus& bus, uint32_t count, uint32_t window) : writer_(bus.make_writer(kAsk)), count_(count), window_(window) {
    reader_ = bus.make_reader(kAnswer, Delivery::kReliable, [this](Bytes sample) { take(sample); });
  }

  // To be called again and again, under the mutex.
  bool advance() {
    while (sent_ < count_ && sent_ - received_ < window_) {
      const uint32_t number = ++sent_;
      writer_->write(as_bytes(make_sample(number, 1024 + number * 7919 % 3072)));
    }
    return received_ == count_;
  }

  bool has_readers() const { return writer_->has_readers(); }
  uint32_t wrong() const { return wrong_; }

 private:
  void take(Bytes sample) {
    const uint32_t number = find_number_of(sample);
    if (number == 0) return;  // left over from the greeting
    if (number != received_ + 1 || !is_intact(sample)) ++wrong_;
    ++received_;
  }

  std::unique_ptr<Writer> writer_;
  std::unique_ptr<Reader> reader_;
  uint32_t count_;
  uint32_t window_;
  uint32_t sent_ = 0;
  uint32_t received_ = 0;
  uint32_t wrong_ = 0;
};

// Writers and readers find their peers one by one: until the answer comes, ask again.
void wait_for_echo(Bus& bus, const std::function<void(const std::function<bool()>&)>& wait_until) {
  const auto writer = bus.make_writer(kAsk);
  bool answered = false;
  const auto reader = bus.make_reader(kAnswer, Delivery::kReliable, [&](Bytes) { answered = true; });
  const std::vector<uint8_t> greeting = make_sample(0, 64);
  wait_until([&] {
    if (!answered) writer->write(as_bytes(greeting));
    return answered;
  });
}

// Writes until the new ends are known to each other, then lets the run go.
template <typename Wait>
void run_echo(Bus& bus, uint32_t count, uint32_t window, Wait wait_until) {
  EchoRun run(bus, count, window);
  wait_until([&] { return run.has_readers(); });
  // The way back: the echo's writer must know our reader. Greetings are numbered 0 and do not count.
  wait_for_echo(bus, wait_until);
  wait_until([&] { return run.advance(); });
  EXPECT_EQ(run.wrong(), 0u);
}

#define WAIT [this](const std::function<bool()>& done) { wait_until(done); }

TEST_P(BusPair, TenThousandSamplesArriveOnceAndInOrder) {
  start_echo();
  run_echo(*bus_, 10000, 200, WAIT);
}

TEST_P(BusPair, LateJoinersGetTheLastSampleOfALatestTopic) {
  const auto writer = bus_->make_writer(kLatestAsk);
  for (uint32_t number = 1; number <= 3; ++number) writer->write(as_bytes(make_sample(number, 28)));
  start_echo();
  // The peer joined late; its answer is of kind latest too, and so is this reader late.
  std::vector<uint32_t> got;
  const auto reader = bus_->make_reader(kLatestAnswer, Delivery::kReliable,
                                        [&](Bytes sample) { got.push_back(find_number_of(sample)); });
  wait_until([&] { return !got.empty(); });
  EXPECT_THAT(got, ::testing::ElementsAre(3u));
}

TEST_P(BusPair, StreamsDoNotReachBack) {
  const auto writer = bus_->make_writer(kAsk);
  writer->write(as_bytes(make_sample(1, 64)));
  std::vector<uint32_t> got;
  Bus& other = find_other_bus();
  std::atomic<bool> second{false};
  const auto reader = other.make_reader(kAsk, Delivery::kReliable, [&](Bytes sample) {
    got.push_back(find_number_of(sample));
    second = got.back() == 2;
  });
  wait_until([&] { return writer->has_readers(); });
  wait_until([&] {
    if (!second) writer->write(as_bytes(make_sample(2, 64)));
    return second.load();
  });
  std::lock_guard<std::recursive_mutex> lock(other.mutex());
  EXPECT_EQ(got.front(), 2u);
}

// A reader that hangs while all others go on: neither the writer nor the healthy reader may notice.
TEST_P(BusPair, AStalledReliableReaderDoesNotStopTheWriter) {
  if (is_memory()) GTEST_SKIP() << "the memory bus has one thread for all: no reader can be stalled by itself";
  start_echo();
  const auto stalled = start_peer("stall");
  run_echo(*bus_, 4 * kDepth, 100, WAIT);
  stalled->kill_now();
  run_echo(*bus_, 2 * kDepth, 100, WAIT);
}

TEST_P(BusPair, AStalledBestEffortReaderDoesNotStopTheWriter) {
  if (is_memory()) GTEST_SKIP() << "the memory bus has one thread for all: no reader can be stalled by itself";
  start_echo();
  const auto stalled = start_peer("stall-best");
  run_echo(*bus_, 4 * kDepth, 100, WAIT);
}

// Many writers: only some of them close just when they would ask the reader what it has got.
TEST_P(BusPair, WritersCloseWhileSamplesWaitForAStalledReader) {
  if (is_memory()) GTEST_SKIP() << "the memory bus has one thread for all: no reader can be stalled by itself";
  const auto stalled = start_peer("stall");
  const std::vector<uint8_t> sample = make_sample(1, 64);
  std::vector<std::unique_ptr<Writer>> writers;
  // Cyclone DDS gives such a reader a tenth of a second for each.
  const int count = GetParam().mine == "cyclone" ? 5 : 100;
  for (int i = 0; i < count; ++i) writers.push_back(bus_->make_writer(kAsk));
  wait_until([&] {
    return std::all_of(writers.begin(), writers.end(), [](const auto& writer) { return writer->has_readers(); });
  });
  for (const auto& writer : writers) {
    for (int i = 0; i < kDepth; ++i) writer->write(as_bytes(sample));
  }
  writers.clear();
}

TEST_P(BusPair, HalfAMegabyteArrivesWhole) {
  start_echo();
  const auto writer = bus_->make_writer(kAsk);
  const std::vector<uint8_t> sample = make_sample(77, 500 * 1024);
  bool intact = false;
  bool asked = false;
  const auto reader = bus_->make_reader(kAnswer, Delivery::kReliable, [&](Bytes answer) {
    if (find_number_of(answer) == 77) intact = as_vector(answer) == sample;
  });
  wait_for_echo(*bus_, WAIT);
  wait_until([&] {
    if (!asked && writer->has_readers()) {
      writer->write(as_bytes(sample));
      asked = true;
    }
    return intact;
  });
}

TEST_P(BusPair, EveryMessageArrivesByteForByte) {
  std::vector<std::string> types;
  for (const MessageCase& message : find_every_message()) types.push_back(message.type_name);
  start_echo(types);
  for (const MessageCase& message : find_every_message()) {
    SCOPED_TRACE(message.type_name);
    const auto writer = bus_->make_writer(find_typed_ask(message.type_name));
    const std::vector<uint8_t> sample = RandomSample(*get_schema().find_struct(message.type_name), 11).bytes();
    std::vector<uint8_t> answer;
    const auto reader = bus_->make_reader(find_typed_answer(message.type_name), Delivery::kReliable,
                                          [&](Bytes bytes) { answer = as_vector(bytes); });
    wait_until([&] {
      if (answer.empty() && writer->has_readers()) writer->write(as_bytes(sample));
      return !answer.empty();
    });
    std::lock_guard<std::recursive_mutex> lock(bus_->mutex());  // more answers may be on their way
    EXPECT_EQ(answer, sample);
    ASSERT_FALSE(answer.empty());
    EXPECT_EQ(message.encode_again(as_bytes(answer)), sample);
  }
}

TEST_P(BusPair, CallbacksMayWrite) {
  start_echo();
  const auto writer = bus_->make_writer(kAsk);
  uint32_t rounds = 0;
  const auto reader = bus_->make_reader(kAnswer, Delivery::kReliable, [&](Bytes sample) {
    if (find_number_of(sample) != rounds) return;
    if (++rounds < 1000) writer->write(as_bytes(make_sample(rounds, 256)));
  });
  wait_until([&] {
    if (rounds == 0) writer->write(as_bytes(make_sample(0, 256)));
    return rounds >= 1000;
  });
}

TEST_P(BusPair, CallbacksMayWriteToTheirOwnTopic) {
  const auto writer = bus_->make_writer(kAsk);
  uint32_t last = 0;
  int depth = 0;
  const auto reader = bus_->make_reader(kAsk, Delivery::kReliable, [&](Bytes sample) {
    EXPECT_EQ(++depth, 1);  // never nested
    last = find_number_of(sample);
    if (last < 100) writer->write(as_bytes(make_sample(last + 1, 64)));
    --depth;
  });
  wait_until([&] {
    if (last == 0) writer->write(as_bytes(make_sample(1, 64)));
    return last >= 100;
  });
}

TEST_P(BusPair, CallbacksRunOneAtATimeUnderTheMutex) {
  start_echo({"hrp::msg::StepGrant"});
  const TopicSpec second_ask = find_typed_ask("hrp::msg::StepGrant");
  const auto first = bus_->make_writer(kAsk);
  const auto second = bus_->make_writer(second_ask);
  int inside = 0;  // not atomic on purpose: a thread sanitizer sees it, too
  uint32_t count[2] = {0, 0};
  const auto make_callback = [&](int which) {
    return [&, which](Bytes) {
      EXPECT_EQ(++inside, 1);
      std::this_thread::yield();
      ++count[which];
      EXPECT_EQ(--inside, 0);
    };
  };
  const auto reader1 = bus_->make_reader(kAnswer, Delivery::kReliable, make_callback(0));
  const auto reader2 =
      bus_->make_reader(find_typed_answer("hrp::msg::StepGrant"), Delivery::kReliable, make_callback(1));
  wait_until([&] {
    EXPECT_EQ(inside, 0);
    for (int i = 0; i < 5; ++i) {
      first->write(as_bytes(make_sample(1, 64)));
      second->write(as_bytes(make_sample(1, 64)));
    }
    return count[0] > 500 && count[1] > 500;
  });
}

// On the wire a gathered sample waits for the flush; a sample of another topic, written later, overtakes it.
TEST_P(BusPair, GatheredSamplesArriveInOrderWhenFlushed) {
  TopicSpec topic = kAsk;
  topic.gathered = true;
  const TopicSpec prompt_topic = find_typed_ask("hrp::msg::StepGrant");
  const auto writer = bus_->make_writer(topic);
  const auto prompt = bus_->make_writer(prompt_topic);
  Bus& other = find_other_bus();
  std::vector<uint32_t> got;
  std::atomic<bool> greeted{false}, greeted_prompt{false}, prompt_came{false}, all_came{false};
  const auto reader = other.make_reader(kAsk, Delivery::kReliable, [&](Bytes sample) {
    greeted = true;
    if (find_number_of(sample) != 0) got.push_back(find_number_of(sample));
    all_came = got.size() == 3;
  });
  const auto prompt_reader = other.make_reader(prompt_topic, Delivery::kReliable, [&](Bytes sample) {
    greeted_prompt = true;
    if (find_number_of(sample) == 3) got.push_back(3);
    prompt_came = find_number_of(sample) == 3;
    all_came = got.size() == 3;
  });
  wait_until([&] {
    if (!greeted) writer->write(as_bytes(make_sample(0, 64)));
    writer->flush();
    if (!greeted_prompt) prompt->write(as_bytes(make_sample(0, 64)));
    return greeted && greeted_prompt;
  });
  writer->write(as_bytes(make_sample(1, 64)));
  writer->write(as_bytes(make_sample(2, 64)));
  prompt->write(as_bytes(make_sample(3, 64)));
  wait_until([&] { return prompt_came.load(); });
  writer->flush();
  wait_until([&] { return all_came.load(); });
  std::lock_guard<std::recursive_mutex> lock(other.mutex());
  EXPECT_LT(std::find(got.begin(), got.end(), 1u), std::find(got.begin(), got.end(), 2u));
  // Cyclone DDS gathers; within a process it delivers without a packet.
  const bool gathers = GetParam().mine == "cyclone" && GetParam().theirs == "fast";
  EXPECT_TRUE(!gathers || got.front() == 3u) << got.front();
}

TEST_P(BusPair, BytesThatAreNoMessageAreReported) {
  Bus& other = find_other_bus();
  const auto writer = other.make_writer(kAsk);
  int errors = 0;
  std::vector<uint64_t> steps;
  const auto reader = subscribe<msg::RobotState>(
      *bus_, kAsk, Delivery::kReliable, [&](const msg::RobotState& state) { steps.push_back(state.header().step()); },
      [&](const DecodeError&) { ++errors; });
  wait_until([&] { return writer->has_readers(); });
  std::vector<uint8_t> garbage(64, 0xff);
  garbage[0] = garbage[2] = garbage[3] = 0;
  garbage[1] = 1;
  wait_until([&] {
    if (errors == 0) writer->write(as_bytes(garbage));
    return errors > 0;
  });
  msg::RobotState state;
  state.header().step(5);
  std::vector<char> buffer;
  writer->write(encode(state, &buffer));
  wait_until([&] { return !steps.empty(); });
  std::lock_guard<std::recursive_mutex> lock(bus_->mutex());
  EXPECT_EQ(steps.front(), 5u);
}

TEST_P(BusPair, ReadersThatComeAndGoAreNoticed) {
  const auto writer = bus_->make_writer(kAsk);
  EXPECT_FALSE(writer->has_readers());
  {
    const auto reader = find_other_bus().make_reader(kAsk, Delivery::kBestEffort, [](Bytes) {});
    wait_until([&] { return writer->has_readers(); });
  }
  wait_until([&] { return !writer->has_readers(); });
}

TEST_P(BusPair, TopicsAreFoundWithTypeAndEnds) {
  const auto writer = find_other_bus().make_writer(kAsk);
  const auto reader = bus_->make_reader(kAsk, Delivery::kBestEffort, [](Bytes) {});
  wait_until([&] {
    for (const TopicSeen& topic : bus_->find_topics()) {
      if (topic.name == kAsk.name && topic.type_name == kAsk.type_name && topic.writers == 1 && topic.readers == 1) {
        return true;
      }
    }
    return false;
  });
}

TEST_P(BusPair, OneTopicHasOneType) {
  const auto writer = bus_->make_writer(kAsk);
  TopicSpec odd = kAsk;
  odd.type_name = "hrp::msg::StepGrant";
  EXPECT_THROW(bus_->make_reader(odd, Delivery::kReliable, [](Bytes) {}), ContractError);
}

TEST_P(BusPair, DomainsDoNotSeeEachOther) {
  if (is_memory()) GTEST_SKIP() << "a memory bus is a domain of its own";
  const DomainClaim apart = claim_free_domain("conformance test, second domain");
  ASSERT_NE(apart.domain(), claim_.domain());
  BusOptions options;
  options.vendor = GetParam().theirs;
  options.domain = apart.domain();
  const auto other = make_bus(options);
  std::atomic<int> strays{0};
  const auto reader = other->make_reader(kAsk, Delivery::kReliable, [&](Bytes) { ++strays; });
  start_echo();
  run_echo(*bus_, 500, 100, WAIT);
  EXPECT_EQ(strays, 0);
  for (const TopicSeen& topic : other->find_topics()) EXPECT_EQ(topic.writers, 0) << topic.name;
}

INSTANTIATE_TEST_SUITE_P(Buses, BusPair,
                         ::testing::Values(Vendors{"memory", "memory"}, Vendors{"cyclone", "cyclone"},
                                           Vendors{"fast", "fast"}, Vendors{"cyclone", "fast"},
                                           Vendors{"fast", "cyclone"}),
                         [](const auto& info) { return info.param.mine + "_" + info.param.theirs; });

}  // namespace
}  // namespace hrp::conformance
