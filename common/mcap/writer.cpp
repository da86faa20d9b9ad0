// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <numeric>
#include <utility>

#include "common/base/check.h"

namespace hrp::mcap {
namespace {

// What was put into a buffer is taken back unless it is kept: memory may run out in the middle of a record.
class AllOrNothing {
 public:
  explicit AllOrNothing(Buffer* buffer) : buffer_(buffer), size_(buffer->size()) {}
  ~AllOrNothing() {
    if (!kept_) buffer_->resize(size_);
  }
  AllOrNothing(const AllOrNothing&) = delete;
  AllOrNothing& operator=(const AllOrNothing&) = delete;
  void keep() { kept_ = true; }

 private:
  Buffer* buffer_;
  size_t size_;
  bool kept_ = false;
};

}  // namespace

Writer::Writer(ClaimedFile file, Compression compression, const std::string& profile)
    : path_(file.path()), file_(std::move(file)), compression_(compression), compressor_(compression) {
  file_.clear();
  put_beginning(&definitions_, profile);
}

Writer::~Writer() {
  try {
    close();
  } catch (const std::exception&) {
    // Said to whoever called close(); a destructor has nobody to tell.
  }
}

uint16_t Writer::add_schema(const std::string& name, const std::string& encoding, const std::string& text) {
  AllOrNothing addition(&definitions_);
  Schema schema{static_cast<uint16_t>(schemas_.size() + 1), name, encoding, text};
  put_schema(schema, &definitions_);
  schemas_.push_back(std::move(schema));
  addition.keep();
  return schemas_.back().id;
}

uint16_t Writer::add_channel(const std::string& topic, uint16_t schema_id, const std::string& message_encoding,
                             std::map<std::string, std::string> metadata) {
  HRP_CHECK(schema_id >= 1 && schema_id <= schemas_.size(), "schema " << schema_id << " of topic " << topic);
  AllOrNothing addition(&definitions_);
  Channel channel{static_cast<uint16_t>(channels_.size()), schema_id, topic, message_encoding, std::move(metadata)};
  put_channel(channel, &definitions_);
  // One place too many in these two does no harm.
  open_index_.resize(channels_.size() + 1);
  message_counts_.resize(channels_.size() + 1);
  channels_.push_back(std::move(channel));
  addition.keep();
  return channels_.back().id;
}

void Writer::add_attachment(const std::string& name, const std::string& media_type, const std::string& content) {
  write_chunk();
  out_.clear();
  const size_t begin = out_.begin_record(Opcode::kAttachment);
  out_.put(uint64_t{0});  // log time
  out_.put(uint64_t{0});  // create time
  out_.put_string(name);
  out_.put_string(media_type);
  out_.put(static_cast<uint64_t>(content.size()));
  out_.put_bytes(reinterpret_cast<const uint8_t*>(content.data()), content.size());
  // The checksum covers the contents of the record up to itself.
  out_.put(update_crc(0, out_.data() + begin, out_.size() - begin));
  out_.end_record(begin);
  AttachmentIndex index{file_size_, out_.size(), content.size(), name, media_type};
  attachments_.reserve(attachments_.size() + 1);  // what is in the file is in the index, too
  append_to_file(out_);
  attachments_.push_back(std::move(index));
}

void Writer::add_message(const Message& message) {
  HRP_CHECK(message.channel_id < channels_.size(), "channel " << message.channel_id);
  if (failed_) throw McapError(path_ + ": writing has failed before");
  if (chunk_.size() == 0) {
    chunk_start_ = chunk_end_ = message.log_time;
  }
  chunk_start_ = std::min(chunk_start_, message.log_time);
  chunk_end_ = std::max(chunk_end_, message.log_time);
  std::vector<TimeAndOffset>& index = open_index_[message.channel_id];
  AllOrNothing addition(&chunk_);
  const size_t begin = chunk_.begin_record(Opcode::kMessage);
  chunk_.put(message.channel_id);
  chunk_.put(message.sequence);
  chunk_.put(message.log_time);
  chunk_.put(message.publish_time);
  chunk_.put_bytes(message.data, message.size);
  chunk_.end_record(begin);
  index.emplace_back(message.log_time, begin - kRecordHead);
  addition.keep();
}

void Writer::write_chunk() {
  if (failed_) throw McapError(path_ + ": writing has failed before");
  if (definitions_.size() > 0) {
    append_to_file(definitions_);
    definitions_.clear();
  }
  if (chunk_.size() > 0) append_chunk();
  if (durable_) sync();
}

void Writer::append_chunk() {
  out_.clear();
  const size_t begin = out_.begin_record(Opcode::kChunk);
  out_.put(chunk_start_);
  out_.put(chunk_end_);
  out_.put(static_cast<uint64_t>(chunk_.size()));
  out_.put(update_crc(0, chunk_.data(), chunk_.size()));
  out_.put_string(get_compression_word(compression_));
  out_.put(uint64_t{0});  // size of what follows, set below
  const size_t packed_begin = out_.size();
  compressor_.append(chunk_.data(), chunk_.size(), &out_);
  const uint64_t packed_size = out_.size() - packed_begin;
  out_.set(packed_begin - 8, packed_size);
  out_.end_record(begin);

  ChunkIndex index{chunk_start_, chunk_end_, file_size_, out_.size(), {}, 0, packed_size, chunk_.size()};
  put_message_indexes(&index);
  if (chunks_.size() == chunks_.capacity())
    chunks_.reserve(2 * chunks_.size() + 64);  // what is in the file is in the index, too
  append_to_file(out_);
  log_start_ = chunks_.empty() ? chunk_start_ : std::min(log_start_, chunk_start_);
  log_end_ = std::max(log_end_, chunk_end_);
  chunks_.push_back(std::move(index));
  for (size_t channel = 0; channel < open_index_.size(); ++channel) {
    message_counts_[channel] += open_index_[channel].size();
    open_index_[channel].clear();
  }
  chunk_.clear();
}

void Writer::put_message_indexes(ChunkIndex* index) {
  const size_t indexes_begin = out_.size();
  for (size_t channel = 0; channel < open_index_.size(); ++channel) {
    if (open_index_[channel].empty()) continue;
    index->message_index_offsets.emplace_back(static_cast<uint16_t>(channel), file_size_ + out_.size());
    const size_t begin = out_.begin_record(Opcode::kMessageIndex);
    out_.put(static_cast<uint16_t>(channel));
    out_.put(static_cast<uint32_t>(open_index_[channel].size() * 16));
    for (const auto& [time, offset] : open_index_[channel]) {
      out_.put(time);
      out_.put(offset);
    }
    out_.end_record(begin);
  }
  index->message_index_length = out_.size() - indexes_begin;
}

// A file's name is on the disk when its folder is.
void Writer::sync() {
  if (::fdatasync(file_.descriptor()) != 0 && errno != EINVAL) {  // EINVAL: a pipe or a device
    failed_ = true;
    throw McapError(path_ + ": cannot be brought to the disk: " + std::strerror(errno));
  }
  if (name_synced_) return;
  name_synced_ = true;
  const size_t slash = path_.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "." : path_.substr(0, slash + 1);
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

void Writer::append_to_file(const Buffer& bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t part = ::write(file_.descriptor(), bytes.data() + done, bytes.size() - done);
    if (part < 0 && errno == EINTR) continue;
    if (part <= 0) fail(part < 0 ? errno : ENOSPC);
    done += static_cast<size_t>(part);
  }
  data_crc_ = update_crc(data_crc_, bytes.data(), bytes.size());
  file_size_ += bytes.size();
}

void Writer::fail(int error_number) {
  failed_ = true;
  // Half a record at the end would do no harm to our reader; other readers like it less.
  const bool cut = ::ftruncate(file_.descriptor(), static_cast<off_t>(file_size_)) == 0 &&
                   ::lseek(file_.descriptor(), static_cast<off_t>(file_size_), SEEK_SET) >= 0;
  throw McapError(path_ + ": cannot be written beyond byte " + std::to_string(file_size_) + ": " +
                  std::strerror(error_number) + (cut ? "" : "; its end could not be trimmed either"));
}

void Writer::close() {
  if (closed_) return;
  closed_ = true;
  try {
    if (!failed_) write_chunk();
    // After a failure the index may still fit into the space that the trimmed chunk gave back; if not, the file is
    // readable without it.
    if (file_size_ > 0) write_summary();
    if (durable_ && !failed_) sync();
  } catch (const std::exception&) {
    const ClaimedFile closed(std::move(file_));  // without a word: the first error is the one to tell
    throw;
  }
  // Some file systems (network, quota) report a full disk only here.
  file_.close();
}

void Writer::put_statistics(Buffer* out) const {
  const size_t begin = out->begin_record(Opcode::kStatistics);
  out->put(std::accumulate(message_counts_.begin(), message_counts_.end(), uint64_t{0}));
  out->put(static_cast<uint16_t>(schemas_.size()));
  out->put(static_cast<uint32_t>(channels_.size()));
  out->put(static_cast<uint32_t>(attachments_.size()));
  out->put(uint32_t{0});  // metadata
  out->put(static_cast<uint32_t>(chunks_.size()));
  out->put(log_start_);
  out->put(log_end_);
  out->put(static_cast<uint32_t>(channels_.size() * 10));
  for (size_t channel = 0; channel < channels_.size(); ++channel) {
    out->put(static_cast<uint16_t>(channel));
    out->put(message_counts_[channel]);
  }
  out->end_record(begin);
}

void Writer::put_attachment_index(const AttachmentIndex& index, Buffer* out) const {
  const size_t begin = out->begin_record(Opcode::kAttachmentIndex);
  out->put(index.offset);
  out->put(index.length);
  out->put(uint64_t{0});  // log time
  out->put(uint64_t{0});  // create time
  out->put(index.size);
  out->put_string(index.name);
  out->put_string(index.media_type);
  out->end_record(begin);
}

void Writer::put_chunk_index(const ChunkIndex& index, Buffer* out) const {
  const size_t begin = out->begin_record(Opcode::kChunkIndex);
  out->put(index.start_time);
  out->put(index.end_time);
  out->put(index.offset);
  out->put(index.length);
  out->put(static_cast<uint32_t>(index.message_index_offsets.size() * 10));
  for (const auto& [channel, offset] : index.message_index_offsets) {
    out->put(channel);
    out->put(offset);
  }
  out->put(index.message_index_length);
  out->put_string(get_compression_word(compression_));
  out->put(index.compressed_size);
  out->put(index.uncompressed_size);
  out->end_record(begin);
}

void Writer::write_summary() {
  Buffer end;
  const size_t data_end = end.begin_record(Opcode::kDataEnd);
  end.put(data_crc_);
  end.end_record(data_end);

  const size_t summary_begin = end.size();
  const uint64_t summary_start = file_size_ + summary_begin;
  Buffer offsets;
  const auto put_group = [&](Opcode opcode, auto put_records) {
    const size_t group_begin = end.size();
    put_records();
    if (end.size() == group_begin) return;
    const size_t begin = offsets.begin_record(Opcode::kSummaryOffset);
    offsets.put(static_cast<uint8_t>(opcode));
    offsets.put(static_cast<uint64_t>(file_size_ + group_begin));
    offsets.put(static_cast<uint64_t>(end.size() - group_begin));
    offsets.end_record(begin);
  };
  put_group(Opcode::kSchema, [&] {
    for (const Schema& schema : schemas_) put_schema(schema, &end);
  });
  put_group(Opcode::kChannel, [&] {
    for (const Channel& channel : channels_) put_channel(channel, &end);
  });
  put_group(Opcode::kStatistics, [&] { put_statistics(&end); });
  put_group(Opcode::kChunkIndex, [&] {
    for (const ChunkIndex& index : chunks_) put_chunk_index(index, &end);
  });
  put_group(Opcode::kAttachmentIndex, [&] {
    for (const AttachmentIndex& index : attachments_) put_attachment_index(index, &end);
  });
  const uint64_t offset_start = file_size_ + end.size();
  end.put_bytes(offsets.data(), offsets.size());

  const size_t footer = end.begin_record(Opcode::kFooter);
  end.put(summary_start);
  end.put(offset_start);
  end.put(uint32_t{0});
  end.end_record(footer);
  // The checksum covers the summary and the footer up to, and not with, the checksum itself.
  end.set(end.size() - 4, update_crc(0, end.data() + summary_begin, end.size() - 4 - summary_begin));
  end.put_bytes(kMagic.data(), kMagic.size());
  append_to_file(end);
}

}  // namespace hrp::mcap
