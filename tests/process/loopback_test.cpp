// SPDX-License-Identifier: BSD-3-Clause
// Out of the box nothing leaves the machine.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <linux/if_ether.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "tests/process/server_set.h"

namespace hrp::test {
namespace {

namespace fs = std::filesystem;

// Sees every packet of every interface; needs the right to (CAP_NET_RAW).
class Sniffer {
 public:
  Sniffer() : socket_(socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(ETH_P_ALL))) {}
  ~Sniffer() {
    if (socket_ >= 0) close(socket_);
  }
  bool may_listen() const { return socket_ >= 0; }
  // DDS packets (they begin with "RTPS" behind IP and UDP heads) since the last call, on loopback and elsewhere.
  void count(int* loopback, int* elsewhere) {
    const unsigned lo = if_nametoindex("lo");
    sockaddr_ll from{};
    socklen_t size = sizeof from;
    std::array<char, 128> head{};
    ssize_t got = 0;
    while ((got = recvfrom(socket_, head.data(), head.size(), 0, reinterpret_cast<sockaddr*>(&from), &size)) > 0) {
      const char* end = head.data() + got;
      const char magic[] = {'R', 'T', 'P', 'S'};
      if (std::search(static_cast<const char*>(head.data()), end, magic, magic + 4) == end) continue;
      ++*(static_cast<unsigned>(from.sll_ifindex) == lo ? loopback : elsewhere);
    }
  }

 private:
  int socket_;
};

TEST(Loopback, NoDdsPacketOnAnyOtherInterface) {
  for (const char* vendor : {"cyclone", "fast"}) {
    Sniffer sniffer;
    if (!sniffer.may_listen()) GTEST_SKIP() << "NOT TESTED: watching all interfaces needs root or CAP_NET_RAW";
    ServerSet set(std::string("loopback-") + vendor, {write_scenario("loopback"), "--dds", vendor});
    int loopback = 0, elsewhere = 0;
    while (!set.has_ended()) {
      sniffer.count(&loopback, &elsewhere);
      usleep(1000);
    }
    EXPECT_EQ(set.wait(), 0) << set.output();
    EXPECT_GT(loopback, 100) << "the sniffer sees what is there";
    EXPECT_EQ(elsewhere, 0) << vendor;
  }
}

// ---- sockets ------------------------------------------------------------------------------------------------------

std::set<std::string> find_socket_inodes(pid_t process) {
  std::set<std::string> inodes;
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator("/proc/" + std::to_string(process) + "/fd", gone)) {
    const std::string target = fs::read_symlink(entry.path(), gone).string();
    if (target.rfind("socket:[", 0) == 0) inodes.insert(target.substr(8, target.size() - 9));
  }
  return inodes;
}

// Local addresses of a process's internet sockets, as /proc/net shows them: hexadecimal, and :0 where not bound.
std::multiset<std::string> find_local_addresses(pid_t process) {
  const std::set<std::string> inodes = find_socket_inodes(process);
  std::multiset<std::string> addresses;
  for (const char* table : {"udp", "udp6", "tcp", "tcp6"}) {
    std::ifstream file("/proc/" + std::to_string(process) + "/net/" + table);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::istringstream words(line);
      std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
      if (fields.size() > 9 && inodes.count(fields[9])) addresses.insert(fields[1].substr(0, fields[1].find(':')));
    }
  }
  return addresses;
}

class Sockets : public ::testing::TestWithParam<const char*> {};

TEST_P(Sockets, OfEveryProcessAreBoundToLoopbackOnly) {
  const std::string vendor = GetParam();
  ScenarioChange change;
  change.steps = "{time_step: 0.001, control_period: 0.005, duration: 0}";
  ServerSet set("sockets-" + vendor,
                {write_scenario("sockets", change), "--dds", vendor, "--realtime", "--view", "--quiet"});
  const std::string domain = std::to_string(set.find_domain());
  Program echo({"hrp-topic", "--domain", domain, "--dds", vendor, "echo", "hrp/robot_state"});
  ASSERT_TRUE(set.wait_for_step(100)) << set.output();
  ASSERT_TRUE(wait_until([&] { return !echo.output().empty(); }));
  std::vector<ProcessSeen> processes = find_servers(set.find_domain());
  processes.push_back({set.process_id(), 0, "hrp-simulate"});
  ASSERT_GE(processes.size(), 9u) << "six servers, viewer, hrp-topic, launcher";
  for (const ProcessSeen& process : processes) {
    const auto addresses = find_local_addresses(process.process_id);
    EXPECT_FALSE(addresses.empty()) << process.command;
    for (const std::string& address : addresses) EXPECT_EQ(address, "0100007F") << process.command;  // 127.0.0.1
  }
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}
INSTANTIATE_TEST_SUITE_P(Both, Sockets, ::testing::Values("cyclone", "fast"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace hrp::test
