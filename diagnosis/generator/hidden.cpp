// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/hidden.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "common/base/has.h"
#include "diagnosis/generator/joint_effects.h"
#include "diagnosis/generator/unlisted.h"

namespace hrp::cases {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

double tidy(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return std::strtod(text, nullptr);
}

Vec3 draw_vector(double size, Prng& r) {
  return {tidy(size * r.uniform(-1, 1)), tidy(size * r.uniform(-1, 1)), tidy(size * r.uniform(-1, 1))};
}

namespace {

const JointPlan& draw_joint(const RobotPlan& robot, const std::vector<std::string>& taken, Prng& random) {
  for (int attempt = 0; attempt < 50; ++attempt) {
    const JointPlan& j = joint(robot, random.below(joint_count(robot)));
    // In a standing robot only the joints that the motions move; the waist and yaw joints hardly tell.
    const bool moves = !robot.floating || (!j.role.empty() && j.role.find("yaw") == std::string::npos);
    if (moves && !has(taken, j.name)) return j;
  }
  return joint(robot, joint_count(robot) - 1);
}

Json link_parameters(const std::string& effect, const LinkPlan& link, double boost, Prng& r) {
  if (effect == "payload") {
    return {{"mass", tidy(boost * link.mass * r.log_uniform(0.08, 0.7))},
            {"com", Vec3{tidy(link.com[0] + r.uniform(-0.04, 0.04)), tidy(link.com[1] + r.uniform(-0.04, 0.04)),
                         tidy(link.com[2] + r.uniform(-0.03, 0.08))}}};
  }
  if (effect == "mass_error")
    return {{"scale", tidy(1 + (r.chance(0.3) ? -1 : 1) * std::min(0.6, boost * r.log_uniform(0.05, 0.5)))}};
  if (effect == "com_error") {
    const double size = std::min(0.1, boost * r.log_uniform(0.01, 0.08));
    return {
        {"offset", Vec3{tidy(size * r.uniform(-1, 1)), tidy(size * r.uniform(-1, 1)), tidy(size * r.uniform(-1, 1))}}};
  }
  const double size = boost * link.mass * r.log_uniform(0.8, 8);
  return {{"force", Vec3{tidy(size * r.uniform(-1, 1)), tidy(size * r.uniform(-1, 1)), tidy(size * r.uniform(-1, 1))}}};
}

std::vector<Hidden> draw_foot(const std::string& effect, const RobotPlan& robot, double boost, Prng& r) {
  if (effect == "ground_slope") {
    return {{effect,
             "ground",
             "ground",
             {{"roll", tidy(r.sign() * boost * r.log_uniform(0.005, 0.05))},
              {"pitch", tidy(r.sign() * boost * r.log_uniform(0.005, 0.05))}}}};
  }
  if (effect == "ground_friction")
    return {{effect, "ground", "ground", {{"coefficient", tidy(r.uniform(0.03, 0.1) / boost)}}}};
  double weight = 0;
  for (const LinkPlan& link : robot.links) weight += link.mass * 9.81;
  const double tilt = weight * robot.leg * r.log_uniform(1.5, 6) / boost;
  std::vector<Hidden> out;
  for (const FootPlan& foot : robot.feet) {
    Json p{{"kz", tidy(weight * r.uniform(350, 700))},     {"cz", tidy(weight * r.uniform(0.6, 1.1))},
           {"k_roll", tidy(tilt * r.uniform(0.6, 0.95))},  {"c_roll", tidy(tilt * r.uniform(0.007, 0.018))},
           {"k_pitch", tidy(tilt * r.uniform(0.95, 1.4))}, {"c_pitch", tidy(tilt * r.uniform(0.007, 0.018))},
           {"center", Vec3{0, 0, foot.center[2]}}};
    if (effect == "foot_hardening") p["hardening_angle"] = tidy(r.uniform(0.008, 0.02));
    out.push_back({effect, "foot", robot.links[static_cast<std::size_t>(foot.link)].name, p});
  }
  return out;
}

Hidden draw_arm_sensor(const std::string& effect, const RobotPlan& robot, const std::vector<std::string>& taken,
                       double boost, Prng& r) {
  const JointPlan& j = draw_joint(robot, taken, r);
  const std::string base = "/joint_states/" + j.name;
  const bool velocity = r.chance(0.25);
  if (effect == "sensor_bias") {
    const double size = velocity ? r.log_uniform(0.01, 0.1) : j.kp * r.log_uniform(0.002, 0.02);
    return {effect, "sensor", base + (velocity ? "/velocity" : "/effort"), {{"value", tidy(r.sign() * boost * size)}}};
  }
  if (effect == "sensor_scale")
    return {effect,
            "sensor",
            base + (velocity ? "/velocity" : "/effort"),
            {{"scale", tidy(1 + r.sign() * std::min(0.4, boost * r.log_uniform(0.03, 0.3)))}}};
  if (effect == "sensor_delay")
    return {effect,
            "sensor",
            base + (r.chance(0.5) ? "/effort" : "/position"),
            {{"delay", std::round(1e4 * std::min(0.05, boost * r.log_uniform(0.003, 0.03))) / 1e4}}};
  throw std::invalid_argument("no such sensor effect for an arm: " + effect);
}

// Sensors behind the gears of a robot on a fixed base.
bool has_link_sensors(const RobotPlan& robot) {
  return robot.joint_torques || robot.link_encoders || !robot.imu.empty() || !robot.wrist.empty();
}

Hidden draw_link_sensor(const std::string& effect, const RobotPlan& robot, double boost, Prng& r) {
  struct Part {
    std::string sensor, reading;
    double bias;  // [unit of the reading]
  };
  std::vector<Part> parts;
  const JointPlan& j = joint(robot, r.below(joint_count(robot)));
  const std::string base = "/joint_states_link/" + j.name;
  if (!robot.wrist.empty()) {
    parts.push_back({"/wrench/" + robot.wrist, "/force", 4.0});
    parts.push_back({"/wrench/" + robot.wrist, "/torque", 0.4});
  }
  if (!robot.imu.empty()) {
    parts.push_back({"/imu/" + robot.imu, "/angular_velocity", 0.02});
    parts.push_back({"/imu/" + robot.imu, "/linear_acceleration", 0.3});
  }
  const bool geometry = effect == "sensor_misalignment";
  if (robot.joint_torques && (!geometry || parts.empty())) parts.push_back({base, "/effort", 0.004 * j.kp});
  if (robot.link_encoders && effect == "sensor_bias") parts.push_back({base, "/position", 0.01});
  if (parts.empty()) parts.push_back({base, "/position", 0.01});
  const Part part = r.pick(parts);
  const bool vector = part.sensor.rfind("/joint", 0) != 0;
  if (effect == "sensor_bias") {
    const double size = boost * r.log_uniform(0.4, 4) * part.bias;
    nlohmann::ordered_json p;
    if (vector)
      p["value"] = draw_vector(size, r);
    else
      p["value"] = tidy(r.sign() * size);
    return {effect, "sensor", part.sensor + part.reading, p};
  }
  if (effect == "sensor_scale")
    return {effect,
            "sensor",
            part.sensor + part.reading,
            {{"scale", tidy(1 + r.sign() * std::min(0.4, boost * r.log_uniform(0.03, 0.3)))}}};
  if (effect == "sensor_delay")
    return {effect,
            "sensor",
            vector ? part.sensor : part.sensor + part.reading,
            {{"delay", std::round(1e3 * std::min(0.08, boost * r.log_uniform(0.008, 0.06))) / 1e3}}};
  if (geometry && vector)
    return {effect, "sensor", part.sensor, {{"rpy", draw_vector(boost * r.log_uniform(0.02, 0.15), r)}}};
  throw std::invalid_argument("no such sensor effect for an arm: " + effect);
}

Hidden draw_biped_sensor(const std::string& effect, const RobotPlan& robot, double boost, Prng& r) {
  const bool imu = r.chance(0.45);
  const std::string foot = "/wrench/" + r.pick(robot.feet).wrench, name = "/imu/" + robot.imu;
  const bool angular = r.chance(0.5);
  // A third of the faults of which a joint's readings may have one sit there.
  if (effect != "sensor_misalignment" && effect != "clock_skew" && r.chance(0.3))
    return draw_arm_sensor(effect, robot, {}, boost, r);
  const std::string where =
      imu ? name + (angular ? "/angular_velocity" : "/linear_acceleration") : foot + (angular ? "/torque" : "/force");
  if (effect == "sensor_bias") {
    const double size = boost * r.log_uniform(0.4, 4) * (imu ? (angular ? 0.02 : 0.3) : (angular ? 2.0 : 10.0));
    return {effect, "sensor", where, {{"value", draw_vector(size, r)}}};
  }
  if (effect == "sensor_scale")
    return {effect, "sensor", where, {{"scale", tidy(1 + r.sign() * std::min(0.4, boost * r.log_uniform(0.03, 0.3)))}}};
  if (effect == "sensor_delay")
    return {effect,
            "sensor",
            imu ? name : foot,
            {{"delay", std::round(1e3 * std::min(0.08, boost * r.log_uniform(0.008, 0.06))) / 1e3}}};
  if (effect == "sensor_misalignment")
    return {effect, "sensor", imu ? name : foot, {{"rpy", draw_vector(boost * r.log_uniform(0.02, 0.15), r)}}};
  if (effect == "clock_skew")
    return {effect, "sensor", imu ? name : foot, {{"skew", tidy(r.sign() * boost * r.log_uniform(0.002, 0.02))}}};
  throw std::invalid_argument("no such sensor effect for a biped: " + effect);
}

const LinkPlan& draw_link(const std::string& effect, const RobotPlan& robot, Prng& r) {
  if (robot.floating)
    return robot.links[static_cast<std::size_t>(
        effect == "payload" || r.chance(0.7) ? robot.imu_link : find_role(robot, "left_hip_pitch") + 1)];
  // A load sits at the end; the first link may turn about its own axis only, where its mass does not show.
  const int last = joint_count(robot);
  return robot.links[static_cast<std::size_t>(effect == "payload" ? last : 2 + r.below(last - 1))];
}

}  // namespace

Json to_json(const Hidden& hidden) {
  Json out{{"effect", hidden.effect}, {hidden.where_kind, hidden.where}};
  for (const auto& [key, value] : hidden.parameters.items()) out[key] = value;
  return out;
}

const std::vector<std::string>& link_effects() {
  static const std::vector<std::string> names{"payload", "mass_error", "com_error", "external_force"};
  return names;
}
const std::vector<std::string>& arm_sensor_effects() {
  static const std::vector<std::string> names{"sensor_bias", "sensor_scale", "sensor_delay"};
  return names;
}
const std::vector<std::string>& foot_effects() {
  static const std::vector<std::string> names{"foot_compliance", "foot_hardening", "ground_slope", "ground_friction"};
  return names;
}
const std::vector<std::string>& biped_sensor_effects() {
  static const std::vector<std::string> names{"sensor_bias", "sensor_scale", "sensor_delay", "sensor_misalignment",
                                              "clock_skew"};
  return names;
}
std::vector<Hidden> draw_hidden(const std::string& effect, const RobotPlan& robot,
                                const std::vector<std::string>& taken, double boost, Prng& random) {
  if (has(foot_effects(), effect)) return draw_foot(effect, robot, boost, random);
  if (has(link_effects(), effect)) {
    const LinkPlan& link = draw_link(effect, robot, random);
    return {{effect, "link", link.name, link_parameters(effect, link, boost, random)}};
  }
  if (effect.rfind("sensor_", 0) == 0 || effect == "clock_skew") {
    // Four of five faults sit where the encoders do not see them.
    if (!robot.floating && has_link_sensors(robot) && (effect == "sensor_misalignment" || random.chance(0.8)))
      return {draw_link_sensor(effect, robot, boost, random)};
    return {robot.floating ? draw_biped_sensor(effect, robot, boost, random)
                           : draw_arm_sensor(effect, robot, taken, boost, random)};
  }
  if (effect == "sprung_mass" || effect == "gust") return {draw_unlisted_of_body(effect, robot, boost, random)};
  const JointPlan& j = draw_joint(robot, taken, random);
  if (has(unknown_effects(), effect)) return {draw_unlisted_of_joint(effect, robot, j, boost, random)};
  const JointEffect* known = find_joint_effect(effect);
  if (!known) throw std::invalid_argument("unknown effect: " + effect);
  return {{effect, "joint", j.name, known->draw(j, boost, random)}};
}

}  // namespace hrp::cases
