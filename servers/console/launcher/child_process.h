// SPDX-License-Identifier: BSD-3-Clause
// A server as a child of the launcher.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace hrp {

struct ChildSpec {
  std::string role;
  std::vector<std::string> arguments;  // [0] is the program's path
  std::vector<int> cores;              // empty: any
  int input = -1, output = -1;  // files in the place of standard input, and of output and errors; < 0: /dev/null, ours
};

struct ChildEnd {
  std::string role;
  std::string program;
  pid_t process_id = 0;
  int status = 0;  // as waitpid() gives it
};

// "was killed by signal 9 (SIGKILL)", "ended with exit status 1".
std::string describe_end(int status);

// Children die with this process, however it dies: the kernel sends them SIGTERM (prctl PR_SET_PDEATHSIG). They live in
// process groups of their own, so that Ctrl-C reaches the launcher alone, which then ends them in order.
class Children {
 public:
  ~Children();  // kills what is left
  // Throws std::runtime_error when the process cannot be made. A program that cannot be run ends with status 127.
  void start(const ChildSpec& spec);
  // One child that has ended since the last call.
  std::optional<ChildEnd> take_ended();
  void send_signal(int signal);
  bool any_running() const { return !running_.empty(); }
  std::vector<std::string> get_running_roles() const;
  const ChildSpec* find_spec(const std::string& role) const;

 private:
  struct Running {
    pid_t process_id;
    ChildSpec spec;
  };
  std::vector<Running> running_;
  std::vector<ChildSpec> specs_;
};

// Cores this process may use.
std::vector<int> find_cores();

}  // namespace hrp
