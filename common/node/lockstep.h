// SPDX-License-Identifier: BSD-3-Clause
// The two sides of a question that carries (epoch, step): docs/step_protocol.md, "Rules".
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "common/bus/bus.h"

namespace hrp {

// The scheduler grants at most this many steps beyond the last one that dynamics has reported: two of its largest
// windows.
constexpr uint64_t kMostGranted = 200;
// More resets than a reader can have missed between two grants.
constexpr uint64_t kMostEpochsAhead = 1000000;

enum class Question { kNew, kRepeated, kOld };

// For those who answer: which questions are new.
class QuestionFilter {
 public:
  Question classify(uint64_t epoch, uint64_t step) const {
    if (!any_ || epoch > epoch_ || (epoch == epoch_ && step > step_)) return Question::kNew;
    return epoch == epoch_ && step == step_ ? Question::kRepeated : Question::kOld;
  }
  // After the answer to (epoch, step) was sent.
  void note_answered(uint64_t epoch, uint64_t step) {
    any_ = true;
    epoch_ = epoch;
    step_ = step;
  }

 private:
  bool any_ = false;
  uint64_t epoch_ = 0;
  uint64_t step_ = 0;
};

// For the one who asks: when to ask again.
class RepeatTimer {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kSilence{50};

  // Something has been asked or heard.
  void restart(Clock::time_point now) { since_ = now; }
  bool is_due(Clock::time_point now) const { return now - since_ >= kSilence; }

 private:
  Clock::time_point since_{};
};

}  // namespace hrp
