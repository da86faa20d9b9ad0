// SPDX-License-Identifier: BSD-3-Clause
// Serialises the callbacks of a bus whose middleware calls from threads of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "common/base/check.h"
#include "common/bus/bus.h"

namespace hrp {

// Belongs to one reader. Enters the bus's mutex unless the reader is being destroyed: whoever destroys a reader may
// hold the mutex, and the middleware waits for running callbacks, so a plain lock here could wait for ever.
class CallbackGate {
 public:
  explicit CallbackGate(std::recursive_mutex* mutex) : mutex_(mutex) {}

  void close() { closed_ = true; }

  // An empty lock when the gate is closed.
  std::unique_lock<std::recursive_mutex> enter() {
    std::unique_lock<std::recursive_mutex> lock(*mutex_, std::defer_lock);
    // The mutex is rarely taken, and then for microseconds: only a stalled callback elsewhere gets us to sleep.
    for (int tries = 0; !closed_; ++tries) {
      if (lock.try_lock()) {
        if (closed_) lock.unlock();
        return lock;
      }
      if (tries < 100) {
        std::this_thread::yield();
      } else {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
    }
    return lock;
  }

 private:
  std::recursive_mutex* mutex_;
  std::atomic<bool> closed_{false};
};

// One name, one type: on DDS ends of different types would silently not match.
class TopicTypes {
 public:
  void check(const TopicSpec& topic) {
    const std::string& known = types_.emplace(topic.name, topic.type_name).first->second;
    HRP_CHECK(known == topic.type_name, "topic " << topic.name << " carries " << known << ", not " << topic.type_name);
  }

 private:
  std::map<std::string, std::string> types_;
};

}  // namespace hrp
