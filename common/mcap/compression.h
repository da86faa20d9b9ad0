// SPDX-License-Identifier: BSD-3-Clause
// The two compressions that MCAP knows, and none.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/mcap/format.h"

namespace hrp::mcap {

enum class Compression { kNone, kLz4, kZstd };

// "none" (in files: ""), "lz4", "zstd". Throws McapError for another word.
Compression parse_compression(const std::string& word);
// As it stands in a file.
std::string get_compression_word(Compression compression);

// Keeps its working memory between calls: compressing allocates nothing once warm.
class Compressor {
 public:
  explicit Compressor(Compression compression);
  ~Compressor();
  // Appends the compressed bytes to `out`.
  void append(const uint8_t* data, size_t size, Buffer* out);

 private:
  struct State;
  Compression compression_;
  std::unique_ptr<State> state_;
};

// Outcome of a decompression. `out` holds what could be had, in any case.
enum class Unpacked { kWhole, kCutShort, kCorrupt };

// `size` is what the file promises; memory grows with what is really there, so that a lie costs nothing.
Unpacked decompress(const std::string& compression, const uint8_t* data, size_t data_size, uint64_t size,
                    std::vector<uint8_t>* out);

}  // namespace hrp::mcap
