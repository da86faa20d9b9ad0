// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace hrp {

void parallel_for(int jobs, int count, const std::function<void(int, int)>& work) {
  const int threads = std::min(std::max(1, jobs), count);
  if (threads <= 1) {
    for (int i = 0; i < count; ++i) work(i, 0);
    return;
  }
  std::atomic<int> next{0};
  std::mutex mutex;
  std::exception_ptr failure;  // the first; what has not begun then is left
  const auto take_work = [&](int t) {
    try {
      for (int i = next++; i < count; i = next++) work(i, t);
    } catch (...) {
      next = count;
      const std::lock_guard<std::mutex> lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::thread> pool;
  pool.reserve(static_cast<size_t>(threads));
  try {
    for (int t = 1; t < threads; ++t) pool.emplace_back([&take_work, t] { take_work(t); });
  } catch (const std::system_error&) {
    // No more threads are to be had: fewer do the same work.
  }
  take_work(0);
  for (std::thread& thread : pool) thread.join();
  if (failure) std::rethrow_exception(failure);
}

void parallel_for(int jobs, int count, const std::function<void(int)>& work) {
  parallel_for(jobs, count, [&work](int i, int) { work(i); });
}

}  // namespace hrp
