// SPDX-License-Identifier: BSD-3-Clause
// Writes MCAP files: chunked, compressed, indexed. Equal calls give equal bytes: no clock, no host name, no random id.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/mcap/claimed_file.h"
#include "common/mcap/compression.h"
#include "common/mcap/format.h"

namespace hrp::mcap {

// What reaches the disk reaches it in whole records, one write() a chunk. A process that is killed loses at most the
// messages after the last write_chunk(). When the disk refuses (full, say), the file is cut back to its last whole
// record, so that it stays readable, and McapError is thrown; the writer then only closes.
class Writer {
 public:
  // Empties the file. Throws McapError. `profile`: see put_beginning().
  Writer(ClaimedFile file, Compression compression, const std::string& profile = "");
  // Of a new file: one that holds something is refused.
  Writer(const std::string& path, Compression compression)
      : Writer(ClaimedFile(path, Existing::kRefuse), compression) {}
  // Closes without a word about errors: call close() to hear of them.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // From now on write_chunk() and close() return when the bytes are on the disk: they survive a power cut, not only a
  // kill.
  void set_durable(bool durable) { durable_ = durable; }
  // Schemas before channels before messages, at any time. They are on disk after the next write_chunk().
  uint16_t add_schema(const std::string& name, const std::string& encoding, const std::string& text);
  uint16_t add_channel(const std::string& topic, uint16_t schema_id, const std::string& message_encoding,
                       std::map<std::string, std::string> metadata = {});
  // A file inside of the file, between chunks: ends the open chunk. Its times are zero.
  void add_attachment(const std::string& name, const std::string& media_type, const std::string& content);
  // Takes a copy into the open chunk. Allocates nothing once the buffers have grown to their size.
  void add_message(const Message& message);
  // Compresses the open chunk and hands it to the operating system. Nothing happens when it is empty.
  void write_chunk();
  // Writes the open chunk, the index and the footer. Later calls do nothing.
  void close();

  uint16_t channel_count() const { return static_cast<uint16_t>(channels_.size()); }
  const std::string& path() const { return path_; }
  size_t open_chunk_size() const { return chunk_.size(); }
  uint64_t file_size() const { return file_size_; }
  bool failed() const { return failed_; }

 private:
  struct ChunkIndex {
    uint64_t start_time, end_time, offset, length;
    std::vector<std::pair<uint16_t, uint64_t>> message_index_offsets;
    uint64_t message_index_length, compressed_size, uncompressed_size;
  };
  struct AttachmentIndex {
    uint64_t offset, length, size;
    std::string name, media_type;
  };
  using TimeAndOffset = std::pair<uint64_t, uint64_t>;

  void append_chunk();
  void sync();
  void append_to_file(const Buffer& bytes);
  void put_message_indexes(ChunkIndex* index);
  void put_statistics(Buffer* out) const;
  void put_attachment_index(const AttachmentIndex& index, Buffer* out) const;
  void put_chunk_index(const ChunkIndex& index, Buffer* out) const;
  void write_summary();
  [[noreturn]] void fail(int error_number);

  std::string path_;
  ClaimedFile file_;
  bool closed_ = false;
  bool durable_ = false;
  bool name_synced_ = false;
  Compression compression_;
  Compressor compressor_;
  uint64_t file_size_ = 0;  // bytes of whole records on disk
  uint32_t data_crc_ = 0;   // of the data section so far
  bool failed_ = false;
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  Buffer definitions_;                                  // schemas and channels that are not on disk yet
  Buffer chunk_;                                        // the open chunk, uncompressed
  Buffer out_;                                          // what goes to disk next
  std::vector<std::vector<TimeAndOffset>> open_index_;  // by channel
  uint64_t chunk_start_ = 0, chunk_end_ = 0;            // [ns] of the open chunk
  uint64_t log_start_ = 0, log_end_ = 0;                // [ns] of the file
  std::vector<uint64_t> message_counts_;                // by channel
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
};

}  // namespace hrp::mcap
