// SPDX-License-Identifier: BSD-3-Clause
#include "tests/process/server_set.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "common/bus/make_bus.h"
#include "common/mcap/reader.h"
#include "common/messages/topics.h"
#include "hrp_idl/dynamics.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

namespace fs = std::filesystem;

class TestFolder {
 public:
  TestFolder() : path_(fs::temp_directory_path() / ("hrp-process-test-" + std::to_string(getpid()))) {
    fs::create_directories(path_ / "runtime");
    fs::permissions(path_ / "runtime", fs::perms::owner_all);
    // Runs of other tests at the same time are another user's: a controller that joins "the only run" finds its own.
    setenv("XDG_RUNTIME_DIR", (path_ / "runtime").c_str(), 1);
  }
  ~TestFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string replace_line(const std::string& text, const std::string& key, const std::string& value) {
  return std::regex_replace(text, std::regex("(^|\n)" + key + ":[^\n]*"), "$1" + key + ": " + value);
}

}  // namespace

bool wait_until(const std::function<bool()>& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

int count(const std::string& text, const std::string& word) {
  int found = 0;
  for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

long find_named_step(const std::string& output) {
  const size_t place = output.find(" at step ");
  return place == std::string::npos ? -1 : std::stol(output.substr(place + 9));
}

std::string get_test_folder() {
  static const TestFolder folder;
  return folder.path();
}

std::string write_scenario(const std::string& name, const ScenarioChange& change) {
  const std::string models = source_dir() + "/models";
  std::string text = read_file(models + "/scenarios/hrp2p_stand.yaml");
  text = replace_line(text, "robot", models + "/hrp2p_like/hrp2p_like.urdf");
  text = replace_line(text, "controller", change.controller);
  text = replace_line(text, "steps", change.steps);
  std::string path = get_test_folder() + "/" + name + ".yaml";
  std::ofstream(path) << text;
  return path;
}

Program::Program(const std::vector<std::string>& arguments) {
  static int count = 0;
  output_file_ = get_test_folder() + "/output-" + std::to_string(count++) + ".txt";
  std::vector<std::string> words = arguments;
  if (words[0].find('/') == std::string::npos) words[0] = bin_dir() + "/" + words[0];
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t parent = getpid();
  process_id_ = fork();
  if (process_id_ < 0) throw std::runtime_error("cannot fork");
  if (process_id_ > 0) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  const int file = open(output_file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  dup2(file, 1);
  dup2(file, 2);
  execv(pointers[0], pointers.data());
  _exit(127);
}

Program::~Program() {
  if (has_ended()) return;
  send_signal(SIGTERM);
  if (!wait_until([this] { return has_ended(); })) send_signal(SIGKILL);
}

bool Program::has_ended() {
  if (!ended_ && waitpid(process_id_, &status_, WNOHANG) == process_id_) ended_ = true;
  return ended_;
}

int Program::wait() {
  if (!wait_until([this] { return has_ended(); })) {
    throw std::runtime_error("still running; output so far:\n" + output());
  }
  return WIFSIGNALED(status_) ? -WTERMSIG(status_) : WEXITSTATUS(status_);
}

void Program::send_signal(int signal) {
  if (!ended_) kill(process_id_, signal);
}

std::string Program::output() const { return read_file(output_file_); }

namespace {

std::vector<std::string> make_simulate_command(const std::string& log, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "hrp-simulate");
  arguments.insert(arguments.end(), {"--log", log, "--no-plot"});
  return arguments;
}

std::string make_log_name(const std::string& name) { return get_test_folder() + "/" + name + ".mcap"; }

}  // namespace

ServerSet::ServerSet(const std::string& name, std::vector<std::string> arguments)
    : Program(make_simulate_command(make_log_name(name), std::move(arguments))), log_(make_log_name(name)) {}

ServerSet::~ServerSet() = default;

int ServerSet::find_domain() {
  static const std::regex pattern("--domain ([0-9]+)");
  const bool found = wait_until([this] {
    for (const ProcessSeen& process : find_processes()) {
      std::smatch match;
      if (process.parent_id != process_id() || !std::regex_search(process.command, match, pattern)) continue;
      domain_ = std::stoi(match[1]);
      return true;
    }
    return has_ended();
  });
  if (!found || domain_ < 0) throw std::runtime_error("no server was started:\n" + output());
  return domain_;
}

pid_t ServerSet::find_server(const std::string& program) {
  pid_t found = 0;
  (void)wait_until([&] {
    for (const ProcessSeen& process : find_processes()) {
      if (process.parent_id == process_id() && process.command.find("/" + program + " ") != std::string::npos) {
        found = process.process_id;
      }
    }
    return found != 0 || has_ended();
  });
  if (found == 0) throw std::runtime_error(program + " does not run:\n" + output());
  return found;
}

Bus& ServerSet::bus() {
  if (bus_) return *bus_;
  BusOptions options;
  options.domain = find_domain();
  bus_ = make_bus(options);
  reader_ = subscribe<msg::RunStatus>(*bus_, topics::kRunStatus, Delivery::kReliable,
                                      [this](const msg::RunStatus& status) { status_ = status; });
  return *bus_;
}

msg::RunStatus ServerSet::run_status() {
  std::lock_guard<std::recursive_mutex> lock(bus().mutex());
  return status_;
}

bool ServerSet::wait_for_step(uint64_t step) {
  return wait_until([&] { return run_status().step() >= step || has_ended(); }) && !has_ended();
}

std::vector<ProcessSeen> find_processes() {
  std::vector<ProcessSeen> seen;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = read_file("/proc/" + name + "/stat");
    std::string command = read_file("/proc/" + name + "/cmdline");
    const size_t paren = stat.rfind(')');
    if (paren == std::string::npos || command.empty()) continue;  // gone, or a zombie
    for (char& c : command) c = c == '\0' ? ' ' : c;
    ProcessSeen process;
    process.process_id = std::stoi(name);
    char state = 0;
    std::istringstream(stat.substr(paren + 1)) >> state >> process.parent_id;
    process.command = command;
    seen.push_back(process);
  }
  return seen;
}

std::vector<ProcessSeen> find_servers(int domain) {
  std::vector<ProcessSeen> servers;
  for (const ProcessSeen& process : find_processes()) {
    const bool ours = process.command.find(bin_dir()) == 0;
    if (ours && process.command.find("--domain " + std::to_string(domain) + " ") != std::string::npos)
      servers.push_back(process);
  }
  return servers;
}

std::ostream& operator<<(std::ostream& out, const TopicDigest& digest) {
  return out << digest.count << " messages, hash " << std::hex << digest.hash << std::dec;
}

std::map<std::string, TopicDigest> digest_log(const std::string& path) {
  std::map<std::string, TopicDigest> digests;
  mcap::Reader reader(path);
  reader.read_messages([&](const mcap::Message& message) {
    TopicDigest& digest = digests[reader.channels().at(message.channel_id).topic];
    ++digest.count;
    const uint64_t size = message.size;  // so that borders between messages count, too
    const auto mix = [&digest](uint8_t byte) { digest.hash = (digest.hash ^ byte) * 1099511628211ull; };
    for (int i = 0; i < 8; ++i) mix(static_cast<uint8_t>(size >> (8 * i)));
    for (size_t i = 0; i < message.size; ++i) mix(message.data[i]);
    return true;
  });
  return digests;
}

long find_last_step(const std::string& path) {
  long last = -1;
  msg::RobotState state;
  mcap::Reader reader(path);
  reader.read_messages(
      [&](const mcap::Message& message) {
        decode({message.data, message.size}, &state);
        last = static_cast<long>(state.header().step());
        return true;
      },
      {topics::kRobotState.name});
  return last;
}

}  // namespace hrp::test
