// SPDX-License-Identifier: BSD-3-Clause
// Everything a controller of one's own needs: sensor data in, joint commands out. On a robot the same class runs
// against drives and sensors; it knows nothing of the simulator.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"
#include "common/spatial/gravity.h"

namespace hrp {

// What a controller may know of its robot. Arrays are in the order of joints.
struct Robot {
  std::string name;
  std::vector<std::string> joints;
  Eigen::VectorXd lower, upper;                         // [rad or m] infinite when unlimited
  Eigen::VectorXd effort_limit;                         // [N m or N]
  Eigen::VectorXd initial_q;                            // [rad or m] pose at the start of the run
  std::vector<std::string> imus;                        // names, in the order of SensorData::imus
  std::vector<std::string> wrenches;                    // names, in the order of SensorData::wrenches
  double period = 0.0;                                  // [s] between two samples = between two commands
  Eigen::Vector3d gravity_W{0.0, 0.0, -kGravity};       // [m/s^2]
  ControllerSpec settings;                              // the section `controller` of the scenario
  SensorsSpec sensors;                                  // where the sensors sit
  std::shared_ptr<const RobotDescription> description;  // tree of links, shapes of the soles
  // Index of a joint, -1 when there is none of this name.
  int find_joint(const std::string& joint) const;
};

// One sample of all sensors: q, qd, effort, imus, wrenches (common/robot/signals.h), and when it was taken.
struct SensorData : SensorSample {
  double time = 0.0;            // [s] since the start of the run
  unsigned long long step = 0;  // physics step
};

class Controller {
 public:
  virtual ~Controller() = default;
  // Before the first sample, and again when the run is reset.
  virtual void start(const Robot& robot) { (void)robot; }
  // The answer to one sample: references of the joint servos for the period that begins with it. qd and effort may
  // stay empty.
  virtual JointCommand control(const SensorData& sensors, const Robot& robot) = 0;
  // A copy with all memory, for runs that go back to an earlier state. None: this controller cannot.
  virtual std::unique_ptr<Controller> clone() const { return nullptr; }
};

using ControllerMaker = std::function<std::unique_ptr<Controller>(const Robot& robot)>;

// The main of a controller process: finds the run (or --run, --domain, --dds), then answers until the run ends. Returns
// an exit code.
int run_controller(int argc, char** argv, const std::string& program, const ControllerMaker& make_controller);

}  // namespace hrp
