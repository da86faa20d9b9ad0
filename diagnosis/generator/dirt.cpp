// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/dirt.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"

namespace hrp::cases {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;

// Of a transmission that is hidden in the joint; else 0 [kg m^2].
double find_rotor(const std::vector<Hidden>& hidden, const std::string& joint) {
  for (const Hidden& h : hidden) {
    if (h.where == joint && h.get("rotor_inertia") > 0) return h.get("rotor_inertia");
  }
  return 0;
}

bool is_hidden(const std::vector<Hidden>& hidden, const char* what, const std::string& where) {
  return std::any_of(hidden.begin(), hidden.end(),
                     [&](const Hidden& h) { return h.effect.find(what) != std::string::npos && h.where == where; });
}

// Levels follow the stiffness kp of the servo [N m/rad]: what a drive can give and what it loses grow together.
Hidden draw_dry(const JointPlan& j, Prng& r) {
  const double level = j.kp * r.log_uniform(0.001, 0.006);
  if (r.chance(0.6)) return {"coulomb_friction", "joint", j.name, {{"level", tidy(level)}}};
  return {"stribeck_friction",
          "joint",
          j.name,
          {{"coulomb", tidy(level)},
           {"static", tidy(level * r.uniform(1.15, 1.8))},
           {"stribeck_velocity", tidy(r.log_uniform(0.04, 0.2))}}};
}

// `rotor`: reflected inertia behind a hidden transmission; 0: none is hidden, and one is drawn.
void add_drive(const JointPlan& j, double rotor, Dirt* dirt, Prng& r) {
  const auto add = [&](const char* effect, const char* key, double value) {
    dirt->background.push_back({effect, "joint", j.name, {{key, tidy(value)}}});
  };
  add("viscous_friction", "coefficient", j.kp * r.log_uniform(0.0006, 0.006));
  const double drawn = j.kp * r.log_uniform(1.0 / 4000, 1.0 / 800);
  add("rotor_inertia", "inertia", rotor > 0 ? rotor : drawn);
  dirt->background.push_back(draw_dry(j, r));
  if (r.chance(0.3)) add("load_dependent_friction", "ratio", r.uniform(0.03, 0.13));
  if (r.chance(0.45)) {
    dirt->unlisted.push_back({"friction_texture",
                              "joint",
                              j.name,
                              {{"modulation", tidy(r.uniform(0.08, 0.35))},
                               {"periods", static_cast<double>(1 + r.below(9))},
                               {"phase", tidy(r.uniform(0, kTwoPi))}}});
  }
  if (r.chance(0.4)) {
    dirt->unlisted.push_back({"friction_fades",
                              "joint",
                              j.name,
                              {{"drop", tidy(r.uniform(0.07, 0.25))}, {"time_constant", tidy(r.uniform(3, 14))}}});
  }
}

}  // namespace

std::vector<std::string> draw_on_top(bool biped, Prng& random) {
  static const std::vector<std::string> arm{
      "joint_offset",   "command_delay", "torque_constant_error", "payload",          "mass_error", "com_error",
      "external_force", "actuator_lag",  "parallel_spring",       "joint_elasticity", "backlash",   "cogging",
      "hysteresis",     "sensor_scale",  "sensor_delay",          "sensor_bias"},
      stand{"joint_offset", "payload",     "mass_error",   "com_error",           "foot_compliance",
            "ground_slope", "sensor_bias", "sensor_delay", "sensor_misalignment", "sensor_scale"};
  std::vector<std::string> out;
  const double d = random.uniform(0, 1);
  const std::size_t count = d < 0.2 ? 0 : d < 0.75 ? 1 : 2;
  while (out.size() < count) {
    const std::string& effect = random.pick(biped ? stand : arm);
    if (!has(out, effect)) out.push_back(effect);
  }
  return out;
}

Dirt draw_dirt(const RobotPlan& robot, const std::vector<Hidden>& hidden, Prng& random) {
  Dirt dirt;
  const bool scaled = random.chance(0.5);  // efforts of this robot were calibrated once
  for (int j = 0; j < joint_count(robot); ++j) {
    const JointPlan& plan = joint(robot, j);
    add_drive(plan, find_rotor(hidden, plan.name), &dirt, random);
    const std::string effort = "/joint_states/" + plan.name + "/effort";
    const double scale = 1 + 0.02 * random.normal();
    if (scaled && !is_hidden(hidden, "sensor_scale", effort))
      dirt.background.push_back({"sensor_scale", "sensor", effort, {{"scale", tidy(scale)}}});
  }
  return dirt;
}

void soil_recorder(const RobotPlan& robot, const std::vector<Hidden>& hidden, RecorderPlan* plan, Prng& random) {
  const double dither = 0.3;  // of a step, in front of the rounding
  plan->encoder_step = kTwoPi / static_cast<double>(1 << (12 + random.below(5)));
  plan->position_noise = dither * plan->encoder_step;
  plan->velocity_noise = tidy(random.log_uniform(1e-3, 6e-3));
  plan->noise_stated = false;  // who knows the noise of a drive
  if (random.chance(0.4)) plan->stamp_error = random.uniform(0.02, 0.15) / plan->rate;
  const double noise = random.log_uniform(5e-5, 3e-4), ripple = random.chance(0.5) ? random.log_uniform(1e-4, 1e-3) : 0;
  for (int j = 0; j < joint_count(robot); ++j) {
    plan->effort_noises.push_back(tidy(joint(robot, j).kp * noise));
    plan->ripples.push_back(
        {joint(robot, j).kp * ripple, static_cast<double>(20 + random.below(80)), random.uniform(0, kTwoPi)});
  }
  const bool delayed = std::any_of(hidden.begin(), hidden.end(), [](const Hidden& h) {
    return h.effect == "command_delay" || h.effect == "actuator_lag" || h.effect == "sensor_delay";
  });
  if (robot.floating || delayed || !plan->with_effort || !random.chance(0.15)) return;
  plan->effort_driven = true;
  plan->with_commands = false;
}

}  // namespace hrp::cases
