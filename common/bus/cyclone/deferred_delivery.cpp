// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/cyclone/deferred_delivery.h"

#include <algorithm>

#include "common/base/has.h"

namespace hrp {

DeferredDelivery::~DeferredDelivery() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void DeferredDelivery::add(DeferredReader* reader) {
  std::lock_guard<std::mutex> lock(mutex_);
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  if (has(waiting_, reader)) return;
  waiting_.push_back(reader);
  changed_.notify_all();
}

void DeferredDelivery::forget(DeferredReader* reader) {
  std::unique_lock<std::mutex> lock(mutex_);
  waiting_.erase(std::remove(waiting_.begin(), waiting_.end(), reader), waiting_.end());
  changed_.wait(lock, [&] { return delivering_ != reader || thread_.get_id() == std::this_thread::get_id(); });
}

void DeferredDelivery::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || !waiting_.empty(); });
    if (stop_) return;
    delivering_ = waiting_.front();
    waiting_.pop_front();
    lock.unlock();
    delivering_->deliver();
    lock.lock();
    delivering_ = nullptr;
    changed_.notify_all();
  }
}

}  // namespace hrp
