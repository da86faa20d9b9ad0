// SPDX-License-Identifier: BSD-3-Clause
#include "tests/conformance/bus_pair.h"
#include "tests/test_places.h"

#include <chrono>
#include <csignal>
#include <cstring>

#include <spawn.h>
#include <sys/wait.h>

extern char** environ;

namespace hrp::conformance {

PeerProcess::PeerProcess(const std::string& vendor, int domain, const std::string& role,
                         const std::vector<std::string>& types) {
  std::vector<std::string> words{bin_dir() + "/../tests/conformance_peer", vendor, std::to_string(domain), role};
  words.insert(words.end(), types.begin(), types.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int result = posix_spawn(&process_, arguments[0], nullptr, nullptr, arguments.data(), environ);
  if (result != 0) throw std::runtime_error(words[0] + ": " + std::strerror(result));
}

PeerProcess::~PeerProcess() { kill_now(); }

void PeerProcess::kill_now() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  process_ = 0;
}

BusPair::BusPair() {
  BusOptions options;
  options.vendor = GetParam().mine;
  if (!is_memory()) {
    claim_ = claim_free_domain("conformance test");
    options.domain = claim_.domain();
  }
  bus_ = make_bus(options);
}

void BusPair::start_echo(const std::vector<std::string>& types) {
  if (is_memory()) {
    const auto add = [this](const TopicSpec& ask, const TopicSpec& answer) {
      echo_writers_.push_back(bus_->make_writer(answer));
      Writer* writer = echo_writers_.back().get();
      echo_readers_.push_back(
          bus_->make_reader(ask, Delivery::kReliable, [writer](Bytes sample) { writer->write(sample); }));
    };
    add(kLatestAsk, kLatestAnswer);
    for (const std::string& type : types) add(find_typed_ask(type), find_typed_answer(type));
    add(kAsk, kAnswer);
    return;
  }
  echo_ = std::make_unique<PeerProcess>(GetParam().theirs, claim_.domain(), "echo", types);
  // Answered once: both ways are known.
  const auto writer = bus_->make_writer(kAsk);
  bool answered = false;
  const auto reader = bus_->make_reader(kAnswer, Delivery::kReliable, [&](Bytes) { answered = true; });
  const std::vector<uint8_t> sample = make_sample(0, 64);
  wait_until([&] {
    if (!answered) writer->write({sample.data(), sample.size()});
    return answered;
  });
}

std::unique_ptr<PeerProcess> BusPair::start_peer(const std::string& role) {
  return std::make_unique<PeerProcess>(GetParam().theirs, claim_.domain(), role);
}

Bus& BusPair::find_other_bus() {
  if (is_memory()) return *bus_;
  if (!other_) {
    BusOptions options;
    options.vendor = GetParam().theirs;
    options.domain = claim_.domain();
    other_ = make_bus(options);
  }
  return *other_;
}

void BusPair::wait_until(const std::function<bool()>& done) {
  // Far beyond what anything here takes: only an event that never comes ends in this.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (true) {
    {
      std::lock_guard<std::recursive_mutex> lock(bus_->mutex());
      if (done()) return;
    }
    if (std::chrono::steady_clock::now() > end) {
      ADD_FAILURE() << "what was waited for never came";
      return;
    }
    bus_->spin(std::chrono::milliseconds(1));
  }
}

std::vector<uint8_t> make_sample(uint32_t number, size_t size) {
  std::vector<uint8_t> bytes((size + 3) & ~size_t{3}, 0);
  bytes[1] = 1;
  std::memcpy(&bytes[4], &number, 4);
  for (size_t i = 8; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(number * 31 + i);
  return bytes;
}

uint32_t find_number_of(Bytes sample) {
  uint32_t number = 0;
  if (sample.size >= 8) std::memcpy(&number, sample.data + 4, 4);
  return number;
}

bool is_intact(Bytes sample) {
  const std::vector<uint8_t> expected = make_sample(find_number_of(sample), sample.size);
  return expected.size() == sample.size && std::memcmp(expected.data(), sample.data, sample.size) == 0;
}

}  // namespace hrp::conformance
