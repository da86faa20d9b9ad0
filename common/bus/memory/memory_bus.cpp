// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/memory/memory_bus.h"

#include <algorithm>

#include "common/base/check.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;

struct MemoryTopic;

struct ReaderEntry {
  MemoryTopic* topic = nullptr;
  SampleCallback callback;
  uint64_t since = 0;  // sees samples with this number and later ones
};

struct WriterEntry {
  MemoryTopic* topic = nullptr;
  Retention retention = Retention::kStream;
  std::vector<uint8_t> last;  // kept for late readers
  bool has_last = false;
};

struct MemoryTopic {
  std::string name;
  std::string type_name;
  std::vector<ReaderEntry*> readers;  // in the order they came
  std::vector<WriterEntry*> writers;
};

struct Pending {
  MemoryTopic* topic = nullptr;
  const ReaderEntry* only = nullptr;  // a retained sample for one late reader; nullptr: for all
  uint64_t number = 0;
  std::vector<uint8_t> bytes;
};

}  // namespace

struct MemoryBus::State {
  std::recursive_mutex* mutex = nullptr;  // of the bus; nullptr after its end
  std::condition_variable_any written;
  std::map<std::string, MemoryTopic> topics;
  // Ring of waiting samples; slots keep their memory.
  std::vector<Pending> ring;
  size_t head = 0;
  size_t count = 0;
  uint64_t next_number = 0;
  std::vector<uint8_t> delivering;  // the sample that callbacks look at
  bool in_callback = false;
  bool waiting = false;

  Pending& push(MemoryTopic* topic, Bytes sample) {
    if (count == ring.size()) grow();
    Pending& slot = ring[(head + count) & (ring.size() - 1)];
    slot.bytes.assign(sample.data, sample.data + sample.size);  // first: without memory for it nothing waits
    slot.topic = topic;
    slot.only = nullptr;
    slot.number = next_number++;
    ++count;
    return slot;
  }

  void grow() {
    std::vector<Pending> larger(std::max<size_t>(16, 2 * ring.size()));
    for (size_t i = 0; i < count; ++i) larger[i] = std::move(ring[(head + i) & (ring.size() - 1)]);
    ring = std::move(larger);
    head = 0;
  }

  MemoryTopic& find_or_make_topic(const TopicSpec& spec) {
    MemoryTopic& topic = topics[spec.name];
    if (topic.name.empty()) {
      topic.name = spec.name;
      topic.type_name = spec.type_name;
    }
    HRP_CHECK(topic.type_name == spec.type_name,
              "topic " << spec.name << " carries " << topic.type_name << ", not " << spec.type_name);
    return topic;
  }

  void deliver(const Pending& slot, Bytes sample) {
    if (slot.only) {
      slot.only->callback(sample);
      return;
    }
    for (const ReaderEntry* reader : slot.topic->readers) {
      if (slot.number >= reader->since) reader->callback(sample);
    }
  }
};

namespace {

using StatePointer = std::shared_ptr<MemoryBus::State>;

class MemoryWriter : public Writer {
 public:
  MemoryWriter(StatePointer state, const TopicSpec& spec) : state_(std::move(state)) {
    entry_.topic = &state_->find_or_make_topic(spec);
    entry_.retention = spec.retention;
    entry_.topic->writers.push_back(&entry_);
  }

  ~MemoryWriter() override {
    if (!state_->mutex) return;
    std::lock_guard<std::recursive_mutex> lock(*state_->mutex);
    auto& writers = entry_.topic->writers;
    writers.erase(std::find(writers.begin(), writers.end(), &entry_));
  }

  void write(Bytes sample) override {
    HRP_CHECK(state_->mutex, "the bus of topic " << entry_.topic->name << " has ended");
    std::lock_guard<std::recursive_mutex> lock(*state_->mutex);
    if (entry_.retention == Retention::kLatest) {
      entry_.last.assign(sample.data, sample.data + sample.size);
      entry_.has_last = true;
    }
    if (entry_.topic->readers.empty()) return;
    state_->push(entry_.topic, sample);
    if (state_->waiting) state_->written.notify_one();
  }

  bool has_readers() const override {
    if (!state_->mutex) return false;
    std::lock_guard<std::recursive_mutex> lock(*state_->mutex);
    return !entry_.topic->readers.empty();
  }

 private:
  StatePointer state_;
  WriterEntry entry_;
};

class MemoryReader : public Reader {
 public:
  MemoryReader(StatePointer state, const TopicSpec& spec, SampleCallback callback) : state_(std::move(state)) {
    entry_.topic = &state_->find_or_make_topic(spec);
    entry_.callback = std::move(callback);
    entry_.since = state_->next_number;
    entry_.topic->readers.push_back(&entry_);
    if (spec.retention == Retention::kLatest) queue_retained();
  }

  ~MemoryReader() override {
    if (!state_->mutex) return;
    std::lock_guard<std::recursive_mutex> lock(*state_->mutex);
    auto& readers = entry_.topic->readers;
    readers.erase(std::find(readers.begin(), readers.end(), &entry_));
    // Samples meant for this reader alone are now for nobody.
    for (size_t i = 0; i < state_->count; ++i) {
      Pending& slot = state_->ring[(state_->head + i) & (state_->ring.size() - 1)];
      if (slot.only == &entry_) {
        slot.only = nullptr;
        slot.number = 0;
        slot.topic = &nobody();
      }
    }
  }

 private:
  static MemoryTopic& nobody() {
    static MemoryTopic topic;
    return topic;
  }

  void queue_retained() {
    for (const WriterEntry* writer : entry_.topic->writers) {
      if (!writer->has_last) continue;
      state_->push(entry_.topic, {writer->last.data(), writer->last.size()}).only = &entry_;
    }
  }

  StatePointer state_;
  ReaderEntry entry_;
};

}  // namespace

MemoryBus::MemoryBus() : state_(std::make_shared<State>()) { state_->mutex = &mutex(); }

MemoryBus::~MemoryBus() {
  std::lock_guard<std::recursive_mutex> lock(mutex());
  state_->mutex = nullptr;
}

std::unique_ptr<Writer> MemoryBus::make_writer(const TopicSpec& topic) {
  std::lock_guard<std::recursive_mutex> lock(mutex());
  HRP_CHECK(!state_->in_callback, "a callback may not make a writer (" << topic.name << ")");
  return std::make_unique<MemoryWriter>(state_, topic);
}

std::unique_ptr<Reader> MemoryBus::make_reader(const TopicSpec& topic, Delivery, SampleCallback callback) {
  std::lock_guard<std::recursive_mutex> lock(mutex());
  HRP_CHECK(!state_->in_callback, "a callback may not make a reader (" << topic.name << ")");
  return std::make_unique<MemoryReader>(state_, topic, std::move(callback));
}

std::vector<TopicSeen> MemoryBus::find_topics() {
  std::lock_guard<std::recursive_mutex> lock(mutex());
  std::vector<TopicSeen> seen;
  for (const auto& [name, topic] : state_->topics) {
    if (topic.writers.empty() && topic.readers.empty()) continue;
    seen.push_back(
        {name, topic.type_name, static_cast<int>(topic.writers.size()), static_cast<int>(topic.readers.size())});
  }
  return seen;
}

bool MemoryBus::dispatch_one() {
  std::lock_guard<std::recursive_mutex> lock(mutex());
  State& state = *state_;
  HRP_CHECK(!state.in_callback, "a callback may not dispatch");
  if (state.count == 0) return false;
  // The slot is free for writes of the callbacks as soon as it is taken; its memory goes round by the swap.
  Pending slot;
  {
    Pending& oldest = state.ring[state.head];
    slot.topic = oldest.topic;
    slot.only = oldest.only;
    slot.number = oldest.number;
    state.delivering.swap(oldest.bytes);
  }
  state.head = (state.head + 1) & (state.ring.size() - 1);
  --state.count;
  state.in_callback = true;
  struct Reset {
    bool& flag;
    ~Reset() { flag = false; }
  } reset{state.in_callback};
  state.deliver(slot, {state.delivering.data(), state.delivering.size()});
  return true;
}

size_t MemoryBus::dispatch_all(size_t limit) {
  size_t done = 0;
  while (done < limit && dispatch_one()) ++done;
  return done;
}

void MemoryBus::spin(std::chrono::milliseconds timeout) {
  const auto end = Clock::now() + timeout;
  {
    std::unique_lock<std::recursive_mutex> lock(mutex());
    state_->waiting = true;
    state_->written.wait_until(lock, end, [this] { return state_->count > 0; });
    state_->waiting = false;
  }
  // The clock costs a good part of a delivery: look at it now and then.
  do {
    if (dispatch_all(64) < 64) return;
  } while (Clock::now() < end);
}

}  // namespace hrp
