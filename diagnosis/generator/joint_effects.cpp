// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/joint_effects.h"

#include <algorithm>
#include <cmath>

namespace hrp::cases {
namespace {

using Json = nlohmann::ordered_json;

// ---- Friction -------------------------------------------------------------------------------------------------------

const JointEffect kViscous{"viscous_friction",
                           [](const JointPlan& j, double boost, Prng& r) -> Json {
                             return {{"coefficient", tidy(boost * j.kp * r.log_uniform(0.002, 0.02))}};
                           },
                           [](JointReality& j, const Hidden& h) { j.viscous += h.get("coefficient"); }};

const JointEffect kCoulomb{"coulomb_friction",
                           [](const JointPlan& j, double boost, Prng& r) -> Json {
                             Json p{{"level", tidy(boost * j.kp * r.log_uniform(0.002, 0.02))}};
                             if (r.chance(0.3)) p["asymmetry"] = tidy(r.sign() * r.uniform(0.15, 0.4));
                             return p;
                           },
                           [](JointReality& j, const Hidden& h) {
                             j.coulomb = h.get("level");
                             j.asymmetry = h.get("asymmetry");
                           }};

const JointEffect kStribeck{"stribeck_friction",
                            [](const JointPlan& j, double boost, Prng& r) -> Json {
                              const double coulomb = boost * j.kp * r.log_uniform(0.002, 0.012);
                              return {{"coulomb", tidy(coulomb)},
                                      {"static", tidy(coulomb * r.uniform(1.4, 2.5))},
                                      {"stribeck_velocity", tidy(r.log_uniform(0.03, 0.25))},
                                      {"viscous", tidy(j.kp * r.uniform(0, 0.003))}};
                            },
                            [](JointReality& j, const Hidden& h) {
                              j.stribeck_coulomb = h.get("coulomb");
                              j.stribeck_static = h.get("static");
                              j.stribeck_velocity = h.get("stribeck_velocity");
                              j.viscous += h.get("viscous");
                            }};

const JointEffect kLoadFriction{"load_dependent_friction",
                                [](const JointPlan&, double boost, Prng& r) -> Json {
                                  return {{"ratio", tidy(std::min(0.45, boost * r.log_uniform(0.04, 0.3)))}};
                                },
                                [](JointReality& j, const Hidden& h) { j.load_ratio = h.get("ratio"); }};

const JointEffect kHysteresis{
    "hysteresis",
    [](const JointPlan& j, double boost, Prng& r) -> Json {
      const double yield = r.log_uniform(0.008, 0.08);
      return {{"stiffness", tidy(boost * j.kp * r.log_uniform(0.002, 0.015) / yield)}, {"yield_angle", tidy(yield)}};
    },
    [](JointReality& j, const Hidden& h) {
      j.bouc_wen_stiffness = h.get("stiffness");
      j.bouc_wen_yield = h.get("yield_angle");
    }};

// ---- Drive ----------------------------------------------------------------------------------------------------------

const JointEffect kTorqueConstant{"torque_constant_error",
                                  [](const JointPlan&, double boost, Prng& r) -> Json {
                                    const double error = std::min(0.45, boost * r.log_uniform(0.04, 0.4));
                                    return {{"scale", tidy(1 + r.sign() * error)}};
                                  },
                                  [](JointReality& j, const Hidden& h) { j.torque_scale = h.get("scale"); }};

const JointEffect kSaturation{"torque_saturation",
                              [](const JointPlan& j, double boost, Prng& r) -> Json {
                                return {{"limit", tidy(j.limit * r.log_uniform(0.06, 0.4) / boost)}};
                              },
                              [](JointReality& j, const Hidden& h) { j.saturation = h.get("limit"); }};

// |torque| <= stall_torque (1 - |v| / max_speed). Motions of an arm turn its joints at 0.5 to 4 rad/s.
const JointEffect kVelocityLimit{"velocity_limit",
                                 [](const JointPlan& j, double boost, Prng& r) -> Json {
                                   return {{"stall_torque", tidy(j.limit * r.log_uniform(0.08, 0.5) / boost)},
                                           {"max_speed", tidy(r.log_uniform(2, 8) / boost)}};
                                 },
                                 [](JointReality& j, const Hidden& h) {
                                   const double stall = h.get("stall_torque"), most = h.get("max_speed");
                                   j.drive_laws.push_back([stall, most](double torque, double v) {
                                     const double limit = stall * std::max(0.0, 1 - std::abs(v) / most);
                                     return std::clamp(torque, -limit, limit);
                                   });
                                 }};

// Valves that overlap, bridges with a dead time: torque = sign(u) max(0, |u| - width).
const JointEffect kDeadZone{"dead_zone",
                            [](const JointPlan& j, double boost, Prng& r) -> Json {
                              return {{"width", tidy(boost * j.limit * r.log_uniform(0.005, 0.05))}};
                            },
                            [](JointReality& j, const Hidden& h) {
                              const double width = h.get("width");
                              j.drive_laws.push_back([width](double torque, double) {
                                return std::copysign(std::max(0.0, std::abs(torque) - width), torque);
                              });
                            }};

const JointEffect kLag{"actuator_lag",
                       [](const JointPlan&, double boost, Prng& r) -> Json {
                         return {{"time_constant", tidy(std::min(0.025, boost * r.log_uniform(0.002, 0.018)))}};
                       },
                       [](JointReality& j, const Hidden& h) { j.lag = h.get("time_constant"); }};

const JointEffect kDelay{"command_delay",
                         [](const JointPlan&, double boost, Prng& r) -> Json {
                           const double delay = std::min(0.06, boost * r.log_uniform(0.004, 0.04));
                           return {{"delay", std::round(1e4 * delay) / 1e4}};
                         },
                         [](JointReality& j, const Hidden& h) { j.delay = h.get("delay"); }};

const JointEffect kOffset{"joint_offset",
                          [](const JointPlan&, double boost, Prng& r) -> Json {
                            return {{"offset", tidy(r.sign() * boost * r.log_uniform(0.005, 0.05))}};
                          },
                          [](JointReality& j, const Hidden& h) { j.offset = h.get("offset"); }};

// ---- Mechanics ------------------------------------------------------------------------------------------------------

void hide_transmission(JointReality& j, const Hidden& h) {
  j.elastic = true;
  j.stiffness = h.get("stiffness");
  j.damping = h.get("damping");
  j.rotor = h.get("rotor_inertia");
  j.gap = h.get("gap");
}

const JointEffect kRotor{"rotor_inertia",
                         [](const JointPlan& j, double boost, Prng& r) -> Json {
                           return {{"inertia", tidy(boost * j.kp * r.log_uniform(1.0 / 8000, 1.0 / 800))}};
                         },
                         [](JointReality& j, const Hidden& h) { j.rotor = h.get("inertia"); }};

const JointEffect kElasticity{"joint_elasticity",
                              [](const JointPlan& j, double boost, Prng& r) -> Json {
                                return {{"stiffness", tidy(j.kp * r.log_uniform(0.7, 6) / boost)},
                                        {"damping", tidy(j.kp * r.uniform(0.001, 0.004))},
                                        {"rotor_inertia", tidy(j.kp / r.log_uniform(1500, 5000))}};
                              },
                              &hide_transmission};

const JointEffect kBacklash{"backlash",
                            [](const JointPlan& j, double boost, Prng& r) -> Json {
                              return {{"gap", tidy(boost * r.log_uniform(0.003, 0.03))},
                                      {"stiffness", tidy(j.kp * 30)},
                                      {"damping", tidy(j.kp * 0.012)},
                                      {"rotor_inertia", tidy(j.kp / r.log_uniform(2000, 4500))}};
                            },
                            &hide_transmission};

const JointEffect kSpring{
    "parallel_spring",
    [](const JointPlan& j, double boost, Prng& r) -> Json {
      return {{"stiffness", tidy(boost * j.kp * r.log_uniform(0.003, 0.03))}, {"rest", tidy(r.uniform(-0.3, 0.3))}};
    },
    [](JointReality& j, const Hidden& h) {
      j.spring = h.get("stiffness");
      j.spring_rest = h.get("rest");
    }};

const JointEffect kCogging{"cogging",
                           [](const JointPlan& j, double boost, Prng& r) -> Json {
                             return {{"amplitude", tidy(boost * j.kp * r.log_uniform(0.001, 0.008))},
                                     {"periods", static_cast<double>(4 + r.below(60))},
                                     {"phase", tidy(r.uniform(0, 6.28))}};
                           },
                           [](JointReality& j, const Hidden& h) {
                             j.cogging = h.get("amplitude");
                             j.cogging_periods = h.get("periods");
                             j.cogging_phase = h.get("phase");
                           }};

}  // namespace

const std::vector<JointEffect>& list_joint_effects() {
  static const std::vector<JointEffect> rows{kViscous,    kCoulomb,  kStribeck,       kLoadFriction, kRotor,
                                             kElasticity, kBacklash, kTorqueConstant, kSaturation,   kVelocityLimit,
                                             kDeadZone,   kLag,      kDelay,          kSpring,       kCogging,
                                             kHysteresis, kOffset};
  return rows;
}

const JointEffect* find_joint_effect(const std::string& name) {
  for (const JointEffect& row : list_joint_effects()) {
    if (name == row.name) return &row;
  }
  return nullptr;
}

const std::vector<std::string>& joint_effects() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const JointEffect& row : list_joint_effects()) out.push_back(row.name);
    return out;
  }();
  return names;
}

}  // namespace hrp::cases
