// SPDX-License-Identifier: BSD-3-Clause
// The MCAP file format, version 0: https://mcap.dev/spec. Magic, then records of opcode (1 byte), length (8 bytes) and
// contents, all numbers little endian. What writer and reader share.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace hrp::mcap {

constexpr std::array<uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Opcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

constexpr size_t kRecordHead = 9;                 // opcode and length
constexpr size_t kFooterSize = kRecordHead + 20;  // with its head

// A file that cannot be written or read. The text names the file and, where known, the offset.
class McapError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Schema {
  uint16_t id = 0;
  std::string name;      // "hrp::msg::RobotState"
  std::string encoding;  // "omgidl"
  std::string text;
};

struct Channel {
  uint16_t id = 0;
  uint16_t schema_id = 0;
  std::string topic;
  std::string message_encoding;  // "cdr"
  std::map<std::string, std::string> metadata;
};

// `data` points into memory of the reader, valid until its next call.
struct Message {
  uint16_t channel_id = 0;
  uint32_t sequence = 0;
  uint64_t log_time = 0;      // [ns]
  uint64_t publish_time = 0;  // [ns]
  const uint8_t* data = nullptr;
  size_t size = 0;
  size_t chunk = 0;  // of a message that was read: number of its chunk in the file
};

// CRC-32 as in zlib (polynomial 0xEDB88320), continued from `crc`; starts at 0.
uint32_t update_crc(uint32_t crc, const uint8_t* data, size_t size);

// Appends numbers and strings; the machines we run on are little endian (checked in format.cpp).
class Buffer {
 public:
  template <typename Number>
  void put(Number value) {
    put_bytes(reinterpret_cast<const uint8_t*>(&value), sizeof value);
  }
  void put_bytes(const uint8_t* data, size_t size) { bytes_.insert(bytes_.end(), data, data + size); }
  void put_string(const std::string& text) {
    put(static_cast<uint32_t>(text.size()));
    put_bytes(reinterpret_cast<const uint8_t*>(text.data()), text.size());
  }
  // Overwrites a number written before.
  template <typename Number>
  void set(size_t offset, Number value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof value);
  }
  // Begins a record and returns the place that end_record() needs.
  size_t begin_record(Opcode opcode) {
    put(static_cast<uint8_t>(opcode));
    put(uint64_t{0});
    return bytes_.size();
  }
  void end_record(size_t begin) { set(begin - 8, static_cast<uint64_t>(bytes_.size() - begin)); }
  void resize(size_t size) { bytes_.resize(size); }
  void clear() { bytes_.clear(); }
  uint8_t* data() { return bytes_.data(); }
  const uint8_t* data() const { return bytes_.data(); }
  size_t size() const { return bytes_.size(); }

 private:
  std::vector<uint8_t> bytes_;
};

// Reads what Buffer writes, with bounds: reading past the end gives zeros and ok() == false from then on.
class Cursor {
 public:
  Cursor(const uint8_t* data, size_t size) : data_(data), size_(size) {}
  template <typename Number>
  Number get() {
    Number value{};
    if (take(sizeof value)) std::memcpy(&value, data_ + at_ - sizeof value, sizeof value);
    return value;
  }
  std::string get_string() {
    const size_t size = get<uint32_t>();
    return take(size) ? std::string(reinterpret_cast<const char*>(data_ + at_ - size), size) : std::string();
  }
  // `size` bytes in place, nullptr when they are not there.
  const uint8_t* get_bytes(size_t size) { return take(size) ? data_ + at_ - size : nullptr; }
  bool ok() const { return ok_; }
  size_t position() const { return at_; }
  size_t remaining() const { return size_ - at_; }

 private:
  bool take(size_t size) {
    ok_ = ok_ && size <= size_ - at_;
    if (ok_) at_ += size;
    return ok_;
  }
  const uint8_t* data_;
  size_t size_;
  size_t at_ = 0;
  bool ok_ = true;
};

// What every file of ours begins with: the magic and the header record. Profile: "ros2" for bags, none for logs.
void put_beginning(Buffer* out, const std::string& profile = "");
void put_schema(const Schema& schema, Buffer* out);
void put_channel(const Channel& channel, Buffer* out);
// Contents of a record without its head; false when they are malformed.
bool get_schema(Cursor cursor, Schema* schema);
bool get_channel(Cursor cursor, Channel* channel);

}  // namespace hrp::mcap
