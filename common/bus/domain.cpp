// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/domain.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/bus/bus.h"

namespace hrp {
namespace {

std::string find_claim_path(int domain) { return find_domain_folder() + "/domain_" + std::to_string(domain); }

void make_folder() {
  const std::string folder = find_domain_folder();
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    throw BusError("cannot make " + folder + ": " + std::strerror(errno));
  }
}

// An empty result: somebody holds it.
std::optional<DomainClaim> try_claim(int domain, const std::string& what) {
  const std::string path = find_claim_path(domain);
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) throw BusError("cannot open " + path + ": " + std::strerror(errno));
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    close(file);
    return std::nullopt;
  }
  const std::string text = std::to_string(getpid()) + "\n" + what + "\n";
  if (ftruncate(file, 0) != 0 || write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    const std::string reason = std::strerror(errno);
    close(file);
    throw BusError("cannot write " + path + ": " + reason);
  }
  return DomainClaim(domain, file);
}

bool is_held(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return false;
  const bool held = flock(file, LOCK_SH | LOCK_NB) != 0;
  close(file);
  return held;
}

}  // namespace

DomainClaim::DomainClaim(DomainClaim&& other) noexcept
    : domain_(std::exchange(other.domain_, -1)), file_(std::exchange(other.file_, -1)) {}

DomainClaim& DomainClaim::operator=(DomainClaim&& other) noexcept {
  std::swap(domain_, other.domain_);
  std::swap(file_, other.file_);
  return *this;
}

DomainClaim::~DomainClaim() {
  // The file stays: removing it would race with a process that has just opened it.
  if (file_ >= 0) close(file_);
}

std::string find_domain_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime && *runtime && access(runtime, W_OK) == 0) return std::string(runtime) + "/openhrp-dds";
  return "/tmp/openhrp-dds-" + std::to_string(getuid());
}

DomainClaim claim_free_domain(const std::string& what) {
  make_folder();
  // Neighbours in time get different domains: packets still on their way from a run that just ended meet nobody.
  const int count = kLastDomain - kFirstDomain + 1;
  const int first = static_cast<int>(getpid() % count);
  for (int i = 0; i < count; ++i) {
    if (auto claim = try_claim(kFirstDomain + (first + i) % count, what)) return std::move(*claim);
  }
  throw BusError("all DDS domains from " + std::to_string(kFirstDomain) + " to " + std::to_string(kLastDomain) +
                 " are in use (locked files in " + find_domain_folder() + ")");
}

DomainClaim claim_domain(int domain, const std::string& what) {
  make_folder();
  if (auto claim = try_claim(domain, what)) return std::move(*claim);
  throw BusError("DDS domain " + std::to_string(domain) + " is in use by another run (" + find_claim_path(domain) + ")");
}

std::vector<RunningDomain> find_running_domains() {
  std::vector<RunningDomain> running;
  for (int domain = 0; domain <= 230; ++domain) {
    const std::string path = find_claim_path(domain);
    if (!is_held(path)) continue;
    RunningDomain found;
    found.domain = domain;
    std::ifstream file(path);
    file >> found.process_id;
    file.ignore();
    std::getline(file, found.what);
    running.push_back(found);
  }
  return running;
}

int choose_running_domain(int wanted) {
  if (wanted >= 0) return wanted;
  const std::vector<RunningDomain> running = find_running_domains();
  if (running.size() == 1) return running[0].domain;
  if (running.empty()) throw BusError("no simulation runs on this machine (say --domain N to look at a domain anyway)");
  std::string text = "several simulations run, choose one with --domain:";
  for (const RunningDomain& each : running) {
    text += "\n  --domain " + std::to_string(each.domain) + "   " + each.what + " (process " +
            std::to_string(each.process_id) + ")";
  }
  throw BusError(text);
}

}  // namespace hrp
