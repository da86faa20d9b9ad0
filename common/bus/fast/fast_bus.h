// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/bus/make_bus.h"

namespace hrp {

// Fast DDS over UDP only: its shared memory leaves segments behind when a process is killed.
class FastBus : public Bus {
 public:
  explicit FastBus(const BusOptions& options);
  ~FastBus() override;
  std::unique_ptr<Writer> make_writer(const TopicSpec& topic) override;
  std::unique_ptr<Reader> make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) override;
  // That of rmw_fastrtps: the identity of a request goes beside the sample, not in it.
  std::unique_ptr<Service> make_service(const ServiceSpec& service, ServiceCallback callback) override;
  std::vector<TopicSeen> find_topics() override;
  std::string vendor() const override { return "fast"; }
  void spin(std::chrono::milliseconds timeout) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hrp
