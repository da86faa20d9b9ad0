// SPDX-License-Identifier: BSD-3-Clause
// What the sensors of a robot say during one motion, and where it comes from: a run in this process, a log of the
// server set, or a table of an experiment folder.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp::identification {

using Samples = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;  // channels x samples

// One chest IMU, one force sensor a foot. Nothing in it comes from the simulator's state.
struct RobotLog {
  std::string name;
  double period = 0.0;              // [s] between samples
  std::vector<std::string> joints;  // driven joints
  Samples q;                        // [rad] encoders, joints x samples
  Samples gyro, accelerometer;      // [rad/s], [m/s^2] specific force; 3 x samples, sensor axes
  Samples effort;                   // [N m] of the drives, joints x samples; empty when it was not recorded
  std::vector<Samples> wrenches;    // by foot: force [N], torque [N m] as the sensor gives them; 6 x samples
  Eigen::Index size() const { return q.cols(); }
};

// Feet and their force sensors, in the order of Scenario::feet: index of each one's sensor. Throws InputError.
std::vector<int> find_foot_sensors(const Scenario& scenario);

// The first one: of the chest. Throws InputError when there is none.
const ImuSpec& find_imu(const Scenario& scenario);

// Runs a scenario in this process, bush and all; samples once a control period. Throws std::runtime_error when the
// simulation fails or the robot falls. `on_sample` may look at the true state (for tests and for checking a motion).
struct TrueSample {
  const State* state;
  const TreeSpec* tree;
  const std::vector<double>* foot_forces;
};
RobotLog run_in_process(const Scenario& scenario, const std::function<void(double, const TrueSample&)>& on_sample = {});

// A log of ours (MCAP). Throws std::runtime_error.
RobotLog read_mcap(const std::string& path);
// A table with the columns of experiment folders. Resampled to a constant period. Throws InputError.
RobotLog read_table(const std::string& path, const Scenario& scenario);

// The same scenario with perfect sensors.
Scenario without_sensor_errors(Scenario scenario);

// Adds the sensor errors of `scenario` with another seed to a log without any, as the simulator does.
RobotLog add_noise(const RobotLog& clean, const Scenario& scenario, unsigned long long seed);

}  // namespace hrp::identification
