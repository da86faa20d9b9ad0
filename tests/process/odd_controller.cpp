// SPDX-License-Identifier: BSD-3-Clause
// Controllers that do what controllers should not do, from a given step on.
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "common/messages/topics.h"
#include "common/node/node_base.h"
#include "common/node/runner.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"

namespace hrp {
namespace {

class OddController : public NodeBase {
 public:
  OddController(const NodeContext& context, const std::string& mode, uint64_t from)
      : NodeBase(context),
        mode_(mode),
        from_(from),
        publisher_(bus(), topics::of_robot(topics::kJointCommands, context.robot)) {
    listen<msg::SensorData>(topics::of_robot(topics::kSensorData, context.robot),
                            [this](const msg::SensorData& m) { take(m); });
  }

 private:
  void take(const msg::SensorData& sensors) {
    if (sensors.header().step() == 0) rest_ = sensors.positions();
    msg::JointCommands answer;
    answer.header(sensors.header());
    answer.positions(rest_);
    if (sensors.header().step() >= from_) {
      if (mode_ == "silent") return;
      if (mode_ == "nan") answer.positions()[0] = std::nan("");
      if (mode_ == "short") answer.positions().pop_back();
      if (mode_ == "stale") answer.header().step(sensors.header().step() - 10);
    }
    if (mode_ == "sleepy") std::this_thread::sleep_for(std::chrono::microseconds(random_() % 8000));
    publisher_.publish(answer);
  }

  std::string mode_;
  uint64_t from_;
  std::vector<double> rest_;
  std::mt19937 random_{12345};
  Publisher<msg::JointCommands> publisher_;
};

}  // namespace
}  // namespace hrp

// The mode comes from the program's name, because hrp-simulate --program takes no arguments: hrp-odd-controller-nan ...
int main(int argc, char** argv) {
  const std::string name = argv[0];
  const std::string mode = name.substr(name.rfind('-') + 1);
  return hrp::run_server(
      argc, argv, {"controller", "hrp-odd-controller-" + mode, "For tests."},
      [&](const hrp::NodeContext& context) { return std::make_unique<hrp::OddController>(context, mode, 100); });
}
