// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/reader.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/mcap/compression.h"

namespace hrp::mcap {
namespace {

constexpr size_t kTailSize = kFooterSize + kMagic.size();
// No writer makes larger chunks than this; a file that claims one is damaged.
constexpr uint64_t kLargestChunk = uint64_t{1} << 30;

bool get_message(Cursor cursor, Message* message) {
  message->channel_id = cursor.get<uint16_t>();
  message->sequence = cursor.get<uint32_t>();
  message->log_time = cursor.get<uint64_t>();
  message->publish_time = cursor.get<uint64_t>();
  message->size = cursor.remaining();
  message->data = cursor.get_bytes(message->size);
  return cursor.ok();
}

// Records that may stand before the end of the data. Opcodes from 0x80 on are private ones of other writers.
bool may_stand_in_data(Opcode opcode) {
  switch (opcode) {
    case Opcode::kHeader:
    case Opcode::kSchema:
    case Opcode::kChannel:
    case Opcode::kMessage:
    case Opcode::kChunk:
    case Opcode::kMessageIndex:
    case Opcode::kAttachment:
    case Opcode::kMetadata:
    case Opcode::kDataEnd: return true;
    default: return static_cast<uint8_t>(opcode) >= 0x80;
  }
}

}  // namespace

Reader::Reader(const std::string& path) : path_(path) {
  file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat info {};
  if (file_ < 0 || ::fstat(file_, &info) != 0) {
    const std::string reason = std::strerror(errno);
    if (file_ >= 0) ::close(file_);
    throw McapError(path + ": cannot be read: " + reason);
  }
  file_size_ = static_cast<uint64_t>(info.st_size);
  if (S_ISREG(info.st_mode) && file_size_ == 0) {
    ::close(file_);
    throw McapError(path + ": is empty: what should have filled it ended before it wrote anything");
  }
  std::vector<uint8_t> magic;
  if (!S_ISREG(info.st_mode) || !read_at(0, kMagic.size(), &magic) ||
      !std::equal(kMagic.begin(), kMagic.end(), magic.begin())) {
    ::close(file_);
    throw McapError(path + ": offset 0: no MCAP file (its first 8 bytes are not the magic of one)");
  }
  indexed_ = read_summary();
  if (!indexed_) scan();
  if (channels_.empty()) find_definitions();
}

Reader::~Reader() { ::close(file_); }

const Channel* Reader::find_channel(const std::string& topic) const {
  for (const auto& [id, channel] : channels_) {
    if (channel.topic == topic) return &channel;
  }
  return nullptr;
}

bool Reader::find_damage(uint64_t offset, const std::string& what) {
  const std::string text = path_ + ": offset " + std::to_string(offset) + ": " + what;
  if (damage_.find(text) == std::string::npos) damage_ += (damage_.empty() ? "" : "; ") + text;
  return false;
}

bool Reader::read_at(uint64_t offset, uint64_t size, std::vector<uint8_t>* bytes) const {
  if (offset > file_size_ || size > file_size_ - offset) return false;
  bytes->resize(size);
  uint64_t done = 0;
  while (done < size) {
    const ssize_t part = ::pread(file_, bytes->data() + done, size - done, static_cast<off_t>(offset + done));
    if (part < 0 && errno == EINTR) continue;
    if (part <= 0) return false;
    done += static_cast<uint64_t>(part);
  }
  return true;
}

bool Reader::read_summary() {
  std::vector<uint8_t> bytes;
  if (file_size_ < kMagic.size() + kTailSize || !read_at(file_size_ - kTailSize, kTailSize, &bytes) ||
      !std::equal(kMagic.begin(), kMagic.end(), bytes.end() - kMagic.size())) {
    return find_damage(file_size_, "the file was not closed (no magic at its end)");
  }
  Cursor footer(bytes.data(), kFooterSize);
  const uint64_t footer_offset = file_size_ - kTailSize;
  if (footer.get<uint8_t>() != static_cast<uint8_t>(Opcode::kFooter) || footer.get<uint64_t>() != 20) {
    return find_damage(footer_offset, "no footer before the magic at the end");
  }
  const auto summary_start = footer.get<uint64_t>();
  footer.get<uint64_t>();  // start of the offset section: we read the whole summary
  const auto expected_crc = footer.get<uint32_t>();
  if (summary_start == 0) return false;  // allowed: a file without an index
  if (summary_start < kMagic.size() || summary_start > footer_offset ||
      !read_at(summary_start, file_size_ - kMagic.size() - 4 - summary_start, &bytes)) {
    return find_damage(footer_offset, "the footer's summary lies outside of the file");
  }
  if (expected_crc != 0 && update_crc(0, bytes.data(), bytes.size()) != expected_crc) {
    return find_damage(summary_start, "the summary's checksum is wrong");
  }
  Cursor summary(bytes.data(), footer_offset - summary_start);
  while (summary.remaining() >= kRecordHead) {
    const uint64_t offset = summary_start + summary.position();
    const auto opcode = static_cast<Opcode>(summary.get<uint8_t>());
    const auto length = summary.get<uint64_t>();
    const uint8_t* contents = summary.get_bytes(length);
    if (contents == nullptr || !take_summary_record(opcode, Cursor(contents, length))) {
      schemas_.clear();
      channels_.clear();
      chunks_.clear();
      return find_damage(offset, "malformed record in the summary");
    }
  }
  std::sort(chunks_.begin(), chunks_.end(), [](const Chunk& a, const Chunk& b) { return a.offset < b.offset; });
  // Without chunk indexes there may be messages all the same: outside of chunks, or from a writer that keeps no index.
  return !chunks_.empty();
}

bool Reader::take_summary_record(Opcode opcode, Cursor cursor) {
  if (opcode == Opcode::kChunkIndex) return take_chunk_index(cursor);
  return take_definition(opcode, cursor);
}

bool Reader::take_chunk_index(Cursor cursor) {
  cursor.get<uint64_t>();  // first and last time
  cursor.get<uint64_t>();
  Chunk chunk;
  chunk.offset = cursor.get<uint64_t>();
  chunk.length = cursor.get<uint64_t>();
  const size_t map_size = cursor.get<uint32_t>();
  if (!cursor.ok() || map_size > cursor.remaining() || map_size % 10 != 0) return false;
  for (size_t i = 0; i < map_size / 10; ++i) {
    chunk.channels.insert(cursor.get<uint16_t>());
    cursor.get<uint64_t>();
  }
  if (!cursor.ok() || chunk.offset > file_size_ || chunk.length > file_size_ - chunk.offset) return false;
  chunks_.push_back(std::move(chunk));
  return true;
}

bool Reader::take_definition(Opcode opcode, Cursor cursor) {
  if (opcode == Opcode::kSchema) {
    Schema schema;
    if (!get_schema(cursor, &schema)) return false;
    schemas_.emplace(schema.id, std::move(schema));
  } else if (opcode == Opcode::kChannel) {
    Channel channel;
    if (!get_channel(cursor, &channel)) return false;
    channels_.emplace(channel.id, std::move(channel));
  }
  return true;
}

void Reader::scan() {
  uint64_t offset = kMagic.size();
  std::vector<uint8_t> head;
  Opcode previous = Opcode::kHeader;
  while (offset < file_size_) {
    if (file_size_ - offset < kRecordHead || !read_at(offset, kRecordHead, &head)) {
      find_damage(offset, "the file ends within a record");
      return;
    }
    Cursor cursor(head.data(), head.size());
    const auto opcode = static_cast<Opcode>(cursor.get<uint8_t>());
    const auto length = cursor.get<uint64_t>();
    // A message index without a chunk before it shows that the head of a chunk was damaged.
    const bool orphan =
        opcode == Opcode::kMessageIndex && previous != Opcode::kChunk && previous != Opcode::kMessageIndex;
    const bool headless = offset == kMagic.size() && opcode != Opcode::kHeader;
    if (!may_stand_in_data(opcode) || orphan || headless) {
      if (orphan && previous == Opcode::kMessage) chunks_.pop_back();  // that was the chunk
      find_damage(offset, "no record that could stand here begins here");
      return;
    }
    if (opcode == Opcode::kDataEnd) return;
    const uint64_t there = file_size_ - offset - kRecordHead;
    if (length > there) {
      find_damage(offset, "the file ends within a record");
      // What is there of the last chunk may hold whole messages.
      if (opcode == Opcode::kChunk) chunks_.push_back({offset, kRecordHead + there, {}});
      return;
    }
    if (!scan_record({opcode, offset, kRecordHead + length})) return;
    previous = opcode;
    offset += kRecordHead + length;
  }
}

bool Reader::scan_record(const Record& record) {
  if (record.opcode == Opcode::kChunk || record.opcode == Opcode::kMessage) {
    chunks_.push_back({record.offset, record.length, {}});
    return true;
  }
  if (record.opcode == Opcode::kMessageIndex) {
    // Its second field is the size of the rest; that tells it from a chunk whose opcode was hit.
    if (record.length < kRecordHead + 6 || !read_at(record.offset, kRecordHead + 6, &packed_)) {
      return find_damage(record.offset, "malformed message index");
    }
    Cursor cursor(packed_.data() + kRecordHead + 2, 4);
    return cursor.get<uint32_t>() == record.length - kRecordHead - 6 ||
           find_damage(record.offset, "malformed message index");
  }
  if (record.opcode != Opcode::kSchema && record.opcode != Opcode::kChannel) return true;
  if (!read_at(record.offset, record.length, &packed_) ||
      !take_definition(record.opcode, Cursor(packed_.data() + kRecordHead, packed_.size() - kRecordHead))) {
    return find_damage(record.offset, "malformed schema or channel");
  }
  return true;
}

// A recorder that was killed may leave schemas and channels in its chunks only.
void Reader::find_definitions() {
  const std::set<uint16_t> none;
  uint64_t count = 0;
  for (const Chunk& chunk : chunks_) {
    if (!read_chunk(chunk, nullptr, &none, &count)) break;
  }
}

uint64_t Reader::read_messages(const Visit& visit, const std::set<std::string>& topics) {
  std::set<uint16_t> wanted;
  for (const auto& [id, channel] : channels_) {
    if (topics.count(channel.topic) > 0) wanted.insert(id);
  }
  uint64_t count = 0;
  for (const Chunk& chunk : chunks_) {
    const auto is_wanted = [&](uint16_t id) { return wanted.count(id) > 0; };
    const bool skip = !topics.empty() && !chunk.channels.empty() &&
                      std::none_of(chunk.channels.begin(), chunk.channels.end(), is_wanted);
    if (!skip && !read_chunk(chunk, visit, topics.empty() ? nullptr : &wanted, &count)) break;
  }
  return count;
}

uint64_t Reader::read_chunk(size_t chunk, const Visit& visit) {
  uint64_t count = 0;
  if (chunk < chunks_.size()) read_chunk(chunks_[chunk], visit, nullptr, &count);
  return count;
}

bool Reader::read_chunk(const Chunk& chunk, const Visit& visit, const std::set<uint16_t>* wanted, uint64_t* count) {
  if (chunk.length < kRecordHead || !read_at(chunk.offset, chunk.length, &packed_)) {
    return find_damage(chunk.offset, "a chunk lies outside of the file");
  }
  Cursor cursor(packed_.data(), packed_.size());
  const auto opcode = static_cast<Opcode>(cursor.get<uint8_t>());
  const auto length = cursor.get<uint64_t>();
  const bool cut = length > cursor.remaining();
  if (opcode == Opcode::kMessage)
    return read_records(Cursor(packed_.data(), packed_.size()), chunk, visit, wanted, count);
  if (opcode != Opcode::kChunk) return find_damage(chunk.offset, "the index points here, but no chunk begins here");
  cursor.get<uint64_t>();  // first and last time
  cursor.get<uint64_t>();
  const auto size = cursor.get<uint64_t>();
  const auto crc = cursor.get<uint32_t>();
  const std::string compression = cursor.get_string();
  auto packed_size = cursor.get<uint64_t>();
  // The two lengths agree, also in a chunk that is cut short: else one of them was damaged.
  if (!cursor.ok() || size > kLargestChunk || packed_size != length - (cursor.position() - kRecordHead)) {
    return find_damage(chunk.offset, cut ? "the file ends within a record" : "malformed chunk");
  }
  packed_size = std::min<uint64_t>(packed_size, cursor.remaining());
  const Unpacked unpacked = decompress(compression, cursor.get_bytes(packed_size), packed_size, size, &plain_);
  if (unpacked != Unpacked::kWhole && !cut) return find_damage(chunk.offset, "a chunk that cannot be decompressed");
  // The checksum of a chunk that is cut short cannot be checked: what is there was written, and nothing changed it.
  if (!cut && crc != 0 && update_crc(0, plain_.data(), plain_.size()) != crc) {
    return find_damage(chunk.offset, "a chunk whose checksum is wrong");
  }
  const bool go_on = read_records(Cursor(plain_.data(), plain_.size()), chunk, visit, wanted, count);
  return go_on && (!cut || find_damage(chunk.offset, "the file ends within a record"));
}

bool Reader::read_records(Cursor cursor, const Chunk& chunk, const Visit& visit, const std::set<uint16_t>* wanted,
                          uint64_t* count) {
  while (cursor.remaining() >= kRecordHead) {
    const auto opcode = static_cast<Opcode>(cursor.get<uint8_t>());
    const auto length = cursor.get<uint64_t>();
    const uint8_t* contents = length <= cursor.remaining() ? cursor.get_bytes(length) : nullptr;
    if (contents == nullptr) break;
    const Cursor record(contents, length);
    Message message;
    if (opcode != Opcode::kMessage) {
      if (!take_definition(opcode, record)) return find_damage(chunk.offset, "malformed record in a chunk");
      continue;
    }
    if (!get_message(record, &message) || channels_.count(message.channel_id) == 0) {
      return find_damage(chunk.offset, "a message without a channel, or too short, in a chunk");
    }
    if (wanted != nullptr && wanted->count(message.channel_id) == 0) continue;
    message.chunk = static_cast<size_t>(&chunk - chunks_.data());
    ++*count;
    if (!visit(message)) return false;
  }
  return cursor.remaining() == 0 || find_damage(chunk.offset, "a chunk ends within a message");
}

}  // namespace hrp::mcap
