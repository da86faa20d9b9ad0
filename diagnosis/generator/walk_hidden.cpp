// SPDX-License-Identifier: BSD-3-Clause
// What may be hidden in a robot that walks. Sizes follow its weight [N] and the length of its legs [m].
#include <cmath>

#include "diagnosis/generator/walk_plan.h"

namespace hrp::cases {
namespace {

using Json = nlohmann::ordered_json;

struct Size {
  double mass, weight, leg, boost;
};

const JointPlan& draw_leg_joint(const RobotPlan& robot, const std::vector<std::string>& taken, Prng& r) {
  static const std::vector<std::string> names{"hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"};
  for (;;) {
    const std::string role = (r.chance(0.5) ? "left_" : "right_") + r.pick(names);
    const int j = find_role(robot, role);
    if (j < 0) continue;
    bool free = true;
    for (const std::string& name : taken) free = free && name != joint(robot, j).name;
    if (free) return joint(robot, j);
  }
}

Json joint_parameters(const std::string& effect, const JointPlan& j, const Size& s, Prng& r) {
  const double torque = s.weight * s.leg * s.boost, inertia = s.mass * s.leg * s.leg * s.boost;
  if (effect == "viscous_friction") return {{"coefficient", tidy(torque * r.log_uniform(0.015, 0.06))}};
  if (effect == "coulomb_friction") return {{"level", tidy(torque * r.log_uniform(0.015, 0.05))}};
  if (effect == "load_dependent_friction") return {{"ratio", tidy(s.boost * r.log_uniform(0.05, 0.25))}};
  if (effect == "rotor_inertia") return {{"inertia", tidy(inertia * r.log_uniform(0.012, 0.05))}};
  if (effect == "command_delay") return {{"delay", std::round(1e4 * s.boost * r.log_uniform(0.004, 0.02)) / 1e4}};
  if (effect == "actuator_lag") return {{"time_constant", tidy(s.boost * r.log_uniform(0.004, 0.015))}};
  if (effect == "torque_constant_error") return {{"scale", tidy(1 + r.sign() * s.boost * r.log_uniform(0.04, 0.2))}};
  if (effect == "joint_offset") return {{"offset", tidy(r.sign() * s.boost * r.log_uniform(0.008, 0.03))}};
  return {{"gap", tidy(s.boost * r.log_uniform(0.006, 0.025))},
          {"stiffness", tidy(j.kp * 20)},
          {"damping", tidy(j.kp * 0.012)},
          {"rotor_inertia", tidy(0.002 * s.mass * s.leg * s.leg)}};
}

Hidden draw_sensor(const std::string& effect, const RobotPlan& robot, const Size& s, Prng& r) {
  const bool imu = r.chance(0.4), second = r.chance(0.5);
  const std::string foot = "/wrench/" + r.pick(robot.feet).wrench, name = "/imu/" + robot.imu;
  const std::string part =
      imu ? name + (second ? "/angular_velocity" : "/linear_acceleration") : foot + (second ? "/torque" : "/force");
  if (effect == "sensor_bias") {
    const double unit = imu ? (second ? 0.02 : 0.3) : (second ? 0.004 * s.weight * s.leg : 0.012 * s.weight);
    return {effect, "sensor", part, {{"value", draw_vector(s.boost * unit * r.log_uniform(0.8, 4), r)}}};
  }
  if (effect == "sensor_scale")
    return {effect, "sensor", part, {{"scale", tidy(1 + r.sign() * s.boost * r.log_uniform(0.03, 0.2))}}};
  const std::string whole = imu ? name : foot;
  if (effect == "sensor_delay")
    return {effect, "sensor", whole, {{"delay", std::round(1e3 * s.boost * r.log_uniform(0.008, 0.03)) / 1e3}}};
  return {effect, "sensor", whole, {{"rpy", draw_vector(s.boost * r.log_uniform(0.03, 0.1), r)}}};
}

std::vector<Hidden> draw_soles(const RobotPlan& robot, const Size& s, Prng& r) {
  const double tilt = s.weight * s.leg * r.log_uniform(1.8, 6) / s.boost;
  const int only = r.chance(0.3) ? r.below(2) : -1;  // one soft sole beside a rigid one
  std::vector<Hidden> out;
  for (int f = 0; f < 2; ++f) {
    if (only >= 0 && f != only) continue;
    const FootPlan& foot = robot.feet[static_cast<std::size_t>(f)];
    out.push_back({"foot_compliance",
                   "foot",
                   robot.links[static_cast<std::size_t>(foot.link)].name,
                   {{"kz", tidy(s.weight * r.uniform(350, 700))},
                    {"cz", tidy(s.weight * r.uniform(1.0, 2.0))},
                    {"k_roll", tidy(tilt * r.uniform(0.6, 0.95))},
                    {"c_roll", tidy(tilt * r.uniform(0.01, 0.025))},
                    {"k_pitch", tidy(tilt * r.uniform(0.95, 1.4))},
                    {"c_pitch", tidy(tilt * r.uniform(0.01, 0.025))},
                    {"center", Vec3{foot.center[0], foot.center[1], foot.center[2]}}}});
  }
  return out;
}

Hidden draw_link_effect(const std::string& effect, const RobotPlan& robot, const Size& s, Prng& r) {
  const LinkPlan& trunk = robot.links[static_cast<std::size_t>(robot.imu_link)];
  const LinkPlan& thigh = robot.links[static_cast<std::size_t>(find_role(robot, "left_hip_pitch")) + 1];
  const LinkPlan& link = effect == "mass_error" && r.chance(0.3) ? thigh : trunk;
  if (effect == "payload") {
    return {effect,
            "link",
            link.name,
            {{"mass", tidy(s.boost * s.mass * r.log_uniform(0.04, 0.15))},
             {"com", Vec3{tidy(link.com[0] + r.uniform(-0.15, 0.1)), tidy(link.com[1] + r.uniform(-0.08, 0.08)),
                          tidy(link.com[2] + r.uniform(-0.05, 0.15))}}}};
  }
  if (effect == "mass_error")
    return {effect,
            "link",
            link.name,
            {{"scale", tidy(1 + (r.chance(0.35) ? -1 : 1) * s.boost * r.log_uniform(0.08, 0.35))}}};
  return {effect, "link", link.name, {{"offset", draw_vector(s.boost * r.log_uniform(0.015, 0.06), r)}}};
}

Hidden draw_unlisted(const std::string& effect, const RobotPlan& robot, const Size& s, Prng& r) {
  const LinkPlan& trunk = robot.links[static_cast<std::size_t>(robot.imu_link)];
  if (effect == "cable") {  // slack at first, then a spring towards its anchor
    const double way = r.uniform(0, 6.283);
    return {effect,
            "link",
            trunk.name,
            {{"anchor", Vec3{tidy(2 * std::cos(way)), tidy(2 * std::sin(way)), tidy(1.5 * s.leg)}},
             {"slack", tidy(r.uniform(0, 0.05))},
             {"stiffness", tidy(s.boost * s.weight * r.log_uniform(0.2, 1.0))}}};
  }
  if (effect == "sticky_sole") {
    const FootPlan& foot = r.pick(robot.feet);
    return {effect,
            "foot",
            robot.links[static_cast<std::size_t>(foot.link)].name,
            {{"pull", tidy(s.boost * s.weight * r.log_uniform(0.05, 0.25))}, {"reach", tidy(r.uniform(0.003, 0.008))}}};
  }
  const std::string side = r.chance(0.5) ? "left_" : "right_";
  int first = find_role(robot, side + "hip_yaw");
  const int roll = find_role(robot, side + "hip_roll");
  if (first < 0 || (roll >= 0 && roll < first)) first = roll;
  return {effect,
          "joint",
          joint(robot, first).name,
          {{"stiffness", tidy(s.weight * s.leg * r.log_uniform(8, 25) / s.boost)},
           {"damping", tidy(s.weight * s.leg * r.uniform(0.02, 0.06))}}};
}

}  // namespace

const std::vector<std::string>& walk_effects() {
  static const std::vector<std::string> names{"foot_compliance",    "foot_compliance",  "rotor_inertia",
                                              "coulomb_friction",   "viscous_friction", "command_delay",
                                              "actuator_lag",       "backlash",         "payload",
                                              "mass_error",         "com_error",        "ground_slope",
                                              "ground_friction",    "joint_offset",     "torque_constant_error",
                                              "sensor_bias",        "sensor_scale",     "sensor_delay",
                                              "sensor_misalignment"};
  return names;
}

const std::vector<std::string>& walk_unknown_effects() {
  static const std::vector<std::string> names{"cable", "sticky_sole", "hip_bend"};
  return names;
}

std::vector<Hidden> draw_walk_hidden(const std::string& effect, const RobotPlan& robot,
                                     const std::vector<std::string>& taken, double boost, Prng& r) {
  const double mass = calc_mass(robot);
  const Size size{mass, 9.81 * mass, robot.leg, boost};
  if (effect == "foot_compliance") return draw_soles(robot, size, r);
  if (effect == "cable" || effect == "sticky_sole" || effect == "hip_bend")
    return {draw_unlisted(effect, robot, size, r)};
  if (effect == "ground_slope") {
    return {{effect,
             "ground",
             "ground",
             {{"roll", tidy(r.sign() * boost * r.log_uniform(0.008, 0.04))},
              {"pitch", tidy(r.sign() * boost * r.log_uniform(0.008, 0.04))}}}};
  }
  if (effect == "ground_friction")
    return {{effect, "ground", "ground", {{"coefficient", tidy(r.uniform(0.06, 0.14) / boost)}}}};
  if (effect.rfind("sensor_", 0) == 0) return {draw_sensor(effect, robot, size, r)};
  if (effect == "payload" || effect == "mass_error" || effect == "com_error")
    return {draw_link_effect(effect, robot, size, r)};
  const JointPlan& j = draw_leg_joint(robot, taken, r);
  return {{effect, "joint", j.name, joint_parameters(effect, j, size, r)}};
}

}  // namespace hrp::cases
