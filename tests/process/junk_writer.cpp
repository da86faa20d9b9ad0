// SPDX-License-Identifier: BSD-3-Clause
// Somebody who writes junk: junk_writer VENDOR DOMAIN SEED TOPIC ... Each sample that others write there comes again
// with bits of it changed, cut off or grown; and bytes drawn at random come all the time. Ends with SIGTERM.
#include <sys/prctl.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <thread>

#include "common/bus/make_bus.h"
#include "common/messages/topics.h"

namespace {

constexpr size_t kLongest = 512;  // [B] of what is drawn
constexpr unsigned kEcho = 8;     // one sample in so many comes again; our own are heard, too, so one would be too few

class Junk {
 public:
  Junk(hrp::Bus& bus, const hrp::TopicSpec& topic, unsigned seed) : random_(seed), writer_(bus.make_writer(topic)) {
    reader_ = bus.make_reader(topic, hrp::Delivery::kReliable, [this](hrp::Bytes sample) { repeat(sample); });
  }

  void draw() {
    // A header that promises little-endian CDR, as our own: without it nobody reads on.
    std::vector<uint8_t> bytes{0, 1, 0, 0};
    bytes.resize(4 + random_() % kLongest);
    for (size_t i = 4; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(random_());
    write(bytes);
  }

 private:
  void repeat(hrp::Bytes sample) {
    if (random_() % kEcho != 0) return;
    std::vector<uint8_t> bytes(sample.data, sample.data + sample.size);
    for (unsigned flips = 1 + random_() % 8; flips > 0 && bytes.size() > 4; --flips) {
      bytes[4 + random_() % (bytes.size() - 4)] ^= static_cast<uint8_t>(1u << random_() % 8);
    }
    if (random_() % 4 == 0) bytes.resize(4 + random_() % (2 * bytes.size()));
    write(bytes);
  }

  void write(std::vector<uint8_t> bytes) {
    bytes.resize((bytes.size() + 3) & ~size_t{3});
    writer_->write({bytes.data(), bytes.size()});
  }

  std::mt19937 random_;
  std::unique_ptr<hrp::Writer> writer_;
  std::unique_ptr<hrp::Reader> reader_;  // ends first: it writes
};

}  // namespace

int main(int argc, char** argv) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (argc < 5) return 2;
  hrp::BusOptions options;
  options.vendor = argv[1];
  options.domain = std::atoi(argv[2]);
  const auto bus = hrp::make_bus(options);
  std::vector<std::unique_ptr<Junk>> junk;
  for (int i = 4; i < argc; ++i) {
    const hrp::TopicSpec* topic = hrp::topics::find_known_topic(argv[i]);
    if (!topic) return 2;
    junk.push_back(std::make_unique<Junk>(*bus, *topic, static_cast<unsigned>(std::atoi(argv[3]) + i)));
  }
  std::puts("writes");
  std::fflush(stdout);
  while (true) {
    {
      std::lock_guard<std::recursive_mutex> lock(bus->mutex());
      for (const auto& each : junk) each->draw();
    }
    bus->spin(std::chrono::milliseconds(1));
  }
}
