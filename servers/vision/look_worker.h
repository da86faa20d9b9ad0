// SPDX-License-Identifier: BSD-3-Clause
// Takes pictures in a thread of its own, so that whoever asks for them never waits.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "servers/vision/picture_maker.h"

namespace hrp {

struct LookJob {
  uint64_t epoch = 0;
  double time = 0.0;  // [s] simulated
  Look look;
};

struct LookDone {
  LookJob job;
  LookResult result;
  std::string fault;  // why there are no pictures; empty: there are
};

class LookWorker {
 public:
  enum class Late {
    kDrop,  // a look that has not begun when the next one is due is left out
    kQueue  // every look is taken
  };
  LookWorker(std::unique_ptr<PictureMaker> maker, Late late);
  // Waits for the look that is being taken.
  ~LookWorker();

  // Returns how many sensors' pictures were dropped for it.
  size_t post(LookJob job);
  // In the order of the posts.
  std::optional<LookDone> take_done();
  // The oldest look that was posted and not taken back by take_done(). None: nothing is under way.
  std::optional<uint64_t> find_oldest_step() const;
  // Nobody wants what was posted, also what is being taken.
  void forget_all();

 private:
  void work();
  LookDone take_look(LookJob job);

  const std::unique_ptr<PictureMaker> maker_;  // used by the thread alone
  const Late late_;
  mutable std::mutex mutex_;
  std::condition_variable posted_;
  std::deque<LookJob> waiting_;
  std::optional<uint64_t> at_work_;  // step that is being taken, if somebody wants it
  std::deque<LookDone> done_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace hrp
