// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/command_reader.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {

Moment find_moment(const std::vector<double>& time, double t, size_t near) {
  Moment m;
  m.k = std::min(near, time.size() - 2);
  while (m.k > 0 && time[m.k] > t) --m.k;
  while (m.k + 2 < time.size() && time[m.k + 1] <= t) ++m.k;
  m.s = std::min(1.0, std::max(0.0, (t - time[m.k]) / (time[m.k + 1] - time[m.k])));
  return m;
}

double interpolate(const std::vector<double>& time, const std::vector<double>& values, double t, size_t near) {
  return find_moment(time, t, near).of(values);
}

void move_series(const std::vector<double>& time, double late, std::vector<double>* series) {
  std::vector<double> stamps, logged;
  for (size_t k = 0; k < time.size(); ++k) {
    if (!std::isfinite((*series)[k])) continue;
    stamps.push_back(time[k]);
    logged.push_back((*series)[k]);
  }
  if (stamps.size() < 2) return;
  size_t next = 0;
  for (size_t k = 0; k < time.size(); ++k) {
    if (std::isfinite((*series)[k])) (*series)[k] = interpolate(stamps, logged, time[k] + late, next++);
  }
}

void read_command(const std::vector<double>& time, const JointColumns& joint, double t, size_t near, double* position,
                  double* rate) {
  *position = 0.0;
  *rate = 0.0;
  if (joint.command.empty()) return;
  if (t <= time.front()) {
    *position = joint.command.front();
    return;
  }
  if (t >= time.back()) {
    *position = joint.command.back();
    *rate = joint.command_rate.empty() ? 0.0 : joint.command_rate.back();
    return;
  }
  const Moment m = find_moment(time, t, near);
  if (joint.command_rate.empty()) {
    *position = m.of(joint.command);
    return;
  }
  if (joint.separate_rate) {
    *position = m.of(joint.command);
    *rate = m.of(joint.command_rate);
    return;
  }
  const double h = time[m.k + 1] - time[m.k], s = m.s;
  const double a = joint.command[m.k], b = joint.command[m.k + 1];
  const double da = h * joint.command_rate[m.k], db = h * joint.command_rate[m.k + 1];
  const double c2 = 3.0 * (b - a) - 2.0 * da - db, c3 = 2.0 * (a - b) + da + db;
  *position = a + s * (da + s * (c2 + s * c3));
  *rate = joint.rough_command ? m.of(joint.command_rate) : (da + s * (2.0 * c2 + 3.0 * s * c3)) / h;
}

}  // namespace hrp::diagnosis
