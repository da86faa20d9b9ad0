// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/unlisted.h"

#include <algorithm>

namespace hrp::cases {
namespace {

using Json = nlohmann::ordered_json;

Json friction_like(const std::string& effect, const JointPlan& j, double level, Prng& r) {
  if (effect == "position_dependent_friction") {
    return {{"level", tidy(1.5 * level)},
            {"center", tidy(j.start + r.uniform(-0.2, 0.2))},
            {"width", tidy(r.uniform(0.06, 0.15))}};
  }
  if (effect == "friction_drift") return {{"level", tidy(1.5 * level)}, {"time_constant", tidy(r.uniform(2, 5))}};
  if (effect == "quadratic_drag") return {{"coefficient", tidy(1.5 * level)}};
  return {};
}

Json force_like(const std::string& effect, const JointPlan& j, double boost, double level, Prng& r) {
  if (effect == "mechanical_stop") {
    const double side = r.sign();
    return {{"angle", tidy(j.start + side * r.uniform(0.2, 0.32))},
            {"side", side},
            {"stiffness", tidy(boost * j.kp * r.log_uniform(0.15, 1))}};
  }
  if (effect == "periodic_disturbance") {
    return {
        {"amplitude", tidy(level)}, {"frequency", tidy(r.log_uniform(0.8, 9))}, {"phase", tidy(r.uniform(0, 6.28))}};
  }
  if (effect == "magnetic_detent") {
    return {{"amplitude", tidy(1.5 * level)},
            {"center", tidy(j.start + r.uniform(-0.2, 0.2))},
            {"width", tidy(r.log_uniform(0.02, 0.1))}};
  }
  if (effect == "cubic_spring") return {{"coefficient", tidy(boost * j.kp * r.log_uniform(0.04, 0.3))}};
  return {};
}

Json drive_like(const std::string& effect, const JointPlan& j, double boost, Prng& r) {
  if (effect == "intermittent_slip") {
    return {{"fraction", tidy(r.uniform(0.4, 0.7))},
            {"period", tidy(r.uniform(0.9, 1.7))},
            {"length", tidy(r.uniform(0.1, 0.25))}};
  }
  if (effect == "thermal_torque_loss") {
    // Loss after `time` seconds at a tenth of the limit; the coil cools with its own time constant.
    return {{"loss", tidy(std::min(0.5, boost * r.log_uniform(0.08, 0.3)))},
            {"reference", tidy(0.1 * j.limit)},
            {"heating_time", tidy(r.uniform(2, 6))},
            {"cooling_time", tidy(r.uniform(8, 20))}};
  }
  return {};
}

Json couple(const RobotPlan& robot, const JointPlan& j, double boost, Prng& r) {
  std::string other = j.name;
  while (other == j.name) other = joint(robot, r.below(joint_count(robot))).name;
  const double kp = std::min(j.kp, joint(robot, find_joint(robot, other)).kp);
  return {{"other", other}, {"stiffness", tidy(boost * kp * r.log_uniform(0.006, 0.05))}};
}

}  // namespace

const std::vector<std::string>& unknown_effects() {
  static const std::vector<std::string> names{"mechanical_stop", "position_dependent_friction",
                                              "friction_drift",  "periodic_disturbance",
                                              "quadratic_drag",  "joint_coupling",
                                              "cubic_spring",    "intermittent_slip",
                                              "magnetic_detent", "thermal_torque_loss",
                                              "sprung_mass"};
  return names;
}
const std::vector<std::string>& stand_unknown_effects() {
  static const std::vector<std::string> names{"gust", "sprung_mass", "periodic_disturbance", "joint_coupling",
                                              "position_dependent_friction"};
  return names;
}

Hidden draw_unlisted_of_joint(const std::string& effect, const RobotPlan& robot, const JointPlan& j, double boost,
                              Prng& random) {
  const double level = boost * j.kp * random.log_uniform(0.002, 0.015);
  Json parameters = friction_like(effect, j, level, random);
  if (parameters.empty()) parameters = force_like(effect, j, boost, level, random);
  if (parameters.empty()) parameters = drive_like(effect, j, boost, random);
  if (parameters.empty()) parameters = couple(robot, j, boost, random);
  return {effect, "joint", j.name, parameters};
}

Hidden draw_unlisted_of_body(const std::string& effect, const RobotPlan& robot, double boost, Prng& random) {
  const LinkPlan& link = robot.floating ? robot.links[static_cast<std::size_t>(robot.imu_link)] : robot.links.back();
  if (effect == "gust") {
    return {effect,
            "link",
            link.name,
            {{"amplitude", tidy(boost * link.mass * random.log_uniform(0.2, 1.5))},
             {"frequency", tidy(random.uniform(0.4, 2.0))},
             {"direction", tidy(random.uniform(0, 6.28))}}};
  }
  const Vec3 axis = random.pick(std::vector<Vec3>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  return {effect,
          "link",
          link.name,
          {{"mass", tidy(link.mass * std::min(0.45, boost * random.log_uniform(0.08, 0.35)))},
           {"frequency", tidy(random.uniform(2.5, 9))},
           {"damping_ratio", tidy(random.uniform(0.02, 0.1))},
           {"axis", axis}}};
}

}  // namespace hrp::cases
