// SPDX-License-Identifier: BSD-3-Clause
// A bus whose writers keep the samples of gathered topics until they are flushed.
#pragma once

#include <memory>
#include <vector>

#include "common/bus/memory/memory_bus.h"

namespace hrp::test {

class GatheringBus : public Bus {
 public:
  explicit GatheringBus(MemoryBus& bus) : bus_(bus) {}

  std::unique_ptr<Writer> make_writer(const TopicSpec& topic) override {
    if (!topic.gathered) return bus_.make_writer(topic);
    return std::make_unique<GatheringWriter>(bus_.make_writer(topic));
  }
  std::unique_ptr<Reader> make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) override {
    return bus_.make_reader(topic, delivery, std::move(callback));
  }
  std::vector<TopicSeen> find_topics() override { return bus_.find_topics(); }
  std::string vendor() const override { return "memory"; }
  void spin(std::chrono::milliseconds timeout) override { bus_.spin(timeout); }

 private:
  class GatheringWriter : public Writer {
   public:
    explicit GatheringWriter(std::unique_ptr<Writer> writer) : writer_(std::move(writer)) {}
    void write(Bytes sample) override { waiting_.emplace_back(sample.data, sample.data + sample.size); }
    void flush() override {
      for (const auto& sample : waiting_) writer_->write({sample.data(), sample.size()});
      waiting_.clear();
    }
    bool has_readers() const override { return writer_->has_readers(); }

   private:
    std::unique_ptr<Writer> writer_;
    std::vector<std::vector<uint8_t>> waiting_;
  };

  MemoryBus& bus_;
};

}  // namespace hrp::test
