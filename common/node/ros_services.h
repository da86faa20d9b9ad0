// SPDX-License-Identifier: BSD-3-Clause
// Services of ROS 2 that steer a run: /run/pause is a std_srvs/srv/SetBool, /run/resume, /run/step and /run/reset are
// std_srvs/srv/Trigger. They know no token: whoever reaches the domain can call them.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/bus/bus.h"
#include "hrp_idl/ros_services.h"
#include "hrp_idl/scheduling.h"

namespace hrp {

struct SteerResult {
  bool success = false;
  std::string message;
};

class RosServices {
 public:
  // `steer` is called back under the bus's mutex. REQUEST_STEP means one step.
  using Steer = std::function<SteerResult(msg::RunRequest)>;
  RosServices(Bus& bus, Steer steer);

 private:
  template <typename Request, typename Response>
  void offer(Bus& bus, const ServiceSpec& service, std::function<msg::RunRequest(const Request&)> find_request);

  Steer steer_;
  std::vector<std::unique_ptr<Service>> services_;
};

}  // namespace hrp
