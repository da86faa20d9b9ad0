// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>

#include "diagnosis/generator/make_case.h"

namespace hrp::cases {
namespace {

bool is_in(const std::vector<std::string>& list, const std::string& item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

std::string find_family(const std::vector<std::string>& effects, bool biped) {
  if (effects.empty()) return biped ? "stand_none" : "none";
  if (effects.size() > 1) return effects.size() == 2 ? "pair" : "triple";
  if (is_in(unknown_effects(), effects[0])) return "unknown";
  if (is_in(foot_effects(), effects[0])) return "foot";
  if (is_in(biped_sensor_effects(), effects[0])) return "sensor";
  if (biped) return "stand";
  return is_in(link_effects(), effects[0]) ? "link" : "joint";
}

CaseRequest make_request(std::vector<std::string> effects, bool biped) {
  const std::string family = find_family(effects, biped);
  return {family, biped, std::move(effects)};
}

// Pairs and triples: effects that may meet in one robot; two transmissions or two sensor faults do not.
std::vector<std::string> draw_mixture(std::size_t count, Prng& random) {
  static const std::vector<std::string> pool{"viscous_friction",
                                             "coulomb_friction",
                                             "stribeck_friction",
                                             "load_dependent_friction",
                                             "rotor_inertia",
                                             "joint_elasticity",
                                             "torque_constant_error",
                                             "actuator_lag",
                                             "command_delay",
                                             "parallel_spring",
                                             "cogging",
                                             "hysteresis",
                                             "joint_offset",
                                             "payload",
                                             "mass_error",
                                             "sensor_bias",
                                             "backlash",
                                             "torque_saturation"};
  std::vector<std::string> out;
  while (out.size() < count) {
    const std::string& effect = random.pick(pool);
    const bool body_twice =
        (effect == "payload" || effect == "mass_error") && (is_in(out, "payload") || is_in(out, "mass_error"));
    if (!is_in(out, effect) && !body_twice) out.push_back(effect);
  }
  return out;
}

// One round: every single effect once, and the other families in the proportions of a sensible trial.
std::vector<CaseRequest> make_round(Prng& random) {
  std::vector<CaseRequest> round;
  for (const auto& effect : joint_effects()) round.push_back(make_request({effect}, false));
  for (const auto& effect : link_effects()) round.push_back(make_request({effect}, false));
  for (const auto& effect : arm_sensor_effects()) round.push_back(make_request({effect}, false));
  for (const auto& effect : foot_effects()) round.push_back(make_request({effect}, true));
  round.push_back(make_request({"foot_compliance"}, true));
  for (const auto& effect : biped_sensor_effects()) round.push_back(make_request({effect}, true));
  for (const char* effect :
       {"payload", "com_error", "joint_offset", "external_force", "rotor_inertia", "coulomb_friction"}) {
    round.push_back(make_request({effect}, true));
  }
  for (const auto& effect : unknown_effects()) round.push_back(make_request({effect}, false));
  for (int i = 0; i < 5; ++i) round.push_back(make_request({}, false));
  for (int i = 0; i < 3; ++i) round.push_back(make_request({}, true));
  for (int i = 0; i < 8; ++i) round.push_back(make_request(draw_mixture(2, random), false));
  round.push_back(make_request({"foot_compliance", "joint_offset"}, true));
  round.push_back(make_request({"foot_compliance", "sensor_bias"}, true));
  for (int i = 0; i < 2; ++i) round.push_back(make_request(draw_mixture(3, random), false));
  random.shuffle(round);
  return round;
}

}  // namespace

std::vector<CaseRequest> make_deck(int count, std::uint64_t seed) {
  Prng random(seed ^ 0x5eedULL);
  std::vector<CaseRequest> deck;
  while (static_cast<int>(deck.size()) < count) {
    for (CaseRequest& request : make_round(random)) deck.push_back(std::move(request));
  }
  deck.resize(static_cast<std::size_t>(count));
  return deck;
}

CaseRequest parse_request(const std::string& text) {
  std::string rest = text;
  const bool stand = rest.rfind("stand:", 0) == 0;
  if (stand) rest = rest.substr(6);
  std::vector<std::string> effects;
  for (std::size_t at = 0; rest != "none" && at <= rest.size();) {
    const std::size_t end = std::min(rest.find('+', at), rest.size());
    effects.push_back(rest.substr(at, end - at));
    at = end + 1;
  }
  bool biped = stand;
  for (const std::string& effect : effects) {
    const bool known = is_in(joint_effects(), effect) || is_in(link_effects(), effect) ||
                       is_in(foot_effects(), effect) || is_in(biped_sensor_effects(), effect) ||
                       is_in(unknown_effects(), effect);
    if (!known) throw std::invalid_argument("no effect is called '" + effect + "'");
    biped = biped || is_in(foot_effects(), effect) || effect == "sensor_misalignment" || effect == "clock_skew";
  }
  return make_request(std::move(effects), biped);
}

}  // namespace hrp::cases
