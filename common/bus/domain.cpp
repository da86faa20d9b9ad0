// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/domain.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <pwd.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <utility>

#include "common/bus/bus.h"

namespace hrp {
namespace {

const char kClaimPrefix[] = "domain_";

std::string get_claim_name(int domain) { return kClaimPrefix + std::to_string(domain); }
std::string get_entry_name(int domain) { return "run_" + std::to_string(domain); }
std::string get_place_name(int domain, const std::string& role) {
  return "place_" + std::to_string(domain) + "_" + role;
}

// A folder of ours that nobody else may enter, as the system makes it for each user.
bool is_private_parent(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == geteuid() &&
         (info.st_mode & 022) == 0;
}

std::string find_home() {
  const passwd* user = getpwuid(geteuid());
  return user && user->pw_dir ? user->pw_dir : "";
}

PrivateFolder make_run_folder() {
  std::string reasons;
  for (const std::string& path : find_run_folders()) {
    try {
      return PrivateFolder::make(path);
    } catch (const BusError& error) {
      reasons += (reasons.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  throw BusError(reasons);
}

enum class Lock { kTaken, kHeld, kFailed };

// Who removes a claim holds its lock, so a lock on a file that is no longer there counts for nothing.
Lock lock_claim(const PrivateFolder& folder, const std::string& name, bool make_it, int* file) {
  while (true) {
    *file = folder.open_file(name, make_it);
    if (*file < 0) return Lock::kFailed;
    if (flock(*file, LOCK_EX | LOCK_NB) != 0) {
      close(*file);
      return Lock::kHeld;
    }
    if (folder.is_same(name, *file)) return Lock::kTaken;
    close(*file);
  }
}

// Programs that are not ours, or joined by hand, claim nothing: a domain is theirs when the port of one of its first
// participants is taken.
bool has_free_ports(int domain) {
  constexpr int kParticipants = 16;
  for (int participant = 0; participant < kParticipants; ++participant) {
    const int file = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (file < 0) return true;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(7400 + 250 * domain + 10 + 2 * participant));  // RTPS 9.6.1
    const bool taken =
        bind(file, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 && errno == EADDRINUSE;
    close(file);
    if (taken) return false;
  }
  return true;
}

// A socket with the domain's name, which no other process of the machine, of whatever user, can have as long as it is
// open. kFailed: somebody forbids such sockets.
Lock lock_machine(int domain, int* file) {
  *file = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (*file < 0) return Lock::kFailed;
  const std::string name = "openhrp-dds/" + get_claim_name(domain);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());  // a zero before it: abstract
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (bind(*file, reinterpret_cast<const sockaddr*>(&address), size) == 0) return Lock::kTaken;
  const Lock lock = errno == EADDRINUSE ? Lock::kHeld : Lock::kFailed;
  close(std::exchange(*file, -1));
  return lock;
}

// An empty result: somebody holds it.
std::optional<DomainClaim> try_claim(int domain, const std::string& what) {
  PrivateFolder folder = make_run_folder();
  int file = -1, machine = -1;
  switch (lock_claim(folder, get_claim_name(domain), true, &file)) {
    case Lock::kHeld: return std::nullopt;
    case Lock::kFailed:
      throw BusError("cannot open " + folder.path() + "/" + get_claim_name(domain) + ": " + std::strerror(errno));
    case Lock::kTaken: break;
  }
  const bool held = lock_machine(domain, &machine) == Lock::kHeld;
  DomainClaim claim(std::move(folder), domain, file, machine);  // removes its file where it is not given away
  if (held) return std::nullopt;
  RunEntry entry;
  entry.scenario = what;
  claim.describe(entry);
  return claim;
}

bool is_taken(const PrivateFolder& folder, const std::string& place) {
  int file = -1;
  const Lock lock = lock_claim(folder, place, false, &file);
  if (lock != Lock::kTaken) return lock == Lock::kHeld;
  folder.remove(place);  // of one that is no more
  close(file);
  return false;
}

// The entry of a claim that is held; what a dead holder left behind goes.
std::optional<RunEntry> read_entry(const PrivateFolder& folder, int domain) {
  int file = -1;
  if (lock_claim(folder, get_claim_name(domain), false, &file) == Lock::kTaken) {
    folder.remove(get_entry_name(domain));
    folder.remove(get_claim_name(domain));
    close(file);
    return std::nullopt;
  }
  if (file < 0) return std::nullopt;
  RunEntry entry = parse_entry(folder.read(get_entry_name(domain)));
  // A holder that has just begun has not written yet, or its predecessor's words are still there.
  if (entry.domain != domain || entry.process_id <= 0 ||
      (kill(static_cast<pid_t>(entry.process_id), 0) != 0 && errno == ESRCH)) {
    return std::nullopt;
  }
  auto& places = entry.free_places;
  places.erase(std::remove_if(places.begin(), places.end(),
                              [&](const std::string& role) { return is_taken(folder, get_place_name(domain, role)); }),
               places.end());
  return entry;
}

// "domain_62" -> 62, else -1.
int parse_claim_name(const std::string& name) {
  const size_t prefix = sizeof kClaimPrefix - 1;
  if (name.compare(0, prefix, kClaimPrefix) != 0 || name.size() == prefix || name.size() > prefix + 3) return -1;
  if (name.find_first_not_of("0123456789", prefix) != std::string::npos) return -1;
  return std::stoi(name.substr(prefix));
}

}  // namespace

DomainClaim::DomainClaim(PrivateFolder folder, int domain, int file, int machine)
    : folder_(std::move(folder)), domain_(domain), file_(file), machine_(machine) {}

DomainClaim::DomainClaim(DomainClaim&& other) noexcept
    : folder_(std::exchange(other.folder_, std::nullopt)),
      domain_(std::exchange(other.domain_, -1)),
      file_(std::exchange(other.file_, -1)),
      machine_(std::exchange(other.machine_, -1)),
      entry_(std::move(other.entry_)) {}

DomainClaim& DomainClaim::operator=(DomainClaim&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(domain_, other.domain_);
  std::swap(file_, other.file_);
  std::swap(machine_, other.machine_);
  std::swap(entry_, other.entry_);
  return *this;
}

DomainClaim::~DomainClaim() {
  if (file_ < 0) return;
  folder_->remove(get_entry_name(domain_));
  folder_->remove(get_claim_name(domain_));
  close(file_);
  if (machine_ >= 0) close(machine_);
}

PlaceClaim::PlaceClaim(PrivateFolder folder, std::string name, int file)
    : folder_(std::move(folder)), name_(std::move(name)), file_(file) {}

PlaceClaim::PlaceClaim(PlaceClaim&& other) noexcept
    : folder_(std::exchange(other.folder_, std::nullopt)),
      name_(std::move(other.name_)),
      file_(std::exchange(other.file_, -1)) {}

PlaceClaim& PlaceClaim::operator=(PlaceClaim&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(name_, other.name_);
  std::swap(file_, other.file_);
  return *this;
}

PlaceClaim::~PlaceClaim() {
  if (file_ < 0) return;
  folder_->remove(name_);
  close(file_);
}

std::optional<PlaceClaim> claim_place(int domain, const std::string& role) {
  PrivateFolder folder = make_run_folder();
  const std::string name = get_place_name(domain, role);
  // Somebody who only looks holds a free place for a moment.
  for (int attempt = 0; attempt < 20; ++attempt) {
    int file = -1;
    const Lock lock = lock_claim(folder, name, true, &file);
    if (lock == Lock::kTaken) return PlaceClaim(std::move(folder), name, file);
    if (lock == Lock::kFailed)
      throw BusError("cannot open " + folder.path() + "/" + name + ": " + std::strerror(errno));
    usleep(5000);
  }
  return std::nullopt;
}

void DomainClaim::describe(RunEntry entry) {
  entry.domain = domain_;
  entry.process_id = getpid();
  entry.started = entry_.started > 0 ? entry_.started : static_cast<long long>(std::time(nullptr));
  entry_ = std::move(entry);
  folder_->replace(get_entry_name(domain_), format_entry(entry_));
}

std::vector<std::string> find_run_folders() {
  const std::string user = std::to_string(geteuid());
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime && *runtime && is_private_parent(runtime)) return {std::string(runtime) + "/openhrp-dds"};
  if (is_private_parent("/run/user/" + user)) return {"/run/user/" + user + "/openhrp-dds"};
  std::vector<std::string> folders{"/tmp/openhrp-dds-" + user};
  if (const std::string home = find_home(); is_private_parent(home)) folders.push_back(home + "/.openhrp-dds");
  return folders;
}

DomainClaim claim_free_domain(const std::string& what) {
  // Neighbours in time get different domains: packets still on their way from a run that just ended meet nobody.
  const int count = kLastDomain - kFirstDomain + 1;
  const int first = static_cast<int>(getpid() % count);
  for (int i = 0; i < count; ++i) {
    const int domain = kFirstDomain + (first + i) % count;
    if (!has_free_ports(domain)) continue;
    if (auto claim = try_claim(domain, what)) return std::move(*claim);
  }
  throw BusError("all DDS domains from " + std::to_string(kFirstDomain) + " to " + std::to_string(kLastDomain) +
                 " are in use (locked files in " + find_run_folders()[0] + ", or ports of other users)");
}

DomainClaim claim_domain(int domain, const std::string& what) {
  // Somebody who only looks holds a free claim for a moment.
  for (int attempt = 0; attempt < 20; ++attempt) {
    if (auto claim = try_claim(domain, what)) return std::move(*claim);
    usleep(5000);
  }
  const auto holder = find_run_of_domain(domain);
  throw BusError("DDS domain " + std::to_string(domain) + " is in use by another run" +
                 (holder ? ":\n  " + describe_entry(*holder)
                         : " (of another user, or a locked file in " + find_run_folders()[0] + ")"));
}

std::optional<RunEntry> find_run_of_domain(int domain) {
  for (const std::string& path : find_run_folders()) {
    const auto folder = PrivateFolder::find(path);
    if (!folder) continue;
    if (auto entry = read_entry(*folder, domain)) return entry;
  }
  return std::nullopt;
}

std::vector<RunEntry> find_runs() {
  std::vector<RunEntry> runs;
  for (const std::string& path : find_run_folders()) {
    const auto folder = PrivateFolder::find(path);
    if (!folder) continue;
    for (const std::string& name : folder->find_files()) {
      const int domain = parse_claim_name(name);
      if (domain < 0) continue;
      if (auto entry = read_entry(*folder, domain)) runs.push_back(std::move(*entry));
    }
  }
  std::sort(runs.begin(), runs.end(), [](const RunEntry& a, const RunEntry& b) { return a.domain < b.domain; });
  return runs;
}

}  // namespace hrp
