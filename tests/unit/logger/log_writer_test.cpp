// SPDX-License-Identifier: BSD-3-Clause
#include "servers/logger/log_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/mcap/small_log.h"

namespace hrp {
namespace {

using mcap::read_file;
using mcap::TemporaryFile;

constexpr int kPeriod = 5;
enum Topic { kDescription, kState, kForces, kSensors, kContacts, kCommands, kTopicCount };

struct Sample {
  size_t topic;
  uint64_t epoch, step;
  std::vector<uint8_t> bytes;
};

// Little-endian CDR of a header, then some bytes that depend on topic and step.
Sample make_sample(size_t topic, uint64_t epoch, uint64_t step) {
  Sample sample{topic, epoch, step, {0, 1, 0, 0}};
  const auto put = [&](auto value) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(&value);
    sample.bytes.insert(sample.bytes.end(), bytes, bytes + sizeof value);
  };
  put(epoch);
  put(step);
  put(static_cast<double>(step) * 0.001);
  for (size_t i = 0; i < 50 + 10 * topic; ++i) put(static_cast<double>(step * topic + i));
  return sample;
}

LogOptions make_options(const std::string& path) {
  using Rate = LogTopic::Rate;
  LogOptions options;
  options.path = path;
  options.existing = mcap::Existing::kReplace;
  options.topics = {{"description", "t::D", "struct D {};", Rate::kOnce, false},
                    {"state", "t::S", "struct S {};", Rate::kEveryStep, false},
                    {"forces", "t::F", "struct F {};", Rate::kEveryStep, false},
                    {"sensors", "t::N", "struct N {};", Rate::kEveryControlStep, false},
                    {"contacts", "t::C", "struct C {};", Rate::kEveryStep, true},
                    {"commands", "t::J", "struct J {};", Rate::kEveryControlStep, true}};
  return options;
}

// What a run of `last + 1` states puts on the bus, in order.
std::vector<Sample> make_run(uint64_t epoch, uint64_t last) {
  std::vector<Sample> samples;
  for (uint64_t step = 0; step <= last; ++step) {
    samples.push_back(make_sample(kState, epoch, step));
    samples.push_back(make_sample(kForces, epoch, step));
    if (step % kPeriod == 0) samples.push_back(make_sample(kSensors, epoch, step));
    samples.push_back(make_sample(kContacts, epoch, step));
    if (step % kPeriod == 0) samples.push_back(make_sample(kCommands, epoch, step));
  }
  return samples;
}

const std::vector<uint8_t> kDescriptionBytes{0, 1, 0, 0, 42};

void describe(LogWriter* log) {
  log->set_description(kDescriptionBytes.data(), kDescriptionBytes.size(), kPeriod, mcap::Compression::kZstd);
}

void take_all(LogWriter* log, const std::vector<Sample>& samples) {
  for (const Sample& sample : samples) log->take(sample.topic, sample.bytes.data(), sample.bytes.size());
}

std::string write_run(const std::string& path, const std::vector<Sample>& samples) {
  LogWriter log(make_options(path));
  describe(&log);
  take_all(&log, samples);
  log.close();
  return read_file(path);
}

// (topic, step) of every message.
std::vector<std::pair<int, uint32_t>> read_steps(const std::string& path) {
  mcap::Reader reader(path);
  std::vector<std::pair<int, uint32_t>> steps;
  reader.read_messages([&](const mcap::Message& message) {
    steps.emplace_back(message.channel_id, message.sequence);
    return true;
  });
  EXPECT_EQ(reader.damage(), "");
  return steps;
}

constexpr size_t kParcels = kTopicCount;
constexpr uint64_t kParcelPeriod = 20;

// The run of make_options() with a topic whose samples come every 20 steps and hold two of others.
std::string write_run_with_parcels(const std::string& path, const std::vector<Sample>& samples, bool wanted) {
  LogOptions options = make_options(path);
  options.topics.push_back({"parcels", "t::P", "struct P {};", LogTopic::Rate::kWhenDue, true});
  LogWriter log(options);
  if (wanted) {
    log.set_parcels(
        [](uint64_t step) { return step % kParcelPeriod == 0; },
        [](const std::vector<uint8_t>& sample) {
          const LogTopic one{"one", "t::A", "struct A {};"}, other{"other", "t::B", "struct B {};"};
          return std::vector<LogWriter::Part>{{one, {sample.begin(), sample.begin() + 20}}, {other, sample}};
        });
  }
  describe(&log);
  take_all(&log, samples);
  log.close();
  return read_file(path);
}

TEST(LogWriter, TakesParcelsApartAndWaitsForThoseThatAreDue) {
  TemporaryFile file("parcels.mcap");
  std::vector<Sample> run = make_run(1, 100), late = run;
  std::vector<Sample> parcels;
  for (uint64_t step = 0; step <= 100; step += kParcelPeriod) parcels.push_back(make_sample(kParcels, 1, step));
  run.insert(run.begin(), parcels.begin(), parcels.end());
  late.insert(late.end(), parcels.begin(), parcels.end());
  const std::string expected = write_run_with_parcels(file.path(), run, true);
  std::map<std::string, int> counts;
  mcap::Reader reader(file.path());
  reader.read_messages(
      [&](const mcap::Message& message) { return ++counts[reader.channels().at(message.channel_id).topic] > 0; });
  EXPECT_EQ(counts["one"], 5) << "none of the last step, whose answers nobody used";
  EXPECT_EQ(counts["other"], 5);
  EXPECT_EQ(counts["parcels"], 0);
  EXPECT_EQ(write_run_with_parcels(file.path(), late, true), expected) << "however late they come";
}

TEST(LogWriter, WithoutParcelsTheFileIsAsIfThereWereNone) {
  TemporaryFile file("no_parcels.mcap");
  const std::vector<Sample> run = make_run(1, 100);
  const std::string expected = write_run(file.path(), run);
  EXPECT_EQ(write_run_with_parcels(file.path(), run, false), expected);
}

TEST(LogWriter, FileDoesNotDependOnTheOrderOfArrival) {
  TemporaryFile file("order.mcap");
  const std::vector<Sample> run = make_run(1, 200);
  const std::string expected = write_run(file.path(), run);
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    // Every topic keeps its own order, as readers of a reliable topic see it; topics overtake each other.
    std::array<std::vector<Sample>, kTopicCount> lanes;
    for (const Sample& sample : run) lanes[sample.topic].push_back(sample);
    std::array<size_t, kTopicCount> taken{};
    std::vector<Sample> shuffled;
    while (shuffled.size() < run.size()) {
      const size_t lane = random() % kTopicCount;
      if (taken[lane] < lanes[lane].size()) shuffled.push_back(lanes[lane][taken[lane]++]);
    }
    ASSERT_EQ(write_run(file.path(), shuffled), expected) << "trial " << trial;
  }
}

TEST(LogWriter, RepeatsAreDropped) {
  TemporaryFile file("repeats.mcap");
  const std::vector<Sample> run = make_run(1, 40);
  const std::string expected = write_run(file.path(), run);
  std::vector<Sample> repeated;
  for (const Sample& sample : run) repeated.insert(repeated.end(), 3, sample);
  repeated.insert(repeated.end(), run.begin(), run.begin() + 20);
  EXPECT_EQ(write_run(file.path(), repeated), expected);
}

TEST(LogWriter, AnswersToTheLastStateDoNotCount) {
  TemporaryFile file("answers.mcap");
  const std::vector<Sample> run = make_run(1, 40);  // ends with state, forces, sensors, contacts, commands of 40
  const std::vector<Sample> without(run.begin(), run.end() - 2);
  EXPECT_EQ(write_run(file.path(), without), write_run(file.path(), run));
  EXPECT_EQ(read_steps(file.path()).back(), (std::pair<int, uint32_t>{kSensors, 40}));
}

TEST(LogWriter, SaysTheLastStepThatIsOnDisk) {
  TemporaryFile file("progress.mcap");
  LogWriter log(make_options(file.path()));
  take_all(&log, make_run(1, 20));
  EXPECT_FALSE(log.has_first_step());
  EXPECT_THAT(log.find_missing(), testing::ElementsAre("description"));
  describe(&log);
  EXPECT_TRUE(log.has_first_step());
  EXPECT_FALSE(log.any_on_disk());
  take_all(&log, make_run(1, 70));
  log.wait_for_disk();
  EXPECT_EQ(log.step_on_disk(), 63u);
  // As after a kill now: the file is not closed, and everything through step 63 is there.
  mcap::Reader reader(file.path());
  uint32_t last = 0;
  reader.read_messages([&](const mcap::Message& message) {
    last = message.sequence;
    return true;
  });
  EXPECT_EQ(last, 63u);
  EXPECT_FALSE(reader.indexed());
}

TEST(LogWriter, EveryEpochHasItsFile) {
  TemporaryFile file("epochs.mcap");
  LogWriter log(make_options(file.path()));
  describe(&log);
  take_all(&log, make_run(1, 50));
  take_all(&log, make_run(2, 10));
  take_all(&log, make_run(1, 60));  // what belongs to an old epoch is dropped
  log.close();
  ASSERT_EQ(log.files().size(), 2u);
  EXPECT_EQ(read_steps(log.files()[0]).back().second, 50u);
  EXPECT_EQ(read_steps(log.files()[1]).back().second, 10u);
  std::filesystem::remove(log.files()[1]);
}

TEST(LogWriter, ALaterEpochTakesTheNextNameThatIsFree) {
  TemporaryFile file("taken.mcap"), taken("taken.1.mcap"), next("taken.2.mcap");
  mcap::write_file(taken.path(), "of another run");
  LogOptions options = make_options(file.path());
  options.existing = mcap::Existing::kRefuse;
  LogWriter log(options);
  describe(&log);
  take_all(&log, make_run(1, 50));
  take_all(&log, make_run(2, 10));
  log.close();
  EXPECT_EQ(log.files(), (std::vector<std::string>{file.path(), next.path()}));
  EXPECT_EQ(mcap::read_file(taken.path()), "of another run");
}

TEST(LogWriter, WaitsForAMissingAnswerUntilToldToGiveUp) {
  TemporaryFile file("silent.mcap");
  std::vector<Sample> run = make_run(1, 60);
  run.erase(std::remove_if(run.begin(), run.end(),
                           [](const Sample& sample) { return sample.topic == kCommands && sample.step >= 10; }),
            run.end());
  LogWriter log(make_options(file.path()));
  describe(&log);
  take_all(&log, run);
  EXPECT_THAT(log.find_missing(), testing::ElementsAre("commands"));
  EXPECT_EQ(log.backlog(), 50u);
  EXPECT_THAT(log.give_up_waiting(), testing::ElementsAre("commands"));
  EXPECT_EQ(log.backlog(), 0u);
  EXPECT_TRUE(log.is_complete_through(60));
}

// Readers of a logger that joins are matched one after another, so parts of the first steps are missing for good.
TEST(LogWriter, OneThatJoinsBeginsWithTheFirstWholeStep) {
  TemporaryFile file("joined.mcap");
  constexpr uint64_t kJoined = 5000, kLast = 8000;
  LogWriter log(make_options(file.path()));
  describe(&log);
  const Sample early = make_sample(kContacts, 1, kJoined - 3);
  log.take(early.topic, early.bytes.data(), early.bytes.size());  // before any state
  for (uint64_t step = kJoined; step <= kLast; ++step) {
    for (size_t topic : {kState, kForces, kSensors, kContacts, kCommands}) {
      const bool due = step % kPeriod == 0 || (topic != kSensors && topic != kCommands);
      const bool matched = topic == kState || step >= kJoined + 2 + topic;
      if (!due || !matched) continue;
      const Sample sample = make_sample(topic, 1, step);
      ASSERT_NO_THROW(log.take(sample.topic, sample.bytes.data(), sample.bytes.size())) << "step " << step;
    }
  }
  log.close();
  const auto steps = read_steps(file.path());
  ASSERT_GT(steps.size(), 2u);
  EXPECT_EQ(steps[1].second, kJoined + 2 + kContacts) << "contacts were the last that came at each step";
  EXPECT_EQ(steps.back().second, kLast);
}

TEST(LogWriter, RefusesBytesWithoutAHeader) {
  TemporaryFile file("bad.mcap");
  LogWriter log(make_options(file.path()));
  describe(&log);
  const std::vector<uint8_t> short_sample{0, 1, 0, 0, 1, 2, 3}, wrong_encoding(100, 9);
  EXPECT_THROW(log.take(kState, short_sample.data(), short_sample.size()), std::invalid_argument);
  EXPECT_THROW(log.take(kState, wrong_encoding.data(), wrong_encoding.size()), std::invalid_argument);
}

}  // namespace
}  // namespace hrp
