// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/background_writer.h"

#include <pthread.h>

#include <csignal>
#include <exception>
#include <new>
#include <system_error>

namespace hrp::mcap {
namespace {

// Where memory runs out, that is said, and needs none.
std::string describe(const std::exception& error, const std::string& path) noexcept {
  try {
    if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return path + ": memory ran out";
    return error.what();
  } catch (const std::bad_alloc&) {
    return "out of memory";  // short enough to be held in the string itself
  }
}

}  // namespace

BackgroundWriter::BackgroundWriter(std::unique_ptr<Writer> writer)
    : writer_(std::move(writer)), channel_count_(writer_->channel_count()) {
  // Signals belong to the other threads of the program. SIGXFSZ, which comes to the thread that writes beyond a limit
  // of the file's size, would kill the process; blocked, the write fails with EFBIG instead, like any other.
  free_.reserve(kMaxWaiting + 2);  // all there are: the thread gives them back and must not fail
  sigset_t all, old;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &old);
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    pthread_sigmask(SIG_SETMASK, &old, nullptr);
    throw McapError(writer_->path() + ": no thread can be had to write it: " + error.what());
  }
  pthread_sigmask(SIG_SETMASK, &old, nullptr);
}

BackgroundWriter::~BackgroundWriter() {
  try {
    close();
  } catch (const std::exception&) {
    // Said to whoever called close(); a destructor has nobody to tell.
  }
}

uint16_t BackgroundWriter::add_channel(const std::string& topic, const std::string& type_name,
                                       const std::string& schema_text) {
  open_.channels.push_back({topic, type_name, schema_text});
  return channel_count_++;
}

void BackgroundWriter::add_message(const Message& message) {
  open_.messages.push_back(message);
  try {
    open_.bytes.insert(open_.bytes.end(), message.data, message.data + message.size);
  } catch (const std::bad_alloc&) {
    open_.messages.pop_back();
    throw;
  }
}

void BackgroundWriter::write_chunk() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.size() < kMaxWaiting || !error_.empty(); });
  if (!error_.empty()) {
    open_ = Batch();
    return;
  }
  waiting_.push_back(std::move(open_));
  open_ = Batch();
  if (!free_.empty()) {
    open_ = std::move(free_.back());
    free_.pop_back();
  }
  changed_.notify_all();
}

void BackgroundWriter::wait() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return (waiting_.empty() && !writing_) || !error_.empty(); });
}

void BackgroundWriter::close() {
  if (!thread_.joinable()) return;
  std::exception_ptr refused;
  try {
    if (!open_.messages.empty()) write_chunk();
  } catch (const std::bad_alloc&) {
    refused = std::current_exception();
  }
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }
  thread_.join();
  if (!error_.empty()) throw McapError(error_);
  if (refused) std::rethrow_exception(refused);
}

uint64_t BackgroundWriter::chunks_written() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return chunks_written_;
}

std::string BackgroundWriter::error() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return error_;
}

void BackgroundWriter::run() {
  std::string failure;
  try {
    writer_->write_chunk();  // what the file holds is told from the start: a kill leaves a log that can be opened
  } catch (const std::exception& error) {
    failure = describe(error, writer_->path());
  }
  std::unique_lock<std::mutex> lock(mutex_);
  while (failure.empty()) {
    changed_.wait(lock, [this] { return !waiting_.empty() || ending_; });
    if (waiting_.empty()) break;
    Batch batch = std::move(waiting_.front());
    waiting_.pop_front();
    writing_ = true;
    lock.unlock();
    try {
      write(batch);
    } catch (const std::exception& error) {
      failure = describe(error, writer_->path());
    }
    batch.channels.clear();
    batch.messages.clear();
    batch.bytes.clear();
    lock.lock();
    writing_ = false;
    if (failure.empty()) ++chunks_written_;
    free_.push_back(std::move(batch));
    changed_.notify_all();
  }
  lock.unlock();
  try {
    writer_->close();
  } catch (const std::exception& error) {
    if (failure.empty()) failure = describe(error, writer_->path());
  }
  lock.lock();
  // Said when the file is closed: whoever hears of the failure may read it.
  error_ = std::move(failure);
  changed_.notify_all();
}

void BackgroundWriter::write(const Batch& batch) {
  for (const NewChannel& channel : batch.channels) {
    writer_->add_channel(channel.topic, writer_->add_schema(channel.type_name, "omgidl", channel.schema_text), "cdr");
  }
  const uint8_t* data = batch.bytes.data();
  for (Message message : batch.messages) {
    message.data = data;
    data += message.size;
    writer_->add_message(message);
  }
  writer_->write_chunk();
}

}  // namespace hrp::mcap
