// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/parallel_for.h"

#include <algorithm>
#include <atomic>
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
  std::vector<std::thread> pool;
  for (int t = 0; t < threads; ++t) {
    pool.emplace_back([&, t] {
      for (int i = next++; i < count; i = next++) work(i, t);
    });
  }
  for (std::thread& thread : pool) thread.join();
}

void parallel_for(int jobs, int count, const std::function<void(int)>& work) {
  parallel_for(jobs, count, [&work](int i, int) { work(i); });
}

}  // namespace hrp
