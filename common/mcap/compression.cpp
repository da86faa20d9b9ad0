// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/compression.h"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace hrp::mcap {
namespace {

// Speed counts: the logger shares two cores with the loop. Level 1 packs 32 steps of a 30-joint robot to about a
// third; level 3 gains a few per cent and takes twice the time.
constexpr int kZstdLevel = 1;
constexpr size_t kGrowth = size_t{1} << 20;

// Of the names of errors of both libraries; their codes are not part of their stable interfaces. Data that were not
// unpacked for want of memory are not damaged.
bool lacks_memory(const char* error) {
  return std::strstr(error, "not enough memory") != nullptr || std::strstr(error, "llocation") != nullptr;
}

struct ZstdContextDeleter {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

Unpacked unzip_zstd(const uint8_t* data, size_t data_size, uint64_t size, std::vector<uint8_t>* out) {
  std::unique_ptr<ZSTD_DCtx, ZstdContextDeleter> context(ZSTD_createDCtx());
  if (!context) throw std::bad_alloc();
  ZSTD_inBuffer in{data, data_size, 0};
  size_t done = 0;
  while (true) {
    out->resize(std::min<uint64_t>(size + 1, done + kGrowth));  // one more byte, to notice that there is too much
    ZSTD_outBuffer part{out->data() + done, out->size() - done, 0};
    const size_t hint = ZSTD_decompressStream(context.get(), &part, &in);
    done += part.pos;
    if (lacks_memory(ZSTD_getErrorName(hint))) throw std::bad_alloc();
    if (ZSTD_isError(hint) || done > size) {
      out->resize(std::min<uint64_t>(done, size));
      return Unpacked::kCorrupt;
    }
    if (hint == 0 && in.pos == in.size) break;
    if (part.pos == 0 && in.pos == in.size) break;
  }
  out->resize(done);
  return done == size ? Unpacked::kWhole : Unpacked::kCutShort;
}

struct Lz4ContextDeleter {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

Unpacked unzip_lz4(const uint8_t* data, size_t data_size, uint64_t size, std::vector<uint8_t>* out) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) throw std::bad_alloc();
  std::unique_ptr<LZ4F_dctx, Lz4ContextDeleter> context(raw);
  size_t done = 0, used = 0;
  while (true) {
    out->resize(std::min<uint64_t>(size + 1, done + kGrowth));
    size_t written = out->size() - done, read = data_size - used;
    const size_t hint = LZ4F_decompress(context.get(), out->data() + done, &written, data + used, &read, nullptr);
    done += written;
    used += read;
    if (lacks_memory(LZ4F_getErrorName(hint))) throw std::bad_alloc();
    if (LZ4F_isError(hint) || done > size) {
      out->resize(std::min<uint64_t>(done, size));
      return Unpacked::kCorrupt;
    }
    if ((hint == 0 && used == data_size) || (written == 0 && read == 0)) break;
  }
  out->resize(done);
  return done == size ? Unpacked::kWhole : Unpacked::kCutShort;
}

}  // namespace

Compression parse_compression(const std::string& word) {
  if (word.empty() || word == "none") return Compression::kNone;
  if (word == "lz4") return Compression::kLz4;
  if (word == "zstd") return Compression::kZstd;
  throw McapError("unknown compression '" + word + "': expected none, lz4 or zstd");
}

std::string get_compression_word(Compression compression) {
  if (compression == Compression::kNone) return "";
  return compression == Compression::kLz4 ? "lz4" : "zstd";
}

struct Compressor::State {
  ZSTD_CCtx* zstd = nullptr;
  ~State() { ZSTD_freeCCtx(zstd); }
};

Compressor::Compressor(Compression compression) : compression_(compression), state_(std::make_unique<State>()) {
  if (compression == Compression::kZstd) state_->zstd = ZSTD_createCCtx();
  if (compression == Compression::kZstd && state_->zstd == nullptr) throw std::bad_alloc();
}

Compressor::~Compressor() = default;

void Compressor::append(const uint8_t* data, size_t size, Buffer* out) {
  const size_t begin = out->size();
  if (compression_ == Compression::kNone) {
    out->put_bytes(data, size);
    return;
  }
  const bool zstd = compression_ == Compression::kZstd;
  const size_t bound = zstd ? ZSTD_compressBound(size) : LZ4F_compressFrameBound(size, nullptr);
  out->resize(begin + bound);
  const size_t packed = zstd ? ZSTD_compressCCtx(state_->zstd, out->data() + begin, bound, data, size, kZstdLevel)
                             : LZ4F_compressFrame(out->data() + begin, bound, data, size, nullptr);
  if (zstd ? ZSTD_isError(packed) : LZ4F_isError(packed)) {
    out->resize(begin);
    throw McapError(std::string("compression failed: ") +
                    (zstd ? ZSTD_getErrorName(packed) : LZ4F_getErrorName(packed)));
  }
  out->resize(begin + packed);
}

Unpacked decompress(const std::string& compression, const uint8_t* data, size_t data_size, uint64_t size,
                    std::vector<uint8_t>* out) {
  out->clear();
  if (compression == "zstd") return unzip_zstd(data, data_size, size, out);
  if (compression == "lz4") return unzip_lz4(data, data_size, size, out);
  if (!compression.empty()) return Unpacked::kCorrupt;
  if (data_size > size) return Unpacked::kCorrupt;
  out->assign(data, data + data_size);
  return data_size == size ? Unpacked::kWhole : Unpacked::kCutShort;
}

}  // namespace hrp::mcap
