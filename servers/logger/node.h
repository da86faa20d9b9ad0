// SPDX-License-Identifier: BSD-3-Clause
// The logger on a bus: takes encoded samples as they are, tells the scheduler how far the disk is.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/node/node_base.h"
#include "common/robot/scenario.h"
#include "hrp_idl/model.h"
#include "hrp_idl/scheduling.h"
#include "hrp_idl/view.h"
#include "servers/logger/log_writer.h"
#include "servers/logger/translate.h"

namespace hrp {

struct LoggerOptions {
  std::string path = "run.mcap";
  std::string compression;               // none, lz4, zstd; empty: as the scenario says
  bool force = false;                    // overwrite a file that holds something
  std::vector<std::string> robots = {};  // the scenario's other robots, whose sensor data and commands are logged, too
  bool durable = false;                  // a step counts as logged when a power cut does not lose it
  // From topics::kLogSamples, which our dynamics server fills; topics themselves are read where nothing comes there.
  bool gathered = false;
};

class LoggerNode : public NodeBase {
 public:
  // Throws InputError when the file cannot be written.
  LoggerNode(const NodeContext& context, const LoggerOptions& options);
  ~LoggerNode() override;
  void make_endpoints() override;
  void drop_endpoints() override;
  std::string find_missing() const override;
  // Files written so far.
  const std::vector<std::string>& files() const { return log_.files(); }

 protected:
  void handle_idle(Clock::time_point now) override;
  bool is_drained() override;
  void handle_run_end() override;
  void handle_decode_error(const std::string& topic, const std::string& reason) override;

 private:
  void listen_raw(size_t topic);
  void listen_gathered();
  bool is_gathered(size_t topic) const;
  void take_gathered(const msg::View& batch);
  std::string find_wrong_end(const msg::StepGrant& grant) const;
  void take_description(Bytes sample);
  void watch_events(const msg::RobotDescription& robot, const Scenario& scenario);
  void watch_pictures(const Scenario& scenario);
  void take_sample(size_t topic, Bytes sample);
  // Does the work; what it throws becomes the fault of this server, with the last step of the log.
  void attempt(const std::function<void()>& work);
  void finish_when_complete();
  bool is_quiet() const;
  bool misses_what_was_sent() const;
  // Names what the oldest unwritten step misses, and goes on without it.
  void give_up_waiting();
  void report_progress();

  LoggerOptions options_;
  std::vector<TopicSpec> topics_;  // in the order of the log; pictures are the last
  std::unique_ptr<EventFinder> event_finder_;
  LogWriter log_;
  uint64_t last_sample_count_ = 0;
  uint64_t last_next_step_ = 0;
  int quiet_looks_ = 0;  // in a row, in which nothing had come
  int late_looks_ = 0;   // in a row, in which the oldest step was late and no step was written
  bool logs_pictures_ = false;
  bool holds_ = false;       // a controller may leave out commands
  bool any_last_ = false;    // last_epoch_ and last_step_ hold what a grant said
  bool last_known_ = false;  // the scheduler has said which step is the last one
  uint64_t last_epoch_ = 0, last_step_ = 0;
  std::optional<uint64_t> gathered_from_;  // later steps are in what dynamics gathers
  bool gathered_comes_ = false;            // and earlier ones are written: its topics need no readers of their own
  std::unique_ptr<Reader> gathered_reader_;
  std::vector<std::unique_ptr<Reader>> raw_readers_;  // by topic; nullptr: not read
};

}  // namespace hrp
