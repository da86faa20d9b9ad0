// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/imu_over_legs.h"

#include <cmath>
#include <map>
#include <utility>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/estimate/blocks.h"

namespace hrp::diagnosis::floating {
std::vector<Standing> list_standing(const LeggedLog& log, size_t imu, Purpose purpose) {
  std::vector<Standing> out;
  const ImuSensor& sensor = log.imus[imu];
  if (!sensor.gyro) return out;
  walk(log, purpose, [&](const Clip& clip, size_t k, BodyMotion* motion) {
    Standing s{{&clip, k},
               list_standing_feet(log, motion),
               get_pose(motion->data(), sensor.link).R * sensor.R_LI,
               get_velocity(motion->data(), sensor.link).head<3>() - get_velocity(motion->data(), 0).head<3>()};
    if (s.feet.empty()) return;
    if (!sensor.accelerometer) forget_up(&s.feet);
    out.push_back(std::move(s));
  });
  if (!is_enough(purpose, out.size())) out.clear();
  return out;
}

std::vector<Instant> list_instants(const std::vector<Standing>& standing) {
  std::vector<Instant> out;
  for (const Standing& s : standing) out.push_back(s.at);
  return out;
}

std::vector<double> list_left(const LeggedLog& log, size_t imu, const std::vector<Standing>& standing,
                              const Taken& taken) {
  const double g = taken.per_unit * log.experiment->scenario.gravity_W.norm();
  std::vector<double> left;
  for (const Standing& s : standing) {
    const size_t k = shift(s.at.k, taken.clock, *s.at.clip, log);
    const ImuTracks& tracks = s.at.clip->imus[imu];
    const Vector3d rate = s.R_BI * (taken.axes.gyro * get_values(tracks.gyro, k)) - s.more;
    left.push_back(std::sqrt(
        calc_left(s.feet, rate, s.R_BI * (taken.axes.accelerometer * get_values(tracks.accelerometer, k)) / g)));
  }
  return left;
}

Left measure_over_legs(const LeggedLog& log, size_t imu, double per_unit, const std::vector<Standing>& standing) {
  return [&log, &standing, imu, per_unit](const Matrix3d& R, const Clock& clock) {
    const std::vector<double> left = list_left(log, imu, standing, {{R, R}, clock, per_unit});
    const double mean = calc_mean(left);
    return mean * mean + 1.0;
  };
}

double find_square(const std::vector<double>& left) {
  const double mean = calc_mean(left);
  return (1.0 + mean) * (1.0 + mean);
}

double calc_odds(const std::vector<Instant>& at, const std::vector<double>& left_a, const std::vector<double>& left_b) {
  std::vector<std::pair<const Clip*, long>> blocks;
  for (const auto& [clip, k] : at)
    blocks.emplace_back(clip, std::lround(std::floor((clip->time[k] - clip->time.front()) / kBlock)));
  return calc_odds_by_block(blocks, left_a, left_b);
}

}  // namespace hrp::diagnosis::floating
