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
#include <cstring>

#include "tests/process/server_set.h"

namespace hrp::test {
namespace {

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

}  // namespace
}  // namespace hrp::test
