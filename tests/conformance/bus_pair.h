// SPDX-License-Identifier: BSD-3-Clause
// Fixture of the conformance tests: a bus of one vendor here, a peer process on the other vendor there.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/bus/bus.h"
#include "common/bus/domain.h"
#include "common/bus/make_bus.h"
#include "tests/conformance/peer_topics.h"

namespace hrp::conformance {

struct Vendors {
  std::string mine;
  std::string theirs;
};

// A process that is killed at the end.
class PeerProcess {
 public:
  PeerProcess(const std::string& vendor, int domain, const std::string& role,
              const std::vector<std::string>& types = {});
  ~PeerProcess();
  void kill_now();

 private:
  int process_ = 0;
};

class BusPair : public ::testing::TestWithParam<Vendors> {
 protected:
  BusPair();
  bool is_memory() const { return GetParam().mine == "memory"; }
  // Starts the peer that answers, and returns when it does. On the memory bus the peer lives on the same bus.
  void start_echo(const std::vector<std::string>& types = {});
  std::unique_ptr<PeerProcess> start_peer(const std::string& role);
  // A second bus of the peer's vendor in this process; the same bus where there is only one.
  Bus& find_other_bus();
  // Runs the bus until `done` holds (under the mutex). Fails the test when that takes so long that it never will.
  void wait_until(const std::function<bool()>& done);

  DomainClaim claim_;
  std::unique_ptr<Bus> other_;  // before bus_: readers of tests are gone by then
  std::unique_ptr<Bus> bus_;

 private:
  std::unique_ptr<PeerProcess> echo_;
  std::vector<std::unique_ptr<Writer>> echo_writers_;
  std::vector<std::unique_ptr<Reader>> echo_readers_;
};

// A sample whose content follows from its number.
std::vector<uint8_t> make_sample(uint32_t number, size_t size);
uint32_t find_number_of(Bytes sample);
bool is_intact(Bytes sample);

}  // namespace hrp::conformance
