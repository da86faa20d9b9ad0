// SPDX-License-Identifier: BSD-3-Clause
// A bus that delivers late, twice, out of order or not at all, as its seed has it.
#pragma once

#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "common/bus/memory/memory_bus.h"

namespace hrp::test {

// Probabilities for each sample on its way to each reader.
struct MessageFaults {
  double late = 0.0;  // it waits until everything that is under way has arrived; then again with this probability
  double twice = 0.0;
  double overtake = 0.0;  // of samples that wait, another than the oldest arrives; DDS promises that this never happens
  double lost = 0.0;
};

class FaultyBus : public Bus {
 public:
  FaultyBus(MemoryBus& bus, const MessageFaults& faults, unsigned seed)
      : bus_(bus),
        faults_(faults),
        random_(seed),
        poke_(bus.make_writer({"test/poke", "test::Poke"})),
        pokes_(bus.make_reader({"test/poke", "test::Poke"}, Delivery::kReliable, [this](Bytes b) { release(b); })) {}

  std::unique_ptr<Writer> make_writer(const TopicSpec& topic) override { return bus_.make_writer(topic); }
  std::unique_ptr<Reader> make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) override {
    const auto link = std::make_shared<Link>();
    link->callback = std::move(callback);
    links_.push_back(link);
    const auto index = static_cast<uint32_t>(links_.size() - 1);
    auto reader =
        bus_.make_reader(topic, delivery, [this, link, index](Bytes sample) { take(link.get(), index, sample); });
    return std::make_unique<FaultyReader>(std::move(reader), link);
  }
  std::vector<TopicSeen> find_topics() override { return bus_.find_topics(); }
  std::string vendor() const override { return "memory"; }
  void spin(std::chrono::milliseconds timeout) override { bus_.spin(timeout); }
  int count() const { return count_; }  // faults so far

 private:
  struct Link {
    SampleCallback callback;  // empty after the reader's end
    std::vector<std::vector<uint8_t>> waiting;
  };
  class FaultyReader : public Reader {
   public:
    FaultyReader(std::unique_ptr<Reader> reader, std::shared_ptr<Link> link)
        : reader_(std::move(reader)), link_(std::move(link)) {}
    ~FaultyReader() override { link_->callback = nullptr; }

   private:
    std::unique_ptr<Reader> reader_;
    std::shared_ptr<Link> link_;
  };

  bool draw(double probability) {
    const bool hit = std::uniform_real_distribution<double>(0.0, 1.0)(random_) < probability;
    count_ += hit ? 1 : 0;
    return hit;
  }

  void take(Link* link, uint32_t index, Bytes sample) {
    if (draw(faults_.lost)) return;
    const int copies = draw(faults_.twice) ? 2 : 1;
    for (int i = 0; i < copies; ++i) {
      link->waiting.emplace_back(sample.data, sample.data + sample.size);
      if (link->waiting.size() > 1 || draw(faults_.late))
        poke(index);
      else
        deliver(link);
    }
  }

  void poke(uint32_t index) {
    uint8_t bytes[sizeof index];
    std::memcpy(bytes, &index, sizeof index);
    poke_->write({bytes, sizeof bytes});
  }

  void release(Bytes sample) {
    uint32_t index = 0;
    std::memcpy(&index, sample.data, sizeof index);
    Link* link = links_[index].get();
    if (link->waiting.empty()) return;
    if (draw(faults_.late))
      poke(index);
    else
      deliver(link);
  }

  void deliver(Link* link) {
    size_t at = 0;
    if (link->waiting.size() > 1 && draw(faults_.overtake)) at = link->waiting.size() - 1;
    const std::vector<uint8_t> sample = link->waiting[at];
    link->waiting.erase(link->waiting.begin() + static_cast<long>(at));
    if (link->callback) link->callback({sample.data(), sample.size()});
  }

  MemoryBus& bus_;
  MessageFaults faults_;
  std::mt19937 random_;
  int count_ = 0;
  std::vector<std::shared_ptr<Link>> links_;
  std::unique_ptr<Writer> poke_;
  std::unique_ptr<Reader> pokes_;
};

}  // namespace hrp::test
