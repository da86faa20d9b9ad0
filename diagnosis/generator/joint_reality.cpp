// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/joint_reality.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "diagnosis/generator/joint_effects.h"

namespace hrp::cases {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;
using Apply = std::function<void(JointReality&, const Hidden&)>;

// What no list of the tool has.
const std::map<std::string, Apply>& unlisted_table() {
  static const std::map<std::string, Apply> table{
      {"position_dependent_friction",
       [](JointReality& j, const Hidden& h) {
         j.bump_level = h.get("level");
         j.bump_center = h.get("center");
         j.bump_width = h.get("width");
       }},
      {"friction_drift",
       [](JointReality& j, const Hidden& h) {
         j.drift_level = h.get("level");
         j.drift_time = h.get("time_constant");
       }},
      {"friction_texture",
       [](JointReality& j, const Hidden& h) {
         j.texture = h.get("modulation");
         j.texture_periods = h.get("periods");
         j.texture_phase = h.get("phase");
       }},
      {"friction_fades",
       [](JointReality& j, const Hidden& h) {
         j.fade_drop = h.get("drop");
         j.fade_time = h.get("time_constant");
       }},
      {"quadratic_drag", [](JointReality& j, const Hidden& h) { j.drag = h.get("coefficient"); }},
      {"thermal_torque_loss",
       [](JointReality& j, const Hidden& h) {
         j.heat_loss = h.get("loss");
         j.heat_reference = h.get("reference");
         j.heating_time = h.get("heating_time");
         j.cooling_time = h.get("cooling_time");
       }},
      {"intermittent_slip",
       [](JointReality& j, const Hidden& h) {
         j.slip_fraction = h.get("fraction");
         j.slip_period = h.get("period");
         j.slip_length = h.get("length");
       }},
      {"periodic_disturbance",
       [](JointReality& j, const Hidden& h) {
         j.periodic_amplitude = h.get("amplitude");
         j.periodic_frequency = h.get("frequency");
         j.periodic_phase = h.get("phase");
       }},
      {"cubic_spring", [](JointReality& j, const Hidden& h) { j.cubic = h.get("coefficient"); }},
      {"magnetic_detent",
       [](JointReality& j, const Hidden& h) {
         j.detent = h.get("amplitude");
         j.detent_center = h.get("center");
         j.detent_width = h.get("width");
       }},
      {"mechanical_stop", [](JointReality& j, const Hidden& h) {
         j.stop_angle = h.get("angle");
         j.stop_side = h.get("side");
         j.stop_stiffness = h.get("stiffness");
       }}};
  return table;
}

}  // namespace

std::vector<JointReality> make_joint_realities(const RobotPlan& robot, const std::vector<Hidden>& hidden) {
  std::vector<JointReality> joints(static_cast<std::size_t>(joint_count(robot)));
  for (const Hidden& h : hidden) {
    if (h.where_kind != "joint") continue;
    const int index = find_joint(robot, h.where);
    JointReality& j = joints.at(static_cast<std::size_t>(index));
    if (const JointEffect* known = find_joint_effect(h.effect)) known->hide(j, h);
    if (const auto at = unlisted_table().find(h.effect); at != unlisted_table().end()) at->second(j, h);
    if (h.effect == "cubic_spring") j.cubic_center = joint(robot, index).start;
    if (h.effect == "joint_coupling") {
      j.coupled_to = find_joint(robot, h.parameters.at("other").get<std::string>());
      j.coupling = h.get("stiffness");
    }
  }
  return joints;
}

double calc_heat_rate(const JointReality& joint, double asked, double heat) {
  const double load = asked / joint.heat_reference;
  return load * load / joint.heating_time - heat / joint.cooling_time;
}

double calc_drive_torque(const JointReality& joint, double asked, double v, double heat, double time) {
  double torque = std::clamp(asked, -joint.saturation, joint.saturation) * joint.torque_scale;
  torque /= 1 + joint.heat_loss * heat;
  if (joint.slip_fraction > 0 && std::fmod(time + 10 * joint.slip_period, joint.slip_period) < joint.slip_length) {
    torque *= 1 - joint.slip_fraction;
  }
  for (const DriveLaw& law : joint.drive_laws) torque = law(torque, v);
  return torque;
}

double calc_transmission_torque(const JointReality& joint, double q_motor, double q_link, double v_motor,
                                double v_link) {
  const double turn = q_motor - q_link, half = joint.gap / 2;
  if (joint.gap == 0) return joint.stiffness * turn + joint.damping * (v_motor - v_link);
  if (std::abs(turn) <= half) return 0;
  const double side = turn > 0 ? 1.0 : -1.0;
  const double torque = joint.stiffness * (turn - side * half) + joint.damping * (v_motor - v_link);
  return side * torque > 0 ? torque : 0;  // teeth push, they do not pull
}

double calc_motor_side_torque(const JointReality& j, double q, double v, double z, double time) {
  return -j.viscous * v - j.coulomb * j.asymmetry - j.bouc_wen_stiffness * z +
         j.cogging * std::sin(j.cogging_periods * q + j.cogging_phase) +
         j.periodic_amplitude * std::sin(kTwoPi * j.periodic_frequency * time + j.periodic_phase);
}

double calc_link_side_torque(const JointReality& j, double q, double v) {
  double torque = -j.spring * (q - j.spring_rest) - j.drag * v * std::abs(v);
  const double turn = q - j.cubic_center;
  torque -= j.cubic * turn * turn * turn;
  const double u = (q - j.detent_center) / j.detent_width;
  torque -= j.detent * u * std::exp(0.5 * (1 - u * u));  // a Gaussian well; the pull is largest one width away
  const double depth = j.stop_side * (q - j.stop_angle);
  if (j.stop_stiffness > 0 && depth > 0) torque -= j.stop_side * j.stop_stiffness * depth;
  return torque;
}

double calc_bouc_wen_rate(const JointReality& j, double v, double z) {
  return v - (std::abs(v) * z + v * std::abs(z)) / (2 * j.bouc_wen_yield);
}

double calc_dry_friction(const JointReality& j, double q, double v, double torque, double time) {
  double level = j.coulomb + j.load_ratio * std::abs(torque);
  if (j.stribeck_velocity > 0) {
    const double s = v / j.stribeck_velocity;
    level += j.stribeck_coulomb + (j.stribeck_static - j.stribeck_coulomb) * std::exp(-s * s);
  }
  const double b = (q - j.bump_center) / j.bump_width;
  level += j.bump_level * std::exp(-b * b) + j.drift_level * std::exp(-std::max(time, 0.0) / j.drift_time);
  level *= 1 + j.texture * std::sin(j.texture_periods * q + j.texture_phase);
  return level * (1 - j.fade_drop * (1 - std::exp(-std::max(time, 0.0) / j.fade_time)));
}

}  // namespace hrp::cases
