// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_rivals.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/series.h"

namespace hrp::diagnosis {
namespace {

// A joint's quantity over all recordings, and its rate over a tenth of a second, so that noise is no speed.
struct Sizes {
  Spread value, rate;
};

Sizes find_sizes(const Experiment& e, int joint, Quantity quantity) {
  Sizes out;
  const auto stride = static_cast<size_t>(std::max(1L, std::lround(0.1 / e.sample_time)));
  for (const Recording& r : e.recordings) {
    const std::vector<double>& x = r.joints[static_cast<size_t>(joint)].signal[static_cast<size_t>(quantity)];
    for (size_t k = 0; k < x.size(); ++k) {
      out.value.add(x[k]);
      if (k >= stride) out.rate.add((x[k] - x[k - stride]) / (r.time[k] - r.time[k - stride]));
    }
  }
  return out;
}

Json make_effect(const char* name, const std::string& joint, const Json& values) {
  Json parameters = Json::object();
  for (const auto& [key, value] : values.items()) parameters[key] = {{"value", value}};
  return {{"effect", name}, {"where", {{"joint", joint}}}, {"parameters", parameters}};
}

}  // namespace

std::vector<Riddle> list_riddles(const Experiment& experiment, const Json& report) {
  std::vector<Riddle> list;
  const Json signals = report.value("fit", Json::object()).value("per_signal", Json::object());
  for (const Json& entry : report.value("unexplained", Json::array())) {
    const std::string joint = entry.value("where", Json::object()).value("joint", "");
    const int index = joint.empty() ? -1 : experiment.robot.tree.find_joint(joint);
    if (index < 0) continue;
    const Json left =
        signals.value(experiment.signal_name(index, Quantity::kEffort), Json::object()).value("after", Json());
    if (!left.is_number()) continue;
    const double missing =
        left.get<double>() *
        find_sizes(experiment, index, Quantity::kEffort).value.get();  // reports state shares of the spread
    if (missing > 0.0) list.push_back({joint, missing});
  }
  return list;
}

Json list_joint_rivals(const Experiment& experiment, const Riddle& riddle) {
  const int j = experiment.robot.tree.find_joint(riddle.joint);
  const Sizes q = find_sizes(experiment, j, Quantity::kPosition);
  const double speed = q.rate.get_rms(), travel = q.value.get(),
               effort = find_sizes(experiment, j, Quantity::kEffort).value.get_rms();
  Json list = Json::array();
  if (!(speed > 0.0) || !(travel > 0.0)) return list;
  list.push_back(make_effect("coulomb_friction", riddle.joint, {{"level", riddle.missing}}));
  list.push_back(make_effect("viscous_friction", riddle.joint, {{"coefficient", riddle.missing / speed}}));
  list.push_back(make_effect("parallel_spring", riddle.joint,
                             {{"stiffness", riddle.missing / travel}, {"rest", q.value.get_mean()}}));
  if (effort > riddle.missing)
    list.push_back(make_effect("torque_constant_error", riddle.joint, {{"scale", 1.0 - riddle.missing / effort}}));
  return list;
}

}  // namespace hrp::diagnosis
