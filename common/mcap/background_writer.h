// SPDX-License-Identifier: BSD-3-Clause
// A Writer that compresses, checks and writes on a thread of its own, so that the thread that takes the samples only
// copies them. The file is the same, byte for byte.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/mcap/writer.h"

namespace hrp::mcap {

// Memory is bounded: when kMaxWaiting chunks wait for the disk, write_chunk() waits, too. A chunk counts as written
// when the operating system has it (it survives a kill of this process), or of a durable writer when the disk has it;
// not before.
class BackgroundWriter {
 public:
  // Schemas and channels as with `writer`, before it comes here.
  explicit BackgroundWriter(std::unique_ptr<Writer> writer);
  // Writes what waits and closes, without a word about errors.
  ~BackgroundWriter();

  // One channel more, of its own type, from the open chunk on. Returns its id.
  uint16_t add_channel(const std::string& topic, const std::string& type_name, const std::string& schema_text);
  // Takes a copy into the open chunk.
  void add_message(const Message& message);
  // Ends the open chunk and hands it to the thread.
  void write_chunk();
  // Waits until every chunk handed over is written, or writing has failed.
  void wait();
  // Writes the rest, the index and the footer. Throws McapError when anything of the file could not be written.
  void close();

  // Chunks on disk. Does not grow any more once error() says something.
  uint64_t chunks_written() const;
  // Why writing failed; empty when it has not. The file has then been closed as far as the disk allows.
  std::string error() const;

 private:
  static constexpr size_t kMaxWaiting = 8;

  struct NewChannel {
    std::string topic, type_name, schema_text;
  };
  struct Batch {
    std::vector<NewChannel> channels;
    std::vector<Message> messages;  // `data` is set by the thread
    std::vector<uint8_t> bytes;     // one after the other
  };

  void run();
  void write(const Batch& batch);

  std::unique_ptr<Writer> writer_;  // the thread's, until it has ended
  uint16_t channel_count_;
  Batch open_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Batch> waiting_;
  std::vector<Batch> free_;  // their memory is used again
  bool writing_ = false;
  bool ending_ = false;
  uint64_t chunks_written_ = 0;
  std::string error_;
  std::thread thread_;
};

}  // namespace hrp::mcap
