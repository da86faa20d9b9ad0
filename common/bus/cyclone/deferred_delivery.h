// SPDX-License-Identifier: BSD-3-Clause
// Delivery of samples that were written in this same process. Cyclone DDS hands those to readers inside write(), on the
// writer's thread and with the writer's locks: a thread of our own takes them from there.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace hrp {

// Marks this thread as being inside a write.
class WritingScope {
 public:
  WritingScope() { ++depth(); }
  ~WritingScope() { --depth(); }
  WritingScope(const WritingScope&) = delete;
  WritingScope& operator=(const WritingScope&) = delete;
  static bool is_active() { return depth() > 0; }

 private:
  static int& depth() {
    thread_local int value = 0;
    return value;
  }
};

class DeferredReader {
 public:
  virtual ~DeferredReader() = default;
  // Takes what is there and runs the callback.
  virtual void deliver() = 0;
};

class DeferredDelivery {
 public:
  ~DeferredDelivery();
  // Has `reader` deliver on the thread, which starts at the first call.
  void add(DeferredReader* reader);
  // After this the thread does not touch `reader` any more. Its gate must be closed.
  void forget(DeferredReader* reader);

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<DeferredReader*> waiting_;
  DeferredReader* delivering_ = nullptr;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace hrp
