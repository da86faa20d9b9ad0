// SPDX-License-Identifier: BSD-3-Clause
#include "servers/logger/log_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "common/base/check.h"

namespace hrp {
namespace {

constexpr uint32_t kEventSources = 1u << 1 | 1u << 2;

struct SampleHeader {
  uint64_t epoch = 0;
  uint64_t step = 0;
  double time = 0.0;  // [s]
};

// msg::Header is the first field: after the encapsulation (2 bytes scheme, 2 bytes options) epoch, step, time.
SampleHeader read_header(const uint8_t* data, size_t size) {
  constexpr size_t kEncapsulation = 4;
  if (size < kEncapsulation + 24 || data[0] != 0 || data[1] > 1) {
    throw std::invalid_argument("a sample of " + std::to_string(size) + " bytes is no plain CDR with a header");
  }
  const bool little_endian = data[1] == 1;
  const auto read_word = [&](size_t offset) {
    uint64_t word = 0;
    std::memcpy(&word, data + offset, sizeof word);
    return little_endian ? word : __builtin_bswap64(word);
  };
  SampleHeader header;
  header.epoch = read_word(kEncapsulation);
  header.step = read_word(kEncapsulation + 8);
  const uint64_t time_bits = read_word(kEncapsulation + 16);
  std::memcpy(&header.time, &time_bits, sizeof header.time);
  if (!std::isfinite(header.time) || header.time < 0) throw std::invalid_argument("a sample's time is no time");
  return header;
}

std::string make_file_name(const std::string& path, size_t number) {
  if (number == 0) return path;
  std::filesystem::path file(path);
  return file.replace_extension(std::to_string(number) + file.extension().string()).string();
}

}  // namespace

LogWriter::LogWriter(const LogOptions& options)
    : options_(options), claim_(std::in_place, options.path, options.existing), slots_(kSlots) {
  HRP_CHECK(options.topics.size() >= 2 && options.topics.size() <= kMaxTopics, options.topics.size() << " topics");
  HRP_CHECK(options.topics[0].rate == LogTopic::Rate::kOnce, options.topics[0].name);
  HRP_CHECK(options.chunk_steps > 0, options.chunk_steps);
  // Channels are numbered as the topics, so one without a channel is the last.
  for (size_t i = 0; i + 1 < options.topics.size(); ++i)
    HRP_CHECK(options.topics[i].rate != LogTopic::Rate::kWhenDue, options.topics[i].name);
}

void LogWriter::set_description(const uint8_t* data, size_t size, int control_period, mcap::Compression compression) {
  HRP_CHECK(control_period > 0, control_period);
  description_.assign(data, data + size);
  control_period_ = control_period;
  compression_ = compression;
  if (claim_) open_file();
  write_complete_steps();
}

void LogWriter::set_events(FindEvents find_events) { find_events_ = std::move(find_events); }

void LogWriter::set_parcels(IsDue is_due, Unpack unpack) {
  is_due_ = std::move(is_due);
  unpack_ = std::move(unpack);
}

uint32_t LogWriter::find_expected(uint64_t step, bool with_answers) const {
  const bool control_step = step % static_cast<uint64_t>(control_period_) == 0;
  uint32_t expected = 0;
  for (size_t i = 1; i < options_.topics.size(); ++i) {
    const LogTopic& topic = options_.topics[i];
    if (topic.rate == LogTopic::Rate::kEveryControlStep && !control_step) continue;
    if (topic.rate == LogTopic::Rate::kWhenDue && !(is_due_ && is_due_(step))) continue;
    if (topic.answers_state && !with_answers) continue;
    expected |= 1u << i;
  }
  return expected;
}

bool LogWriter::is_complete(uint64_t step) const {
  return (find_expected(step, true) & ~slot(step).present & ~silent_) == 0;
}

void LogWriter::take(size_t topic, const uint8_t* data, size_t size) {
  HRP_CHECK(topic >= 1 && topic < options_.topics.size(), "topic " << topic);
  if (closed_) return;
  const SampleHeader header = read_header(data, size);
  if (!any_epoch_ || header.epoch > epoch_) start_epoch(header.epoch);
  silent_ &= ~(1u << topic);
  if (header.epoch < epoch_ || header.step < next_step_) return;
  if (topic == kStateTopic && !any_state_) take_state(header.step);
  if (header.step >= next_step_ + kSlots) {
    if (!any_state_) return;  // a logger that joins hears others before the state: this lies before its log
    throw std::invalid_argument(options_.topics[topic].name + " of step " + std::to_string(header.step) +
                                " came while step " + std::to_string(next_step_) + " is not complete");
  }
  Slot& place = slot(header.step);
  if (place.present & (1u << topic)) return;
  place.present |= 1u << topic;
  place.time = header.time;
  if (place.samples[topic].capacity() == 0 && !spare_[topic].empty()) {
    place.samples[topic] = std::move(spare_[topic].back());
    spare_[topic].pop_back();
  }
  place.samples[topic].assign(data, data + size);
  ++sample_count_;
  if (topic == kStateTopic) take_state(header.step);
  if (header.step == next_step_ || topic == kStateTopic || is_joining()) write_complete_steps();
}

void LogWriter::take_state(uint64_t step) {
  if (!any_state_) {
    // A logger that joins a running simulation begins where it joined.
    for (; next_step_ < step; ++next_step_) slot(next_step_).present = 0;
    newest_state_ = step;
    any_state_ = true;
    joined_ = step > 0;
  }
  newest_state_ = std::max(newest_state_, step);
}

void LogWriter::start_epoch(uint64_t epoch) {
  if (any_epoch_) finish_epoch();
  any_epoch_ = true;
  epoch_ = epoch;
  next_step_ = newest_state_ = step_on_disk_ = 0;
  any_state_ = any_on_disk_ = first_step_seen_ = joined_ = false;
  silent_ = 0;
  for (Slot& place : slots_) place.present = 0;
}

mcap::ClaimedFile LogWriter::claim_next_file() const {
  size_t number = files_.size();
  const auto is_taken = [](const std::string& name) { return mcap::holds_something(name); };
  while (options_.existing == mcap::Existing::kRefuse && is_taken(make_file_name(options_.path, number))) ++number;
  return mcap::ClaimedFile(make_file_name(options_.path, number), options_.existing);
}

void LogWriter::open_file() {
  mcap::ClaimedFile claim = claim_ ? std::move(*claim_) : claim_next_file();
  claim_.reset();
  files_.push_back(claim.path());
  late_channels_.clear();
  auto file = std::make_unique<mcap::Writer>(std::move(claim), compression_);
  file->set_durable(options_.durable);
  for (const LogTopic& topic : options_.topics) {
    if (topic.rate == LogTopic::Rate::kWhenDue) continue;
    file->add_channel(topic.name, file->add_schema(topic.type_name, "omgidl", topic.schema_text), "cdr");
  }
  writer_ = std::make_unique<mcap::BackgroundWriter>(std::move(file));
  chunk_ends_.clear();
  chunks_seen_ = 0;
  write_sample(0, 0, 0.0, description_);
}

void LogWriter::write_complete_steps() {
  if (description_.empty() || closed_) return;
  if (is_joining()) drop_unfinished_steps();
  if (any_state_ && is_complete(next_step_)) first_step_seen_ = true;
  // A step whose state has a successor had its answers used; the newest one waits to see whether it is the last.
  while (any_state_ && next_step_ < newest_state_ && is_complete(next_step_)) write_step(true);
}

// Parts of the first steps were sent before a logger joined, and never come: its log begins with a step that is whole.
void LogWriter::drop_unfinished_steps() {
  uint64_t whole = next_step_;
  while (whole < newest_state_ && !is_complete(whole)) ++whole;
  if (whole == newest_state_) return;
  for (; next_step_ < whole; ++next_step_) slot(next_step_).present = 0;
}

void LogWriter::write_step(bool with_answers) {
  const uint64_t step = next_step_;
  Slot& place = slot(step);
  const uint32_t wanted = place.present & find_expected(step, with_answers);
  try {
    if (!writer_) open_file();
  } catch (const mcap::McapError&) {
    closed_ = true;
    throw;
  }
  for (size_t i = 1; i < options_.topics.size(); ++i) {
    if (!(wanted & (1u << i))) continue;
    if (options_.topics[i].rate == LogTopic::Rate::kWhenDue) {
      write_parts(step, place.time, unpack_(place.samples[i]));
      std::vector<uint8_t>().swap(place.samples[i]);  // a picture in each slot would be gigabytes
    } else {
      write_sample(static_cast<uint16_t>(i), step, place.time, place.samples[i]);
    }
  }
  if (find_events_ && (wanted & kEventSources) == kEventSources)
    write_parts(step, place.time, find_events_(place.samples[1], place.samples[2]));
  for (size_t i = 1; i < options_.topics.size(); ++i) keep_memory(i, &place.samples[i]);
  place.present = 0;
  ++next_step_;
  if (next_step_ % static_cast<uint64_t>(options_.chunk_steps) != 0) return;
  writer_->write_chunk();
  chunk_ends_.push_back(step);
  poll();
}

void LogWriter::keep_memory(size_t topic, std::vector<uint8_t>* sample) {
  if (sample->capacity() == 0) return;
  spare_[topic].push_back(std::move(*sample));
  *sample = {};
}

void LogWriter::write_parts(uint64_t step, double time, const std::vector<Part>& parts) {
  for (const Part& part : parts) write_sample(find_channel(part.topic), step, time, part.sample);
}

uint16_t LogWriter::find_channel(const LogTopic& topic) {
  const auto found = late_channels_.find(topic.name);
  if (found != late_channels_.end()) return found->second;
  return late_channels_[topic.name] = writer_->add_channel(topic.name, topic.type_name, topic.schema_text);
}

void LogWriter::note_chunks_on_disk() {
  for (const uint64_t written = writer_->chunks_written(); chunks_seen_ < written; ++chunks_seen_) {
    if (chunk_ends_.empty()) return;  // the last chunk of a file that is being closed
    step_on_disk_ = chunk_ends_.front();
    any_on_disk_ = true;
    chunk_ends_.pop_front();
  }
}

void LogWriter::poll() {
  if (!writer_) return;
  const std::string error = writer_->error();  // first: what is on disk does not grow after an error
  note_chunks_on_disk();
  if (error.empty()) return;
  closed_ = true;
  writer_.reset();
  throw mcap::McapError(error);
}

void LogWriter::wait_for_disk() {
  if (writer_) writer_->wait();
  poll();
}

void LogWriter::write_sample(uint16_t channel, uint64_t step, double time, const std::vector<uint8_t>& sample) {
  const auto nanoseconds = static_cast<uint64_t>(std::llround(time * 1e9));
  writer_->add_message({channel, static_cast<uint32_t>(step), nanoseconds, nanoseconds, sample.data(), sample.size()});
}

bool LogWriter::is_complete_through(uint64_t last) const {
  return any_state_ && newest_state_ >= last && next_step_ == newest_state_ &&
         (find_expected(newest_state_, false) & ~slot(newest_state_).present) == 0;
}

std::vector<std::string> LogWriter::find_missing() const {
  std::vector<std::string> names;
  if (!has_description()) return {options_.topics[0].name};
  const uint32_t missing = find_expected(next_step_, true) & ~slot(next_step_).present & ~silent_;
  for (size_t i = 1; i < options_.topics.size(); ++i) {
    if (missing & (1u << i)) names.push_back(options_.topics[i].name);
  }
  return names;
}

std::vector<std::string> LogWriter::give_up_waiting() {
  if (!has_description()) return {};
  std::vector<std::string> names = find_missing();
  silent_ |= find_expected(next_step_, true) & ~slot(next_step_).present;
  write_complete_steps();
  return names;
}

void LogWriter::finish_epoch() {
  if (any_state_ && has_description() && !closed_) {
    for (; next_step_ < newest_state_;) write_step(true);
    if (next_step_ == newest_state_) write_step(false);
  }
  if (!writer_) return;
  try {
    writer_->close();
  } catch (const mcap::McapError&) {
    note_chunks_on_disk();
    closed_ = true;
    writer_.reset();
    throw;
  }
  step_on_disk_ = newest_state_;
  any_on_disk_ = any_state_;
  writer_.reset();
}

void LogWriter::close() {
  if (closed_) return;
  finish_epoch();
  closed_ = true;
}

}  // namespace hrp
