// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/remote_server.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/base/printable.h"
#include "common/base/version.h"
#include "servers/console/launcher/file_name.h"

namespace hrp {
namespace {

constexpr auto kBeat = std::chrono::seconds(1);
// A host that has not answered by then is not waited for. ssh gives up a connection after ten seconds.
constexpr auto kAnswer = std::chrono::seconds(30);
const std::string kWord = "hrp-host ";  // begins what the script says; all else is the server's

}  // namespace

std::string quote_word(const std::string& word) {
  static const char kPlain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string make_remote_script(const RemoteCommand& command) {
  const std::string program = quote_word(command.arguments[0]);
  std::string script = "[ -x " + program + " ] || { echo '" + kWord + "lacks' " + program + "; exit 1; }; ";
  for (const std::string& file : command.files) {
    script += "[ -r " + quote_word(file) + " ] || { echo '" + kWord + "lacks' " + quote_word(file) + "; exit 1; }; ";
  }
  script += "echo \"" + kWord + "runs $(" + program + " --version </dev/null 2>&1)\"; exec";
  for (const std::string& word : command.arguments) script += " " + quote_word(word);
  return script + " 2>&1\n";
}

RemoteServer::RemoteServer(RemoteCommand command) : command_(std::move(command)) {}

RemoteServer::~RemoteServer() {
  if (input_ >= 0) close(input_);
  if (output_ >= 0) close(output_);
}

void RemoteServer::start(const std::vector<std::string>& ssh, Children* children) {
  int to[2], from[2];
  if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0)
    throw std::runtime_error(std::string("cannot make a pipe: ") + strerror(errno));
  input_ = to[1];
  output_ = from[0];
  for (const int file : {input_, output_}) fcntl(file, F_SETFL, O_NONBLOCK);
  ChildSpec child;
  child.role = command_.role;
  child.arguments = ssh;
  child.arguments.push_back(command_.host.user.empty() ? command_.host.name
                                                       : command_.host.user + "@" + command_.host.name);
  child.arguments.push_back("sh");
  child.input = to[0];
  child.output = from[1];
  children->start(child);
  close(to[0]);
  close(from[1]);
  start_ = last_beat_ = Clock::now();
  send(make_remote_script(command_));
}

// A pipe holds 64 kB; who reads nothing of it for so long is gone, which its end will say.
void RemoteServer::send(const std::string& text) { (void)!write(input_, text.data(), text.size()); }

void RemoteServer::take_line(const std::string& line, std::vector<std::string>* shown) {
  if (runs_ || line.rfind(kWord, 0) != 0) {
    shown->push_back(command_.host.name + ": " + make_printable_line(line));
    return;
  }
  const std::string said = make_printable_line(line.substr(kWord.size()));
  const std::string ours = get_version_text(get_file_name(command_.arguments[0]));
  if (said == "runs " + ours) {
    runs_ = true;
    return send(command_.token + "\n");
  }
  if (said.rfind("runs ", 0) == 0) {
    fault_ = name() + ": " + command_.arguments[0] + " there is another version: '" + said.substr(5) +
             "', here it is '" + ours + "'";
  } else {
    fault_ = name() + ": " + command_.host.name + " " + said +
             ", or it cannot be used; programs and files have to be there at the path "
             "of this machine, or programs= and secure= of a --hosts file say where they are";
  }
}

std::vector<std::string> RemoteServer::update() {
  std::vector<std::string> shown;
  char buffer[4096];
  for (ssize_t size; (size = read(output_, buffer, sizeof buffer)) > 0;)
    text_.append(buffer, static_cast<size_t>(size));
  for (size_t end; (end = text_.find('\n')) != std::string::npos;) {
    take_line(text_.substr(0, end), &shown);
    text_.erase(0, end + 1);
  }
  const auto now = Clock::now();
  if (!runs_ && fault_.empty() && now - start_ > kAnswer)
    fault_ = name() + ": " + command_.host.name + " has not answered for 30 s";
  if (runs_ && now - last_beat_ >= kBeat) {
    last_beat_ = now;
    send("\n");
  }
  return shown;
}

std::string RemoteServer::describe_end(int status) const {
  if (!fault_.empty()) return fault_;
  const std::string how = hrp::describe_end(status);
  if (!runs_)
    return name() + ": " + command_.host.name + " cannot be reached (the command that leads there " + how +
           ", its words are above)";
  if (WIFEXITED(status) && WEXITSTATUS(status) == 255)
    return name() + ": the connection to " + command_.host.name + " is lost";
  return name() + " " + how;
}

}  // namespace hrp
