// SPDX-License-Identifier: BSD-3-Clause
// A controller that needs pictures: it answers a sample only when it has the picture of the same step, where one is
// due. It moves one joint by what it sees, so that the run has other bits when a picture is late, or missing.
#include <map>

#include "common/messages/topics.h"
#include "common/node/node_base.h"
#include "common/node/runner.h"
#include "common/robot/scenario.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"
#include "hrp_idl/vision.h"

namespace hrp {
namespace {

class LookingController : public NodeBase {
 public:
  explicit LookingController(const NodeContext& context)
      : NodeBase(context), publisher_(bus(), topics::kJointCommands) {
    listen<msg::Pictures>(topics::kPictures, [this](const msg::Pictures& m) {
      pictures_ = m;
      answer();
    });
    listen<msg::SensorData>(topics::kSensorData, [this](const msg::SensorData& m) {
      sensors_ = m;
      has_sensors_ = true;
      answer();
    });
    listen<msg::RobotDescription>(topics::kRobotDescription, [this](const msg::RobotDescription& m) {
      scenario_ = parse_scenario(m.scenario(), m.scenario_path());
      has_scenario_ = true;
    });
  }

 private:
  bool is_picture_due() const {
    const SensorsSpec& sensors = scenario_.sensors;
    return !find_looking_sensors(sensors.cameras, sensors.lidars, sensors_.header().step(), scenario_.time_step,
                                 scenario_.control_period)
                .empty();
  }
  void answer() {
    if (!has_sensors_ || !has_scenario_) return;
    if (is_picture_due() && (pictures_.samples().empty() || pictures_.header().step() != sensors_.header().step()))
      return;
    if (sensors_.header().step() == 0) rest_ = sensors_.positions();
    msg::JointCommands commands;
    commands.header(sensors_.header());
    commands.positions(rest_);
    commands.positions().back() += 1e-3 * calc_brightness();
    publisher_.publish(commands);
  }
  // Of all bytes of the last pictures, 0 to 1.
  double calc_brightness() const {
    double sum = 0.0, count = 1.0;
    for (const msg::ViewSample& sample : pictures_.samples()) {
      for (const uint8_t byte : sample.bytes()) sum += byte;
      count += static_cast<double>(sample.bytes().size());
    }
    return sum / (255.0 * count);
  }

  Scenario scenario_;
  bool has_scenario_ = false, has_sensors_ = false;
  msg::SensorData sensors_;
  msg::Pictures pictures_;
  std::vector<double> rest_;
  Publisher<msg::JointCommands> publisher_;
};

}  // namespace
}  // namespace hrp

int main(int argc, char** argv) {
  return hrp::run_server(
      argc, argv, {"controller", "hrp-odd-looking-controller", "For tests."},
      [](const hrp::NodeContext& context) { return std::make_unique<hrp::LookingController>(context); });
}
