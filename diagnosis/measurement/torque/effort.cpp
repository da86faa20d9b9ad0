// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/effort.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/servo_gains.h"

namespace hrp::diagnosis {

EffortSource find_effort_source(const Experiment& e, size_t j) {
  const JointSpec& joint = e.robot.tree.joint(static_cast<int>(j));
  if (!joint.actuated) return EffortSource::kRecorded;  // without a drive: y = 0
  bool effort = true, command = true, learnt = false;
  for (const Recording& r : e.recordings) {
    const bool logged = r.joints[j].has(Quantity::kEffort);
    effort = effort && logged;
    learnt = learnt || (logged && r.spec.train);
    command = command && !r.joints[j].command.empty();
  }
  if (effort) return EffortSource::kRecorded;
  if (command && e.scenario.drive == "servo" && get_servo_gains(e.scenario, joint.name).kp > 0.0)
    return EffortSource::kServoLaw;
  return learnt ? EffortSource::kRecorded : EffortSource::kNone;
}

std::string describe_unlogged(const Experiment& e, int joint, EffortSource source) {
  if (source == EffortSource::kServoLaw || !e.robot.tree.joint(joint).actuated) return "";
  std::string files;
  for (const Recording& r : e.recordings) {
    const bool told = source == EffortSource::kRecorded && r.joints[static_cast<size_t>(joint)].has(Quantity::kEffort);
    if (!told) files += (files.empty() ? "" : ", ") + r.spec.name;
  }
  if (files.empty()) return "";
  const std::string what = files + ": no column " + e.signal_name(joint, Quantity::kEffort) + " that changes";
  if (source == EffortSource::kRecorded) return what + ": of this joint's drive the other recordings tell";
  return what + (e.scenario.drive == "servo" ? ", and no command with gains" : "") +
         ": nothing is said of this joint's drive; if nothing drives it, list it under 'unactuated'";
}

std::string name_servo_rate(size_t joint) { return "/servo_rate/" + std::to_string(joint); }

ServoSeries calc_servo(const Recording& r, size_t j, const JointLaws& laws, const std::vector<double>& rate) {
  const size_t rows = r.size();
  ServoSeries out{std::vector<double>(rows), std::vector<double>(rows, 0.0)};
  std::vector<double> given(rows), speed(rows);
  for (size_t k = 0; k < rows; ++k) read_command(r.time, r.joints[j], r.time[k], k, &given[k], &speed[k]);
  for (size_t k = 0; k < rows; ++k) {
    const double effort = calc_servo_effort(laws, given[k] - r.joints[j].signal[0][k], speed[k] - rate[k], 0.0);
    out.effort[k] = std::clamp(effort, -laws.effort_limit, laws.effort_limit);
    const size_t a = k > 0 ? k - 1 : 0, b = std::min(rows - 1, k + 1);
    const bool limited = std::abs(out.effort[k]) >= laws.effort_limit;  // false where a reading is missing
    if (b > a && !limited)
      out.command_rate[k] =
          (laws.kp * (given[b] - given[a]) + laws.kd * (speed[b] - speed[a])) / (r.time[b] - r.time[a]);
  }
  return out;
}

}  // namespace hrp::diagnosis
