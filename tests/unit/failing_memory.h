// SPDX-License-Identifier: BSD-3-Clause
// Allocations that fail on demand: malloc and its kin of the whole test program, its libraries included.
#pragma once

namespace hrp::test {

// False in builds with sanitizers, which bring a malloc of their own.
bool can_memory_fail();

// While it lives, the n-th allocation from now on fails (0 is the first), alone or with all that follow; on any thread.
class FailingMemory {
 public:
  enum class Kind { kOnce, kFromThenOn };
  FailingMemory(long n, Kind kind);
  ~FailingMemory() { stop(); }
  FailingMemory(const FailingMemory&) = delete;
  FailingMemory& operator=(const FailingMemory&) = delete;
  // Allocations work again. Returns whether one has failed.
  bool stop();
};

}  // namespace hrp::test
