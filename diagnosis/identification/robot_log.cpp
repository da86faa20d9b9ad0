// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/robot_log.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/noise.h"
#include "servers/console/trial/trial.h"
#include "servers/dynamics/sensors.h"

namespace hrp::identification {
namespace {

// Which entries of the simulator's arrays are sensors of the robot: a bush has no encoder.
std::vector<int> find_driven(const TreeSpec& tree) {
  std::vector<int> driven;
  for (int i = 0; i < tree.num_joints(); ++i) {
    if (tree.joint(i).actuated) driven.push_back(i);
  }
  return driven;
}

}  // namespace

std::vector<int> find_foot_sensors(const Scenario& scenario) {
  std::vector<int> sensors;
  for (const std::string& foot : scenario.feet) {
    int found = -1;
    for (size_t i = 0; i < scenario.sensors.wrenches.size(); ++i) {
      if (scenario.sensors.wrenches[i].link == foot) found = static_cast<int>(i);
    }
    if (found < 0)
      throw InputError(scenario.make_diagnostic("sensors.wrench", "no force sensor at foot '" + foot + "'"));
    sensors.push_back(found);
  }
  return sensors;
}

const ImuSpec& find_imu(const Scenario& scenario) {
  if (scenario.sensors.imus.empty())
    throw InputError(scenario.make_diagnostic("sensors.imu", "the bush's angles need an IMU"));
  return scenario.sensors.imus[0];
}

RobotLog run_in_process(const Scenario& scenario, const std::function<void(double, const TrueSample&)>& on_sample) {
  find_imu(scenario);
  Trial trial(scenario);
  const std::vector<int> sensors = find_foot_sensors(scenario), driven = find_driven(trial.robot().tree);
  const long steps = std::lround(scenario.duration / scenario.time_step);
  RobotLog log;
  log.name = scenario.path;
  log.period = scenario.time_step * scenario.control_period;
  for (int joint : driven) log.joints.push_back(trial.robot().tree.joint(joint).name);
  const Eigen::Index n = steps / scenario.control_period;
  log.q.resize(static_cast<Eigen::Index>(driven.size()), n);
  log.effort.resize(log.q.rows(), n);
  log.gyro.resize(3, n);
  log.accelerometer.resize(3, n);
  log.wrenches.assign(sensors.size(), Samples(6, n));
  for (long k = 0, at = 0; at < n; ++k) {
    if (!trial.step()) throw std::runtime_error(scenario.path + ": the simulation failed");
    if ((k + 1) % scenario.control_period != 0) continue;
    const SensorSample& sample = trial.engine().sensors();
    for (size_t j = 0; j < driven.size(); ++j) {
      log.q(static_cast<Eigen::Index>(j), at) = sample.q[driven[j]];
      log.effort(static_cast<Eigen::Index>(j), at) = sample.effort[driven[j]];
    }
    log.gyro.col(at) = sample.imus[0].angular_velocity;
    log.accelerometer.col(at) = sample.imus[0].linear_acceleration;
    for (size_t f = 0; f < sensors.size(); ++f) {
      const WrenchSample& wrench = sample.wrenches[static_cast<size_t>(sensors[f])];
      log.wrenches[f].col(at) << wrench.force, wrench.torque;
    }
    const State& state = trial.engine().state();
    if (scenario.floating_base && (state.R_WB * Vector3d::UnitZ()).z() < 0.5) {
      throw std::runtime_error(scenario.path + ": the robot fell at " + std::to_string(trial.time()) + " s");
    }
    if (on_sample) on_sample(trial.time(), {&state, &trial.robot().tree, &trial.engine().foot_forces()});
    ++at;
  }
  return log;
}

Scenario without_sensor_errors(Scenario scenario) {
  for (ImuSpec& imu : scenario.sensors.imus) imu.gyro = imu.accelerometer = SensorErrors{};
  for (WrenchSpec& wrench : scenario.sensors.wrenches) wrench.force = wrench.torque = SensorErrors{};
  scenario.sensors.encoders = EncoderSpec{};
  return scenario;
}

RobotLog add_noise(const RobotLog& clean, const Scenario& scenario, unsigned long long seed) {
  RobotLog log = clean;
  const EncoderSpec& encoders = scenario.sensors.encoders;
  const ImuSpec& imu = find_imu(scenario);
  const std::vector<int> sensors = find_foot_sensors(scenario);
  for (Eigen::Index k = 0; k < log.size(); ++k) {
    const auto step = static_cast<unsigned long long>(k);
    for (Eigen::Index j = 0; j < log.q.rows(); ++j) {
      const double noise = encoders.position_noise * calc_noise(seed, static_cast<unsigned long long>(j), step);
      log.q(j, k) = quantise(log.q(j, k) + noise, encoders.position_quantum);
      if (log.effort.size() > 0)
        log.effort(j, k) += encoders.effort_noise * calc_noise(seed, 500 + static_cast<unsigned long long>(j), step);
    }
    log.gyro.col(k) = apply_errors(imu.gyro, log.gyro.col(k), seed, 1000, step);
    log.accelerometer.col(k) = apply_errors(imu.accelerometer, log.accelerometer.col(k), seed, 1010, step);
    for (size_t f = 0; f < sensors.size(); ++f) {
      const WrenchSpec& spec = scenario.sensors.wrenches[static_cast<size_t>(sensors[f])];
      auto column = log.wrenches[f].col(k);
      column.head<3>() = apply_errors(spec.force, column.head<3>(), seed, 1100 + 10 * f, step);
      column.tail<3>() = apply_errors(spec.torque, column.tail<3>(), seed, 1105 + 10 * f, step);
    }
  }
  return log;
}

}  // namespace hrp::identification
