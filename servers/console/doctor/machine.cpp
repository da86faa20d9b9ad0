// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/doctor/machine.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/timex.h>
#include <unistd.h>

#include <fcntl.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <set>
#include <sstream>

#include "common/base/ends_with.h"
#include "common/bus/bus.h"
#include "common/bus/domain.h"
#include "common/bus/make_bus.h"
#include "common/bus/participants.h"
#include "common/bus/private_folder.h"

namespace hrp {
namespace {

constexpr rlim_t kFewFiles = 128;                            // a server has up to 40 open, the viewer 64 clients more
constexpr long long kFirstGoodTime = 1704067200;             // [s] 2024-01-01: this program is younger
constexpr auto kPatience = std::chrono::milliseconds(3000);  // for a message that takes 20 ms as a rule

// Closes itself.
class Socket {
 public:
  Socket() : file_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (file_ >= 0) close(file_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int get() const { return file_; }

 private:
  int file_;
};

// Name and flags of the interface with this IPv4 address.
bool find_interface(const std::string& address, std::string* name, unsigned* flags) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return false;
  bool found = false;
  for (const ifaddrs* entry = list; entry && !found; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr, text, sizeof text);
    if (address != text) continue;
    *name = entry->ifa_name;
    *flags = entry->ifa_flags;
    found = true;
  }
  freeifaddrs(list);
  return found;
}

// A packet to the group of discovery (RTPS 9.6.1.4) comes back on this interface.
bool returns_multicast(const std::string& address) {
  const Socket receiver, sender;
  in_addr interface {};
  inet_pton(AF_INET, address.c_str(), &interface);
  ip_mreq group{};
  inet_pton(AF_INET, "239.255.0.1", &group.imr_multiaddr);
  group.imr_interface = interface;
  sockaddr_in to{};
  to.sin_family = AF_INET;
  socklen_t size = sizeof to;
  const timeval patience{1, 0};
  if (bind(receiver.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) return false;
  if (getsockname(receiver.get(), reinterpret_cast<sockaddr*>(&to), &size) != 0) return false;
  to.sin_addr = group.imr_multiaddr;
  if (setsockopt(receiver.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) return false;
  setsockopt(receiver.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  if (setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface) != 0) return false;
  const char word[] = "hrp-doctor";
  if (sendto(sender.get(), word, sizeof word, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to) < 0) return false;
  char back[sizeof word] = "";
  return recv(receiver.get(), back, sizeof back, 0) == sizeof back && std::memcmp(word, back, sizeof back) == 0;
}

// Writes on one bus until the other has it.
bool brings_back(Bus& from, Bus& to) {
  const TopicSpec topic{"hrp/doctor", "hrp::msg::Doctor", Retention::kLatest, 1};
  bool heard = false;
  const auto reader = to.make_reader(topic, Delivery::kReliable, [&](Bytes) { heard = true; });
  const auto writer = from.make_writer(topic);
  const uint8_t sample[8] = {0, 1, 0, 0, 42, 0, 0, 0};  // CDR, little endian: one number
  writer->write({sample, sizeof sample});
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < end) {
    {
      std::lock_guard<std::recursive_mutex> lock(to.mutex());
      if (heard) return true;
    }
    from.spin(std::chrono::milliseconds(5));
    to.spin(std::chrono::milliseconds(5));
  }
  return false;
}

Finding try_pair(const std::string& from, const std::string& to, int domain) {
  const std::string name = from == to ? from : from + " to " + to;
  try {
    BusOptions options;
    options.domain = domain;
    options.vendor = from;
    const auto first = make_bus(options);
    options.vendor = to;
    const auto second = make_bus(options);
    if (brings_back(*first, *second)) return make_ok("vendor", name + " brings a message over loopback");
    return make_problem("vendor", name + ": no message came over loopback",
                        "a firewall on lo? sudo iptables -L; packages: scripts/install_deps.sh");
  } catch (const std::exception& error) {
    return make_problem("vendor", name + ": " + error.what(), "packages: scripts/install_deps.sh");
  }
}

// Ports of UDP sockets of this machine, from a table of the kernel.
std::set<int> read_udp_ports() {
  std::set<int> ports;
  std::ifstream table("/proc/net/udp");
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::string slot, local;
    words >> slot >> local;
    const size_t colon = local.find(':');
    if (colon != std::string::npos) ports.insert(static_cast<int>(std::strtol(local.c_str() + colon + 1, nullptr, 16)));
  }
  return ports;
}

// "fastrtps_3f2a_el" is locked by who made "fastrtps_3f2a", as long as it lives.
bool is_stale(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return false;
  const bool free = flock(file, LOCK_EX | LOCK_NB) == 0;
  close(file);
  return free;
}

std::vector<std::string> find_stale(const std::string& folder) {
  std::vector<std::string> stale;
  DIR* opened = opendir(folder.c_str());
  if (!opened) return stale;
  while (const dirent* entry = readdir(opened)) {
    const std::string name = entry->d_name;
    const bool lock = name.rfind("fastrtps_", 0) == 0 && ends_with(name, "_el");
    if (lock && is_stale(folder + "/" + name)) stale.push_back(name);
  }
  closedir(opened);
  return stale;
}

std::string get_variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

void check_file_variable(const char* name, Findings* findings) {
  std::string file = get_variable(name);
  if (file.empty() || file[0] == '<') return;
  if (file.rfind("file://", 0) == 0) file = file.substr(7);
  if (std::ifstream(file)) return;
  findings->push_back(make_problem("environment", std::string(name) + " names " + file + ", which cannot be read",
                                   std::string("unset ") + name));
}

}  // namespace

Finding check_run_folder() {
  std::string reasons;
  for (const std::string& path : find_run_folders()) {
    try {
      const PrivateFolder folder = PrivateFolder::make(path);
      return make_ok("folder", "runs are listed in " + folder.path());
    } catch (const std::exception& error) {
      reasons += (reasons.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  return make_problem("folder", reasons, "remove it, or set XDG_RUNTIME_DIR to a folder of yours with mode 700");
}

Finding check_interface(const std::string& address) {
  const std::string meant = address.empty() ? "127.0.0.1" : address;
  std::string name;
  unsigned flags = 0;
  if (!find_interface(meant, &name, &flags)) {
    const std::string mend = address.empty() ? "sudo ip link set lo up" : "an address of: ip -4 addr";
    return make_problem("interface", "no interface that is up has " + meant, mend);
  }
  if (!(flags & IFF_UP))
    return make_problem("interface", name + " (" + meant + ") is down", "sudo ip link set " + name + " up");
  return make_ok("interface",
                 name + " (" + meant + ") is up" + (address.empty() ? "; runs stay on it by default" : ""));
}

Finding check_multicast(const std::string& address) {
  if (address.empty()) return make_ok("multicast", "is not used: on loopback peers are found without it");
  std::string name;
  unsigned flags = 0;
  if (!find_interface(address, &name, &flags))
    return make_problem("multicast", "no interface has " + address, "an address of: ip -4 addr");
  if (!(flags & IFF_MULTICAST))
    return make_problem("multicast", name + " does not pass it, so nobody is found",
                        "sudo ip link set " + name + " multicast on, or peers in --dds-config");
  if (returns_multicast(address)) return make_ok("multicast", "packets to 239.255.0.1 come back on " + name);
  return make_problem("multicast", "packets to 239.255.0.1 do not come back on " + name,
                      "sudo ip route add 224.0.0.0/4 dev " + name + "; or a firewall, or peers in --dds-config");
}

Findings check_vendors() {
  Findings findings;
  try {
    const DomainClaim claim = claim_free_domain("hrp-doctor");
    for (const auto& [from, to] : {std::pair("cyclone", "cyclone"), std::pair("fast", "fast"),
                                   std::pair("cyclone", "fast"), std::pair("fast", "cyclone")}) {
      findings.push_back(try_pair(from, to, claim.domain()));
    }
  } catch (const std::exception& error) {
    findings.push_back(
        make_problem("vendor", error.what(), "see the folder above; or end runs: build/bin/hrp-run list"));
  }
  return findings;
}

Finding check_places(int domain) {
  const std::set<int> ports = read_udp_ports();
  int taken = 0;
  for (int i = 0; i < kMostParticipants; ++i) taken += static_cast<int>(ports.count(7400 + 250 * domain + 10 + 2 * i));
  const std::string says = std::to_string(taken) + " of " + std::to_string(kMostParticipants) +
                           " places for participants are taken in domain " + std::to_string(domain);
  if (taken + 2 <= kMostParticipants) return make_ok("domain", says);
  return make_problem("domain", says, "end some of its programs, or start the run again: it takes another domain");
}

Finding check_shared_memory(const std::string& folder) {
  const std::vector<std::string> stale = find_stale(folder);
  if (stale.empty()) return make_ok("shared memory", "nothing stale in " + folder + "; our programs do not use it");
  return make_problem(
      "shared memory",
      std::to_string(stale.size()) + " files of Fast DDS programs that are gone, as " + folder + "/" + stale[0],
      "when no Fast DDS program runs: rm " + folder + "/*fastrtps_*");
}

Findings check_environment(int domain) {
  Findings findings;
  const std::string ros = get_variable("ROS_DOMAIN_ID");
  if (domain >= 0 && !ros.empty() && std::atoi(ros.c_str()) != domain) {
    findings.push_back(make_problem("environment",
                                    "ROS_DOMAIN_ID is " + ros + ", the run is in domain " + std::to_string(domain),
                                    "export ROS_DOMAIN_ID=" + std::to_string(domain)));
  }
  if (get_variable("ROS_LOCALHOST_ONLY") == "0" && get_variable("CYCLONEDDS_URI").empty() &&
      get_variable("RMW_IMPLEMENTATION") == "rmw_cyclonedds_cpp") {
    findings.push_back(make_problem("environment", "ROS 2 looks on a network interface, the run is on loopback",
                                    "export CYCLONEDDS_URI=file://$PWD/idl/example_c/cyclone.xml"));
  }
  check_file_variable("CYCLONEDDS_URI", &findings);
  check_file_variable("FASTRTPS_DEFAULT_PROFILES_FILE", &findings);
  if (findings.empty()) findings.push_back(make_ok("environment", "no variable leads elsewhere"));
  return findings;
}

Finding check_clock(const std::vector<RunEntry>& runs, bool several_machines) {
  const long long now = static_cast<long long>(std::time(nullptr));
  if (now < kFirstGoodTime)
    return make_problem("clock", "this machine's clock is before 2024", "sudo timedatectl set-ntp true");
  for (const RunEntry& run : runs) {
    if (run.started <= now + 5) continue;
    return make_problem("clock",
                        "run " + std::to_string(run.process_id) + " began " + std::to_string(run.started - now) +
                            " s in the future: the clock jumped",
                        "sudo timedatectl set-ntp true; states never depend on it, certificates do");
  }
  timex state{};
  const bool synchronised = adjtimex(&state) != TIME_ERROR;
  if (several_machines && !synchronised)
    return make_problem("clock", "nobody sets this machine's clock, and certificates need one",
                        "sudo timedatectl set-ntp true");
  return make_ok("clock", synchronised ? "is set from outside" : "runs free; on one machine nothing depends on it");
}

Finding check_files() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const std::string says = "a process may have " + std::to_string(limit.rlim_cur) + " open files";
  if (limit.rlim_cur >= kFewFiles) return make_ok("files", says);
  return make_problem("files", says + ", a server with clients needs " + std::to_string(kFewFiles), "ulimit -n 1024");
}

}  // namespace hrp
