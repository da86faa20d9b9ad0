// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/bus/make_bus.h"

namespace hrp {

// Cyclone DDS, answered from its receive thread: the thread that gets a packet runs the callback, which is the shortest
// way between two processes.
class CycloneBus : public Bus {
 public:
  explicit CycloneBus(const BusOptions& options);
  ~CycloneBus() override;
  std::unique_ptr<Writer> make_writer(const TopicSpec& topic) override;
  std::unique_ptr<Reader> make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) override;
  std::vector<TopicSeen> find_topics() override;
  std::string vendor() const override { return "cyclone"; }
  void spin(std::chrono::milliseconds timeout) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hrp
