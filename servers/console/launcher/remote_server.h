// SPDX-License-Identifier: BSD-3-Clause
// A server on another machine, seen from the launcher. A command such as ssh runs "sh" there, and everything else goes
// through its standard input: a script that looks whether program and files are there, says the program's version and
// becomes the program; then, when the version is ours, the token of the run; then a line a second (far_launcher.h).
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "servers/console/launcher/child_process.h"
#include "servers/console/launcher/hosts.h"

namespace hrp {

struct RemoteCommand {
  std::string role;
  Host host;
  std::vector<std::string> arguments;  // [0] is the program's path there
  std::vector<std::string> files;      // that the server reads, at the same path as here
  std::string token;                   // of the run
};

// What sh is to do, one line for one read of its input.
std::string make_remote_script(const RemoteCommand& command);

// For a shell.
std::string quote_word(const std::string& word);

class RemoteServer {
 public:
  using Clock = std::chrono::steady_clock;
  explicit RemoteServer(RemoteCommand command);
  ~RemoteServer();
  RemoteServer(const RemoteServer&) = delete;
  RemoteServer& operator=(const RemoteServer&) = delete;

  // Starts `ssh` [USER@]HOST sh among the children.
  void start(const std::vector<std::string>& ssh, Children* children);
  // Answers what was said, and shows the rest with the host's name in front. Never blocks.
  std::vector<std::string> update();
  // Why the server cannot be there: another version, a missing file, nobody answers. Empty when nothing is known.
  const std::string& fault() const { return fault_; }
  // The command that led there has ended: why, in words.
  std::string describe_end(int status) const;
  const std::string& role() const { return command_.role; }
  // "controller on desk"
  std::string name() const { return command_.role + " on " + command_.host.name; }

 private:
  void take_line(const std::string& line, std::vector<std::string>* shown);
  void send(const std::string& text);

  RemoteCommand command_;
  int input_ = -1, output_ = -1;  // our ends
  std::string text_;              // what has come of a line
  std::string fault_;
  bool runs_ = false;
  Clock::time_point start_, last_beat_;
};

}  // namespace hrp
