// SPDX-License-Identifier: BSD-3-Clause
// A controller of one's own. Change control(); everything else is taken care of. To try it, in two terminals:
//   scripts/simulate.sh --without controller
//   build/bin/my-controller                    (finds the run; when there are several, it lists them)
#include <algorithm>
#include <cmath>

#include "controller/client.h"

class MyController : public hrp::Controller {
 public:
  // Once a sample, every robot.period seconds (the scenario's control rate): readings in, servo references out.
  // In:  sensors.q, qd [rad, rad/s], effort [N m], imus[i].R_WS, angular_velocity, linear_acceleration,
  //      wrenches[i].force, torque [N, N m], time [s]; the order of joints is robot.joints.
  // Out: command.q [rad], and if you like command.qd [rad/s] and command.effort [N m], one number per joint.
  hrp::JointCommand control(const hrp::SensorData& sensors, const hrp::Robot& robot) override {
    hrp::JointCommand command;
    command.q = robot.initial_q;
    // As an example: a slow nod of the first joint, faded in, so that the robot can stand while it moves.
    if (command.q.size() > 0)
      command.q[0] += 0.02 * std::min(1.0, sensors.time) * std::sin(2.0 * M_PI * 0.5 * sensors.time);
    return command;
  }
};

int main(int argc, char** argv) {
  return hrp::run_controller(argc, argv, "my-controller",
                             [](const hrp::Robot&) { return std::make_unique<MyController>(); });
}
