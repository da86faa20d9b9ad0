// SPDX-License-Identifier: BSD-3-Clause
// Puts the samples of a run into files in an order that depends on the run alone, not on the order of their arrival.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/mcap/background_writer.h"

namespace hrp {

// A topic as it is written to the log.
struct LogTopic {
  // kWhenDue: at the steps that set_parcels() says; its samples are taken apart before they are written.
  enum class Rate { kOnce, kEveryStep, kEveryControlStep, kWhenDue };
  std::string name;         // "hrp/robot_state"
  std::string type_name;    // "hrp::msg::RobotState"
  std::string schema_text;  // self-contained IDL
  Rate rate = Rate::kEveryStep;
  bool answers_state = false;  // an answer to the state of its step, which only the next step uses
};

struct LogOptions {
  std::string path;  // "run.mcap"; later epochs go to "run.1.mcap", "run.2.mcap", ...
  // kRefuse: a path that holds something is refused, and later epochs take the next number that is free.
  mcap::Existing existing = mcap::Existing::kRefuse;
  // In the order in which they stand in the file within a step. The first one is kOnce, the second one the state,
  // which says how far the run has come.
  std::vector<LogTopic> topics;
  int chunk_steps = 32;  // steps a chunk
  bool durable = false;  // a chunk counts as on disk when a power cut does not lose it
};

// Steps are written when they are complete, in order; a chunk is closed after every chunk_steps steps, so that equal
// runs give equal files. The very last step holds what dynamics published, without answers to it: nobody used them,
// and whether they still arrive is a matter of luck. Chunks are compressed and written by a thread of their own. Write
// errors throw mcap::McapError from the next call after the file has been closed as far as the disk allows.
class LogWriter {
 public:
  // Claims the file. Throws mcap::McapError.
  explicit LogWriter(const LogOptions& options);

  // The sample of the kOnce topic (the robot description): begins every file, so nothing is written before it. Topics
  // and types are on disk from then on.
  void set_description(const uint8_t* data, size_t size, int control_period, mcap::Compression compression);
  // An encoded sample with its topic, whose channel is made with its first sample: logs without any have none.
  struct Part {
    LogTopic topic;
    std::vector<uint8_t> sample;
  };
  // What else to write with a step, from its samples of topics[1] and topics[2].
  using FindEvents = std::function<std::vector<Part>(const std::vector<uint8_t>&, const std::vector<uint8_t>&)>;
  void set_events(FindEvents find_events);
  // The topic of rate kWhenDue, the last one, comes at these steps. It has no channel: `unpack` finds the parts of a
  // sample. Without this call it never comes.
  using IsDue = std::function<bool(uint64_t step)>;
  using Unpack = std::function<std::vector<Part>(const std::vector<uint8_t>& sample)>;
  void set_parcels(IsDue is_due, Unpack unpack);
  // An encoded sample of topics[topic] whose first field is a msg::Header. Repeats and samples of old epochs are
  // dropped, and so is what came before the first whole step of a run that was under way. Throws mcap::McapError when
  // writing fails, std::invalid_argument when the bytes hold no header.
  void take(size_t topic, const uint8_t* data, size_t size);
  // Looks how far the disk is. Call it now and then.
  void poll();
  // Waits until every chunk that has ended is on disk.
  void wait_for_disk();
  // No step after the newest state will come in this epoch: writes the rest and ends this epoch's file.
  void finish_epoch();
  // The same, for good: nothing is taken any more.
  void close();

  bool has_description() const { return !description_.empty(); }
  // The first step of this epoch has come on every topic.
  bool has_first_step() const { return first_step_seen_; }
  uint64_t epoch() const { return epoch_; }
  // Last step that was on disk at the last look; meaningful when any_on_disk().
  uint64_t step_on_disk() const { return step_on_disk_; }
  bool any_on_disk() const { return any_on_disk_; }
  // Samples taken and not dropped, all epochs.
  uint64_t sample_count() const { return sample_count_; }
  // The oldest step that is not written.
  uint64_t next_step() const { return next_step_; }
  // The newest step whose state has come.
  uint64_t newest_step() const { return newest_state_; }
  // Steps that are known to be over and not written yet.
  uint64_t backlog() const { return newest_state_ > next_step_ ? newest_state_ - next_step_ : 0; }
  // Everything through the newest state that close() would want has come, and that is at least step `last`.
  bool is_complete_through(uint64_t last) const;
  // The names of the topics that the oldest unwritten step misses.
  std::vector<std::string> find_missing() const;
  // Stop waiting for the topics that are missing until they speak again; returns their names.
  std::vector<std::string> give_up_waiting();
  // Where the run is written; empty before its first file.
  const std::vector<std::string>& files() const { return files_; }

 private:
  static constexpr size_t kMaxTopics = 32;  // bits of Slot::present
  static constexpr size_t kStateTopic = 1;
  static constexpr uint64_t kSlots = 2048;  // more than the scheduler grants beyond the log

  // Samples of one step that waits to be complete.
  struct Slot {
    std::array<std::vector<uint8_t>, kMaxTopics> samples;
    uint32_t present = 0;  // bit per topic
    double time = 0.0;     // [s]
  };

  uint32_t find_expected(uint64_t step, bool with_answers) const;
  bool is_complete(uint64_t step) const;
  void take_state(uint64_t step);
  void start_epoch(uint64_t epoch);
  void open_file();
  mcap::ClaimedFile claim_next_file() const;
  bool is_joining() const { return joined_ && !first_step_seen_; }
  void drop_unfinished_steps();
  void write_complete_steps();
  void write_step(bool with_answers);
  void write_parts(uint64_t step, double time, const std::vector<Part>& parts);
  uint16_t find_channel(const LogTopic& topic);
  void note_chunks_on_disk();
  void write_sample(uint16_t channel, uint64_t step, double time, const std::vector<uint8_t>& sample);
  void keep_memory(size_t topic, std::vector<uint8_t>* sample);
  Slot& slot(uint64_t step) { return slots_[step % kSlots]; }
  const Slot& slot(uint64_t step) const { return slots_[step % kSlots]; }

  LogOptions options_;
  std::optional<mcap::ClaimedFile> claim_;  // of the first file, until it is written
  std::vector<uint8_t> description_;
  int control_period_ = 1;
  mcap::Compression compression_ = mcap::Compression::kZstd;
  FindEvents find_events_;
  IsDue is_due_;
  Unpack unpack_;
  std::map<std::string, uint16_t> late_channels_;  // of this file, by topic: those that are made with a first sample
  std::unique_ptr<mcap::BackgroundWriter> writer_;
  std::deque<uint64_t> chunk_ends_;  // last steps of the chunks that were not on disk at the last look
  uint64_t chunks_seen_ = 0;         // of this file, on disk at the last look
  std::vector<std::string> files_;
  std::vector<Slot> slots_;
  // By topic: memory of samples that are written, the last one first. A slot that had its own would come round once in
  // kSlots steps, when the processor's caches have forgotten it.
  std::array<std::vector<std::vector<uint8_t>>, kMaxTopics> spare_;
  bool any_epoch_ = false;
  bool closed_ = false;
  uint64_t epoch_ = 0;
  uint64_t next_step_ = 0;     // the oldest step that is not written
  uint64_t newest_state_ = 0;  // newest step of the state
  bool any_state_ = false;
  bool first_step_seen_ = false;
  bool joined_ = false;  // a run that was under way
  uint32_t silent_ = 0;  // topics that nobody waits for, bit per topic
  uint64_t step_on_disk_ = 0;
  bool any_on_disk_ = false;
  uint64_t sample_count_ = 0;
};

}  // namespace hrp
