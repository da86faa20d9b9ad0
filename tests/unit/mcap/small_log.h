// SPDX-License-Identifier: BSD-3-Clause
// A small log with known contents, for the tests of writer and reader.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/mcap/reader.h"
#include "common/mcap/writer.h"

namespace hrp::mcap {

// A file name in the temporary folder that is removed at the end of the test.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / ("hrp_" + std::to_string(::getpid()) + "_" + name)) {}
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_file(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline std::string make_payload(int step, int channel) {
  return "payload of step " + std::to_string(step) + ", channel " + std::to_string(channel) + std::string(40, 'x');
}

constexpr int kSmallLogSteps = 6, kSmallLogStepsPerChunk = 2;

// Two channels, six steps, two steps a chunk.
inline void write_small_log(const std::string& path, Compression compression) {
  Writer writer(path, compression);
  const uint16_t schema = writer.add_schema("pkg::Thing", "omgidl", "module pkg { struct Thing { long x; }; };");
  writer.add_channel("a", schema, "cdr");
  writer.add_channel("b", schema, "cdr");
  for (int step = 0; step < kSmallLogSteps; ++step) {
    for (int channel = 0; channel < 2; ++channel) {
      const std::string payload = make_payload(step, channel);
      const uint64_t time = 1000000ull * static_cast<uint64_t>(step);
      writer.add_message({static_cast<uint16_t>(channel), static_cast<uint32_t>(step), time, time,
                          reinterpret_cast<const uint8_t*>(payload.data()), payload.size()});
    }
    if (step % kSmallLogStepsPerChunk == kSmallLogStepsPerChunk - 1) writer.write_chunk();
  }
  writer.close();
}

inline std::vector<std::string> read_payloads(Reader* reader, const std::set<std::string>& topics = {}) {
  std::vector<std::string> payloads;
  reader->read_messages(
      [&](const Message& message) {
        payloads.emplace_back(reinterpret_cast<const char*>(message.data), message.size);
        return true;
      },
      topics);
  return payloads;
}

inline std::vector<std::string> make_all_payloads() {
  std::vector<std::string> payloads;
  for (int step = 0; step < kSmallLogSteps; ++step) {
    for (int channel = 0; channel < 2; ++channel) payloads.push_back(make_payload(step, channel));
  }
  return payloads;
}

}  // namespace hrp::mcap
