// SPDX-License-Identifier: BSD-3-Clause
// Bags as rosbag2 writes them, for tests: metadata.yaml, MCAP or sqlite3, messages in plain CDR. It shares nothing with
// the reader but the container MCAP.
#pragma once

#include <sqlite3.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/mcap/compression.h"
#include "common/mcap/writer.h"

namespace hrp::testing_bags {

// Plain CDR, little endian: every number aligned to its size, counted from behind the header of four bytes.
class CdrWriter {
 public:
  template <typename Number>
  CdrWriter& put(Number value) {
    while ((bytes_.size() - 4) % sizeof value != 0) bytes_.push_back(0);
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof value);
    return *this;
  }
  CdrWriter& put(const std::string& text) {
    put(static_cast<uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
    return *this;
  }
  CdrWriter& put(const std::vector<double>& list) {
    put(static_cast<uint32_t>(list.size()));
    for (double x : list) put(x);
    return *this;
  }
  CdrWriter& put(const std::vector<std::string>& list) {
    put(static_cast<uint32_t>(list.size()));
    for (const std::string& x : list) put(x);
    return *this;
  }
  CdrWriter& header(int64_t stamp_ns) {
    return put(static_cast<int32_t>(stamp_ns / 1000000000))
        .put(static_cast<uint32_t>(stamp_ns % 1000000000))
        .put(std::string("base"));
  }
  CdrWriter& zeros(int count) {
    for (int i = 0; i < count; ++i) put(0.0);
    return *this;
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_{0, 1, 0, 0};
};

struct Message {
  std::string topic;
  int64_t received = 0;  // [ns]
  std::vector<uint8_t> bytes;
};

struct Topic {
  std::string name, type, definition;
};

enum class Storage { kMcap, kMcapLz4, kMcapPlain, kSqlite, kSqliteFileZstd, kSqliteMessageZstd };

constexpr const char* kJointStateDefinition =
    "# comment\nstd_msgs/Header header\n\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    "================================================================================\nMSG: std_msgs/Header\n"
    "builtin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\nMSG: builtin_interfaces/Time\n"
    "int32 sec\nuint32 nanosec\n";

inline std::vector<uint8_t> make_joint_state(int64_t stamp, const std::vector<std::string>& names,
                                             const std::vector<double>& position, const std::vector<double>& velocity,
                                             const std::vector<double>& effort) {
  return CdrWriter().header(stamp).put(names).put(position).put(velocity).put(effort).bytes();
}

inline void write_mcap(const std::string& path, mcap::Compression compression, const std::vector<Topic>& topics,
                       const std::vector<Message>& messages) {
  mcap::Writer writer(path, compression);
  std::vector<uint16_t> ids;
  for (const Topic& t : topics)
    ids.push_back(writer.add_channel(t.name, writer.add_schema(t.type, "ros2msg", t.definition), "cdr"));
  for (const Message& m : messages) {
    for (size_t i = 0; i < topics.size(); ++i) {
      if (topics[i].name != m.topic) continue;
      mcap::Message out;
      out.channel_id = ids[i];
      out.log_time = out.publish_time = static_cast<uint64_t>(m.received);
      out.data = m.bytes.data();
      out.size = m.bytes.size();
      writer.add_message(out);
    }
  }
  writer.close();
}

inline std::vector<uint8_t> pack(const uint8_t* data, size_t size) {
  mcap::Buffer out;
  mcap::Compressor(mcap::Compression::kZstd).append(data, size, &out);
  return {out.data(), out.data() + out.size()};
}

inline void write_sqlite(const std::string& path, bool pack_messages, const std::vector<Topic>& topics,
                         const std::vector<Message>& messages) {
  sqlite3* db = nullptr;
  sqlite3_open(path.c_str(), &db);
  sqlite3_exec(
      db,
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT NULL); BEGIN;",
      nullptr, nullptr, nullptr);
  for (size_t i = 0; i < topics.size(); ++i)
    sqlite3_exec(db,
                 ("INSERT INTO topics VALUES(" + std::to_string(i + 1) + ",'" + topics[i].name + "','" +
                  topics[i].type + "','cdr','')")
                     .c_str(),
                 nullptr, nullptr, nullptr);
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &insert, nullptr);
  for (const Message& m : messages) {
    for (size_t i = 0; i < topics.size(); ++i) {
      if (topics[i].name != m.topic) continue;
      const std::vector<uint8_t> bytes = pack_messages ? pack(m.bytes.data(), m.bytes.size()) : m.bytes;
      sqlite3_bind_int64(insert, 1, static_cast<int64_t>(i) + 1);
      sqlite3_bind_int64(insert, 2, m.received);
      sqlite3_bind_blob(insert, 3, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
      sqlite3_step(insert);
      sqlite3_reset(insert);
    }
  }
  sqlite3_finalize(insert);
  sqlite3_exec(db, "COMMIT", nullptr, nullptr, nullptr);
  sqlite3_close(db);
}

// The folder of a bag, made anew.
inline void write_bag(const std::filesystem::path& folder, Storage storage, const std::vector<Topic>& topics,
                      const std::vector<Message>& messages) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const bool sqlite =
      storage == Storage::kSqlite || storage == Storage::kSqliteFileZstd || storage == Storage::kSqliteMessageZstd;
  std::string file = sqlite ? "bag_0.db3" : "bag_0.mcap";
  const std::string path = (folder / file).string();
  if (sqlite)
    write_sqlite(path, storage == Storage::kSqliteMessageZstd, topics, messages);
  else
    write_mcap(path,
               storage == Storage::kMcap      ? mcap::Compression::kZstd
               : storage == Storage::kMcapLz4 ? mcap::Compression::kLz4
                                              : mcap::Compression::kNone,
               topics, messages);
  if (storage == Storage::kSqliteFileZstd) {
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> plain((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const std::vector<uint8_t> packed = pack(reinterpret_cast<const uint8_t*>(plain.data()), plain.size());
    std::filesystem::remove(path);
    file += ".zstd";
    std::ofstream(folder / file, std::ios::binary)
        .write(reinterpret_cast<const char*>(packed.data()), static_cast<long>(packed.size()));
  }
  const bool by_message = storage == Storage::kSqliteMessageZstd, by_file = storage == Storage::kSqliteFileZstd;
  std::ofstream(folder / "metadata.yaml")
      << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: " << (sqlite ? "sqlite3" : "mcap")
      << "\n  relative_file_paths:\n    - " << file << "\n  compression_format: \""
      << (by_message || by_file ? "zstd" : "") << "\"\n  compression_mode: \""
      << (by_message ? "MESSAGE"
          : by_file  ? "FILE"
                     : "")
      << "\"\n";
}

}  // namespace hrp::testing_bags
