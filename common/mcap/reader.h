// SPDX-License-Identifier: BSD-3-Clause
// Reads MCAP files, whole ones by their index, damaged ones by a scan that gives everything up to the damage.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/mcap/format.h"

namespace hrp::mcap {

// Never trusts a length or an offset of the file; whatever the bytes are, it ends with messages, damage(), or
// McapError.
class Reader {
 public:
  // Throws McapError when there is no such file or it does not begin as an MCAP file does.
  explicit Reader(const std::string& path);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  const std::string& path() const { return path_; }
  uint64_t file_size() const { return file_size_; }
  size_t chunk_count() const { return chunks_.size(); }
  // By id, in the order of their ids.
  const std::map<uint16_t, Schema>& schemas() const { return schemas_; }
  const std::map<uint16_t, Channel>& channels() const { return channels_; }
  // The channel of a topic, nullptr when there is none.
  const Channel* find_channel(const std::string& topic) const;
  // True when the file was closed properly, and its index was used.
  bool indexed() const { return indexed_; }
  // What is wrong with the file and at which offset; empty while nothing is known to be wrong. Damage inside of
  // chunks is found when they are read.
  const std::string& damage() const { return damage_; }

  // Every message in the order of the file, or those of some topics. `visit` returns false to stop early. Stops at
  // damage, having visited everything before it. Returns the number of messages visited.
  using Visit = std::function<bool(const Message&)>;
  uint64_t read_messages(const Visit& visit, const std::set<std::string>& topics = {});
  // The messages of one chunk (Message::chunk), for those who noted where something stands.
  uint64_t read_chunk(size_t chunk, const Visit& visit);

 private:
  struct Chunk {
    uint64_t offset = 0;          // of the record's head
    uint64_t length = 0;          // with the head; what is there of it when cut short
    std::set<uint16_t> channels;  // from the index; empty = unknown
  };
  struct Record {
    Opcode opcode;
    uint64_t offset, length;  // of the head; length with the head
  };

  bool read_at(uint64_t offset, uint64_t size, std::vector<uint8_t>* bytes) const;
  bool read_summary();
  bool take_summary_record(Opcode opcode, Cursor cursor);
  bool take_chunk_index(Cursor cursor);
  void scan();
  bool scan_record(const Record& record);
  void find_definitions();
  bool take_definition(Opcode opcode, Cursor cursor);
  // False when the walk is over: damage, or `visit` asked for the end.
  bool read_chunk(const Chunk& chunk, const Visit& visit, const std::set<uint16_t>* wanted, uint64_t* count);
  bool read_records(Cursor cursor, const Chunk& chunk, const Visit& visit, const std::set<uint16_t>* wanted,
                    uint64_t* count);
  bool find_damage(uint64_t offset, const std::string& what);

  std::string path_;
  int file_ = -1;
  uint64_t file_size_ = 0;
  bool indexed_ = false;
  std::string damage_;
  std::map<uint16_t, Schema> schemas_;
  std::map<uint16_t, Channel> channels_;
  std::vector<Chunk> chunks_;  // chunks, and single messages outside of chunks
  std::vector<uint8_t> packed_, plain_;
};

}  // namespace hrp::mcap
