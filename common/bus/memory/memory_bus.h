// SPDX-License-Identifier: BSD-3-Clause
// A bus inside one process: a first-in first-out queue that somebody empties. The order of deliveries depends on the
// order of writes only, so a run repeats to the bit. In the steady state a sample costs no allocation.
#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"

namespace hrp {

class MemoryBus : public Bus {
 public:
  MemoryBus();
  ~MemoryBus() override;
  std::unique_ptr<Writer> make_writer(const TopicSpec& topic) override;
  std::unique_ptr<Reader> make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) override;
  std::vector<TopicSeen> find_topics() override;
  std::string vendor() const override { return "memory"; }
  // Waits up to `timeout` for a first sample (of another thread), then delivers until the queue is empty or `timeout`
  // is over. So an idle bus does not spin and a busy one returns as soon as there is nothing left to do.
  void spin(std::chrono::milliseconds timeout) override;
  // Delivers the oldest sample to all its readers, on the calling thread. False: there was none. Not from callbacks.
  bool dispatch_one();
  // Delivers what is there and what the callbacks add, up to `limit` samples. Returns how many.
  size_t dispatch_all(size_t limit = SIZE_MAX);

  struct State;  // shared with readers and writers, which may outlive the bus

 private:
  std::shared_ptr<State> state_;
};

}  // namespace hrp
