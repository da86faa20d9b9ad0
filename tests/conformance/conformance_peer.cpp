// SPDX-License-Identifier: BSD-3-Clause
// The other process of the conformance tests: conformance_peer VENDOR DOMAIN ROLE [TYPE ...]
//   echo         answers every sample of the ask topics with the same bytes
//   stall        reliable reader that never comes back from its first callback
//   stall-best   the same as a best-effort reader
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>
#include <vector>

#include <sys/prctl.h>

#include "common/bus/make_bus.h"
#include "tests/conformance/peer_topics.h"

namespace {

using namespace hrp::conformance;

class EchoPeer {
 public:
  explicit EchoPeer(hrp::Bus& bus) : bus_(bus) {}
  void add(const hrp::TopicSpec& ask, const hrp::TopicSpec& answer) {
    writers_.push_back(bus_.make_writer(answer));
    hrp::Writer* writer = writers_.back().get();
    readers_.push_back(
        bus_.make_reader(ask, hrp::Delivery::kReliable, [writer](hrp::Bytes sample) { writer->write(sample); }));
  }

 private:
  hrp::Bus& bus_;
  std::vector<std::unique_ptr<hrp::Writer>> writers_;
  std::vector<std::unique_ptr<hrp::Reader>> readers_;
};

[[noreturn]] void sleep_for_ever() {
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

}  // namespace

int main(int argc, char** argv) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (argc < 4) return 2;
  hrp::BusOptions options;
  options.vendor = argv[1];
  options.domain = std::atoi(argv[2]);
  const std::string role = argv[3];
  const auto bus = hrp::make_bus(options);
  if (role == "echo") {
    EchoPeer peer(*bus);
    peer.add(kLatestAsk, kLatestAnswer);
    for (int i = 4; i < argc; ++i) peer.add(find_typed_ask(argv[i]), find_typed_answer(argv[i]));
    peer.add(kAsk, kAnswer);
    sleep_for_ever();
  }
  const auto delivery = role == "stall" ? hrp::Delivery::kReliable : hrp::Delivery::kBestEffort;
  [[maybe_unused]] const auto reader = bus->make_reader(kAsk, delivery, [](hrp::Bytes) { sleep_for_ever(); });
  sleep_for_ever();
}
