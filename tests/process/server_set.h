// SPDX-License-Identifier: BSD-3-Clause
// Runs hrp-simulate as people do, watches it over DDS, and looks at what it leaves behind.
#pragma once

#include <sys/types.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/messages/pubsub.h"
#include "hrp_idl/scheduling.h"

namespace hrp::test {

// Polls until `done`, for a minute at most: only something that never comes fails here, a slow machine does not.
[[nodiscard]] bool wait_until(const std::function<bool()>& done);

// A folder of this test process for scenarios and logs, removed at its end.
std::string get_test_folder();

// models/scenarios/hrp2p_stand.yaml with other lines for `controller` and `steps`, in the test folder.
struct ScenarioChange {
  std::string controller = "{type: hold}";
  std::string steps = "{time_step: 0.001, control_period: 0.005, duration: 0.5}";
};
std::string write_scenario(const std::string& name, const ScenarioChange& change = {});

// How often `text` has the word.
int count(const std::string& text, const std::string& word);

// The step that the launcher named: "... at step N"; -1: none.
long find_named_step(const std::string& output);

// A program with its output in a file.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments);  // [0] without a slash: of build/bin
  ~Program();                                                   // kills it when it still runs
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  pid_t process_id() const { return process_id_; }
  bool has_ended();
  // Waits for its end. Exit status, or -signal.
  int wait();
  void send_signal(int signal);
  std::string output() const;

 private:
  pid_t process_id_ = 0;
  std::string output_file_;
  bool ended_ = false;
  int status_ = 0;
};

// A server set under hrp-simulate.
class ServerSet : public Program {
 public:
  // `arguments` after the program's name; the log goes to log().
  ServerSet(const std::string& name, std::vector<std::string> arguments);
  ~ServerSet();
  const std::string& log() const { return log_; }
  // Of the servers, from their command lines. Waits for them.
  int find_domain();
  // Process that fills a role (by its program's name, such as "hrp-dynamics"). Waits for it.
  pid_t find_server(const std::string& program);
  // Status of the run as heard over DDS. Joins the domain at the first call.
  msg::RunStatus run_status();
  bool wait_for_step(uint64_t step);
  Bus& bus();

 private:
  std::string log_;
  int domain_ = -1;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Reader> reader_;
  msg::RunStatus status_;
};

struct ProcessSeen {
  pid_t process_id = 0;
  pid_t parent_id = 0;
  std::string command;  // arguments, separated by blanks
};
std::vector<ProcessSeen> find_processes();
// Servers on a domain that still run.
std::vector<ProcessSeen> find_servers(int domain);

// Messages of a log: count and a hash over all payload bytes in order, by topic.
struct TopicDigest {
  uint64_t count = 0;
  uint64_t hash = 1469598103934665603ull;
  bool operator==(const TopicDigest& other) const { return count == other.count && hash == other.hash; }
};
std::ostream& operator<<(std::ostream& out, const TopicDigest& digest);
std::map<std::string, TopicDigest> digest_log(const std::string& path);
// The last step that robot_state has in the log, -1 for none.
long find_last_step(const std::string& path);

}  // namespace hrp::test
