// SPDX-License-Identifier: BSD-3-Clause
// Logs of the server set and tables of experiment folders as sensor data.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/mcap/reader.h"
#include "common/messages/cdr.h"
#include "common/messages/convert.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "diagnosis/data/csv.h"
#include "diagnosis/identification/robot_log.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"

namespace hrp::identification {
namespace {

struct Sample {
  double time;
  SensorSample sensors;
};

void fill_log(const std::vector<Sample>& samples, const std::vector<int>& feet, RobotLog* log) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  log->q.resize(static_cast<Eigen::Index>(log->joints.size()), n);
  log->effort.resize(log->q.rows(), n);
  log->gyro.resize(3, n);
  log->accelerometer.resize(3, n);
  log->wrenches.assign(feet.size(), Samples(6, n));
  for (Eigen::Index k = 0; k < n; ++k) {
    const SensorSample& s = samples[static_cast<size_t>(k)].sensors;
    const auto has_wrench = [&](int foot) { return static_cast<size_t>(foot) < s.wrenches.size(); };
    if (s.q.size() != log->q.rows() || s.effort.size() != s.q.size() || s.imus.empty() ||
        !std::all_of(feet.begin(), feet.end(), has_wrench))
      throw std::runtime_error(log->name + ": samples do not fit its robot");
    log->q.col(k) = s.q;
    log->effort.col(k) = s.effort;
    log->gyro.col(k) = s.imus[0].angular_velocity;
    log->accelerometer.col(k) = s.imus[0].linear_acceleration;
    for (size_t f = 0; f < feet.size(); ++f) {
      const WrenchSample& wrench = s.wrenches[static_cast<size_t>(feet[f])];
      log->wrenches[f].col(k) << wrench.force, wrench.torque;
    }
  }
}

// Values of a column at times a constant period apart; gaps and missing cells are bridged by straight lines.
Eigen::VectorXd resample(const std::vector<double>& time, const std::vector<double>& column, double period,
                         Eigen::Index n, const InputPlace& place) {
  std::vector<std::pair<double, double>> known;
  for (size_t i = 0; i < time.size(); ++i) {
    if (std::isfinite(column[i]) && std::isfinite(time[i]) && (known.empty() || time[i] > known.back().first))
      known.push_back({time[i], column[i]});
  }
  if (known.size() < 2)
    refuse_input(place, "holds " + std::to_string(known.size()) + " numbers at rising times, expected at least 2");
  Eigen::VectorXd values(n);
  size_t at = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double t = time.front() + period * static_cast<double>(k);
    while (at + 2 < known.size() && known[at + 1].first < t) ++at;
    const double s = std::clamp((t - known[at].first) / (known[at + 1].first - known[at].first), 0.0, 1.0);
    values[k] = known[at].second + s * (known[at + 1].second - known[at].second);
  }
  return values;
}

}  // namespace

RobotLog read_mcap(const std::string& path) {
  mcap::Reader reader(path);
  const mcap::Channel* description = reader.find_channel(topics::kRobotDescription.name);
  const mcap::Channel* data = reader.find_channel(topics::kSensorData.name);
  if (description == nullptr || data == nullptr) throw std::runtime_error(path + ": no log of a simulation");
  RobotLog log;
  log.name = path;
  std::vector<int> feet;
  std::vector<Sample> samples;
  msg::SensorData message;
  reader.read_messages(
      [&](const mcap::Message& raw) {
        const Bytes bytes{raw.data, raw.size};
        if (raw.channel_id == description->id) {
          msg::RobotDescription robot;
          decode_logged(bytes, &robot);
          for (const auto& joint : robot.joints()) log.joints.push_back(joint.name());
          feet = find_foot_sensors(parse_scenario(robot.scenario(), robot.scenario_path()));
          return true;
        }
        decode(bytes, &message);
        if (message.header().step() == 0) return true;  // no force has acted yet
        samples.push_back({message.header().time(), {}});
        from_message(message, &samples.back().sensors);
        return true;
      },
      {topics::kRobotDescription.name, topics::kSensorData.name});
  if (samples.size() < 2) throw std::runtime_error(path + ": holds no sensor data");
  log.period = (samples.back().time - samples.front().time) / static_cast<double>(samples.size() - 1);
  fill_log(samples, feet, &log);
  return log;
}

RobotLog read_table(const std::string& path, const Scenario& scenario) {
  std::vector<std::string> warnings;
  const diagnosis::Table table = diagnosis::read_csv(path, &warnings);
  const auto column = [&](const std::string& name) -> const std::vector<double>& {
    const int found = table.find(name);
    if (found < 0) refuse_input({path, "", 1}, "has no column '" + name + "'");
    return table.columns[static_cast<size_t>(found)];
  };
  const std::vector<double>& time = column("time");
  if (time.size() < 2 || !(time.back() > time.front())) refuse_input({path, "time"}, "times do not rise");
  RobotLog log;
  log.name = path;
  log.period = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  const auto n = static_cast<Eigen::Index>(time.size());
  const auto read = [&](const std::string& name) {
    return resample(time, column(name), log.period, n, {path, name}).transpose().eval();
  };
  const std::string head = "/joint_states/", tail = "/position", axes = "xyz";
  for (const std::string& name : table.names) {
    if (name.size() > head.size() + tail.size() && name.compare(0, head.size(), head) == 0 && ends_with(name, tail)) {
      log.joints.push_back(name.substr(head.size(), name.size() - head.size() - tail.size()));
    }
  }
  log.q.resize(static_cast<Eigen::Index>(log.joints.size()), n);
  for (size_t j = 0; j < log.joints.size(); ++j)
    log.q.row(static_cast<Eigen::Index>(j)) = read(head + log.joints[j] + tail);
  const auto has_effort = [&](const std::string& joint) { return table.find(head + joint + "/effort") >= 0; };
  if (std::all_of(log.joints.begin(), log.joints.end(), has_effort)) {
    log.effort.resize(log.q.rows(), n);
    for (size_t j = 0; j < log.joints.size(); ++j)
      log.effort.row(static_cast<Eigen::Index>(j)) = read(head + log.joints[j] + "/effort");
  }
  log.gyro.resize(3, n);
  log.accelerometer.resize(3, n);
  const std::string imu = "/imu/" + find_imu(scenario).name;
  for (int i = 0; i < 3; ++i) {
    log.gyro.row(i) = read(imu + "/angular_velocity/" + axes[static_cast<size_t>(i)]);
    log.accelerometer.row(i) = read(imu + "/linear_acceleration/" + axes[static_cast<size_t>(i)]);
  }
  for (int sensor : find_foot_sensors(scenario)) {
    const std::string wrench = "/wrench/" + scenario.sensors.wrenches[static_cast<size_t>(sensor)].name;
    log.wrenches.emplace_back(6, n);
    for (int i = 0; i < 3; ++i) {
      log.wrenches.back().row(i) = read(wrench + "/force/" + axes[static_cast<size_t>(i)]);
      log.wrenches.back().row(3 + i) = read(wrench + "/torque/" + axes[static_cast<size_t>(i)]);
    }
  }
  return log;
}

}  // namespace hrp::identification
