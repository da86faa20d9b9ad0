// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/failing_memory.h"

#include <atomic>
#include <cerrno>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define HRP_OWN_MALLOC 0
#else
#define HRP_OWN_MALLOC 1
#endif

namespace {

constexpr long kNever = -1;
std::atomic<long> countdown{kNever};  // allocations until one fails
std::atomic<bool> for_good{false};
std::atomic<bool> has_failed{false};

[[maybe_unused]] bool fails_now() {
  long left = countdown.load(std::memory_order_relaxed);
  do {
    if (left == kNever) return false;
  } while (!countdown.compare_exchange_weak(left, left > 0 ? left - 1 : (for_good ? 0 : kNever)));
  if (left > 0) return false;
  has_failed = true;
  errno = ENOMEM;
  return true;
}

}  // namespace

#if HRP_OWN_MALLOC
extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);

void* malloc(size_t size) { return fails_now() ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return fails_now() ? nullptr : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return fails_now() ? nullptr : __libc_realloc(old, size); }
}
#endif

namespace hrp::test {

bool can_memory_fail() { return HRP_OWN_MALLOC == 1; }

FailingMemory::FailingMemory(long n, Kind kind) {
  has_failed = false;
  for_good = kind == Kind::kFromThenOn;
  countdown = n;
}

bool FailingMemory::stop() {
  countdown = kNever;
  return has_failed;
}

}  // namespace hrp::test
