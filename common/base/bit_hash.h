// SPDX-License-Identifier: BSD-3-Clause
// A hash of the bits of numbers, to prove that two runs are equal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

namespace hrp {

// Word by word: FNV-1a's exclusive or and odd multiplier (Fowler, Noll, Vo), on 64 bits at a time instead of 8, and a
// shift that brings the high bits down, since a product only carries upwards. Each step maps words to hashes one to
// one, so a change of one word always changes the result. One multiplication a word: a state is hashed at every step.
// Order counts; -0.0 and 0.0 differ.
class BitHash {
 public:
  void add(uint64_t word) {
    hash_ = (hash_ ^ word) * 1099511628211ull;
    hash_ ^= hash_ >> 32;
  }
  void add(double value) {
    uint64_t word = 0;
    std::memcpy(&word, &value, sizeof word);
    add(word);
  }
  void add(const double* values, size_t count) {
    for (size_t i = 0; i < count; ++i) add(values[i]);
  }
  uint64_t get() const { return hash_; }

 private:
  uint64_t hash_ = 14695981039346656037ull;
};

// The one way to print a hash: 16 hexadecimal digits.
inline std::string format_hash(uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace hrp
