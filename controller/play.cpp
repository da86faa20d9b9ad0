// SPDX-License-Identifier: BSD-3-Clause
#include "controller/play.h"

#include "controller/motion/motion.h"
#include "controller/walking/walk_controller.h"

namespace hrp {
namespace {

class HoldController : public Controller {
 public:
  std::unique_ptr<Controller> clone() const override { return std::make_unique<HoldController>(*this); }
  JointCommand control(const SensorData&, const Robot& robot) override {
    JointCommand command;
    command.q = robot.initial_q;
    return command;
  }
};

// A pure function of time: a player that is restarted in mid-run goes on where the run is.
class MotionController : public Controller {
 public:
  explicit MotionController(const Robot& robot)
      : player_(load_motion(robot.settings.motion, robot.settings.joint_order), robot.joints, robot.initial_q,
                robot.settings.motion) {}

  std::unique_ptr<Controller> clone() const override { return std::make_unique<MotionController>(*this); }

  JointCommand control(const SensorData& sensors, const Robot&) override {
    JointCommand command;
    player_.sample(sensors.time, &command.q, &command.qd);
    return command;
  }

 private:
  MotionPlayer player_;
};

}  // namespace

std::unique_ptr<Controller> make_scenario_controller(const Robot& robot) {
  if (robot.settings.type == "motion") return std::make_unique<MotionController>(robot);
  if (robot.settings.type == "walk") return make_walk_controller(robot);
  return std::make_unique<HoldController>();
}

}  // namespace hrp
