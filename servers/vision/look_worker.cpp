// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/look_worker.h"

#include <sys/resource.h>

#include <exception>

namespace hrp {
namespace {

// Of this thread alone, as Linux has it.
void yield_to_others() { setpriority(PRIO_PROCESS, 0, 10); }

}  // namespace

LookWorker::LookWorker(std::unique_ptr<PictureMaker> maker, Late late)
    : maker_(std::move(maker)), late_(late), thread_([this] { work(); }) {}

LookWorker::~LookWorker() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  posted_.notify_one();
  thread_.join();
}

size_t LookWorker::post(LookJob job) {
  size_t dropped = 0;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (late_ == Late::kDrop) {
      for (const LookJob& waiting : waiting_) dropped += waiting.look.sensors.size();
      waiting_.clear();
    }
    waiting_.push_back(std::move(job));
  }
  posted_.notify_one();
  return dropped;
}

std::optional<LookDone> LookWorker::take_done() {
  std::lock_guard<std::mutex> lock(mutex_);
  if (done_.empty()) return std::nullopt;
  LookDone first = std::move(done_.front());
  done_.pop_front();
  return first;
}

std::optional<uint64_t> LookWorker::find_oldest_step() const {
  std::lock_guard<std::mutex> lock(mutex_);
  if (!done_.empty()) return done_.front().job.look.step;
  if (at_work_) return at_work_;
  if (!waiting_.empty()) return waiting_.front().look.step;
  return std::nullopt;
}

void LookWorker::forget_all() {
  std::lock_guard<std::mutex> lock(mutex_);
  waiting_.clear();
  done_.clear();
  at_work_.reset();  // what is being taken is dropped when it is done
}

LookDone LookWorker::take_look(LookJob job) {
  LookDone done;
  done.job = std::move(job);
  try {
    maker_->look(done.job.look, &done.result);
  } catch (const std::exception& error) {
    done.fault = error.what();
  }
  return done;
}

void LookWorker::work() {
  // Nobody waits for these pictures, so the run comes first where cores are few.
  if (late_ == Late::kDrop) yield_to_others();
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    posted_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
    if (ends_) return;
    LookJob job = std::move(waiting_.front());
    waiting_.pop_front();
    at_work_ = job.look.step;
    lock.unlock();
    LookDone done = take_look(std::move(job));
    lock.lock();
    if (at_work_) done_.push_back(std::move(done));
    at_work_.reset();
  }
}

}  // namespace hrp
