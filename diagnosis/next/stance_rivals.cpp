// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_rivals.h"

#include <cmath>

namespace hrp::diagnosis {
namespace {

// Mean and standard deviation of a joint's quantity over all recordings, and its rms rate.
struct Moments {
  double mean = 0.0, std = 0.0, rms = 0.0, rate = 0.0;
};

Moments calc_moments(const Experiment& e, int joint, Quantity quantity) {
  double n = 0.0, sum = 0.0, squares = 0.0, rates = 0.0, steps = 0.0;
  for (const Recording& r : e.recordings) {
    const std::vector<double>& x = r.joints[static_cast<size_t>(joint)].signal[static_cast<size_t>(quantity)];
    // Over a tenth of a second, so that noise is no speed.
    const size_t stride = std::max<size_t>(1, static_cast<size_t>(std::lround(0.1 / e.sample_time)));
    for (size_t k = 0; k < x.size(); ++k) {
      if (!std::isfinite(x[k])) continue;
      n += 1.0, sum += x[k], squares += x[k] * x[k];
      if (k < stride || !std::isfinite(x[k - stride])) continue;
      rates += std::pow((x[k] - x[k - stride]) / (r.time[k] - r.time[k - stride]), 2), steps += 1.0;
    }
  }
  if (n == 0.0) return {};
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean)), std::sqrt(squares / n), std::sqrt(rates / std::max(1.0, steps))};
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
    const Json left = signals.value(experiment.signal_name(index, Quantity::kEffort), Json::object()).value("after", Json());
    if (!left.is_number()) continue;
    const double missing = left.get<double>() * calc_moments(experiment, index, Quantity::kEffort).std;  // reports state shares of the spread
    if (missing > 0.0) list.push_back({joint, missing});
  }
  return list;
}

Json list_joint_rivals(const Experiment& experiment, const Riddle& riddle) {
  const int j = experiment.robot.tree.find_joint(riddle.joint);
  const Moments q = calc_moments(experiment, j, Quantity::kPosition), effort = calc_moments(experiment, j, Quantity::kEffort);
  Json list = Json::array();
  if (!(q.rate > 0.0) || !(q.std > 0.0)) return list;
  list.push_back(make_effect("coulomb_friction", riddle.joint, {{"level", riddle.missing}}));
  list.push_back(make_effect("viscous_friction", riddle.joint, {{"coefficient", riddle.missing / q.rate}}));
  list.push_back(make_effect("parallel_spring", riddle.joint, {{"stiffness", riddle.missing / q.std}, {"rest", q.mean}}));
  if (effort.rms > riddle.missing) list.push_back(make_effect("torque_constant_error", riddle.joint, {{"scale", 1.0 - riddle.missing / effort.rms}}));
  return list;
}

}  // namespace hrp::diagnosis
