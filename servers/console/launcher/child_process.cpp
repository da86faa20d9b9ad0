// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/child_process.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>

#include "servers/console/launcher/file_name.h"

namespace hrp {
namespace {

// In the child, between fork and exec: nothing but system calls, the parent may have threads.
[[noreturn]] void run_child(char* const* arguments, const cpu_set_t* cores, const ChildSpec& spec, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  if (cores) sched_setaffinity(0, sizeof *cores, cores);
  const int input = spec.input >= 0 ? spec.input : open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (input >= 0) dup2(input, 0);
  if (spec.output >= 0 && (dup2(spec.output, 1) < 0 || dup2(spec.output, 2) < 0)) _exit(127);
  execv(arguments[0], arguments);
  const char text[] = "hrp-simulate: cannot run ";
  (void)!write(2, text, sizeof text - 1);
  (void)!write(2, arguments[0], strlen(arguments[0]));
  (void)!write(2, "\n", 1);
  _exit(127);
}

}  // namespace

std::string describe_end(int status) {
  if (WIFSIGNALED(status)) {
    const char* name = sigabbrev_np(WTERMSIG(status));
    return "was killed by signal " + std::to_string(WTERMSIG(status)) + " (SIG" + (name ? name : "?") + ")";
  }
  return "ended with exit status " + std::to_string(WEXITSTATUS(status));
}

Children::~Children() {
  send_signal(SIGKILL);
  for (const Running& child : running_) waitpid(child.process_id, nullptr, 0);
}

void Children::start(const ChildSpec& spec) {
  std::vector<char*> arguments;
  for (const std::string& argument : spec.arguments) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  cpu_set_t cores;
  CPU_ZERO(&cores);
  for (const int core : spec.cores) CPU_SET(core, &cores);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error(std::string("cannot make a process: ") + strerror(errno));
  if (child == 0) run_child(arguments.data(), spec.cores.empty() ? nullptr : &cores, spec, parent);
  setpgid(child, child);
  running_.push_back({child, spec});
  if (!find_spec(spec.role)) specs_.push_back(spec);
}

std::optional<ChildEnd> Children::take_ended() {
  for (size_t i = 0; i < running_.size(); ++i) {
    int status = 0;
    if (waitpid(running_[i].process_id, &status, WNOHANG) != running_[i].process_id) continue;
    ChildEnd end{running_[i].spec.role, get_file_name(running_[i].spec.arguments[0]), running_[i].process_id, status};
    running_.erase(running_.begin() + static_cast<long>(i));
    return end;
  }
  return std::nullopt;
}

void Children::send_signal(int signal) {
  for (const Running& child : running_) kill(child.process_id, signal);
}

std::vector<std::string> Children::get_running_roles() const {
  std::vector<std::string> roles;
  for (const Running& child : running_) roles.push_back(child.spec.role);
  return roles;
}

const ChildSpec* Children::find_spec(const std::string& role) const {
  for (const ChildSpec& spec : specs_) {
    if (spec.role == role) return &spec;
  }
  return nullptr;
}

std::vector<int> find_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof set, &set) != 0) return cores;
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(i, &set)) cores.push_back(i);
  }
  return cores;
}

}  // namespace hrp
