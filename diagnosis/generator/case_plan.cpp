// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>

#include "common/base/has.h"
#include "common/base/split_cells.h"
#include "diagnosis/generator/dirt.h"
#include "diagnosis/generator/make_case.h"

namespace hrp::cases {
namespace {

std::string find_family(const std::vector<std::string>& effects, bool biped) {
  const std::string prefix = biped ? "stand_" : "";
  if (effects.empty()) return prefix + "none";
  if (effects.size() > 1) return prefix + (effects.size() == 2 ? "pair" : "triple");
  if (has(unknown_effects(), effects[0]) || has(stand_unknown_effects(), effects[0])) return prefix + "unknown";
  if (has(foot_effects(), effects[0])) return prefix + "foot";
  if (has(biped_sensor_effects(), effects[0])) return prefix + "sensor";
  return prefix + (has(link_effects(), effects[0]) ? "link" : "joint");
}

CaseRequest make_request(std::vector<std::string> effects, bool biped) {
  const std::string family = find_family(effects, biped);
  return {family, biped, std::move(effects)};
}

bool is_single(const std::string& family) {
  for (const char* kind : {"joint", "link", "foot", "sensor"}) {
    if (family == kind || family == std::string("walk_") + kind || family == std::string("stand_") + kind) return true;
  }
  return false;
}

// Rounds of walks, and those of dirty walks, have no other cases: families beside them would be left out without a
// word.
void check_rounds(const std::string& families) {
  std::size_t walks = 0, dirty = 0;
  const std::vector<std::string> list = split_cells(families);
  for (const std::string& one : list) {
    walks += one.rfind("walk", 0) == 0;
    dirty += one == "walk_dirty";
  }
  if ((walks > 0 && walks < list.size()) || (dirty > 0 && dirty < walks))
    throw std::invalid_argument("'" + families + "': walks, and dirty walks, are made apart from other families");
}

// Is the request one of `families`, a comma list?
bool is_wanted(const CaseRequest& request, const std::string& families) {
  for (const std::string& one : split_cells(families)) {
    if (one == "dirty" && request.family.find(one) != std::string::npos) return true;
    if (one == request.family || one == (request.walk ? "walk" : request.biped ? "stand" : "arm")) return true;
    if (one == "single" && is_single(request.family)) return true;
  }
  return families.empty();
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
        (effect == "payload" || effect == "mass_error") && (has(out, "payload") || has(out, "mass_error"));
    if (!has(out, effect) && !body_twice) out.push_back(effect);
  }
  return out;
}

// Two effects in one joint: friction of one kind beside an effect that is not friction.
CaseRequest draw_same_joint(Prng& random) {
  static const std::vector<std::string> friction{"viscous_friction", "coulomb_friction", "stribeck_friction",
                                                 "load_dependent_friction"},
      other{"rotor_inertia", "torque_constant_error", "actuator_lag",     "command_delay", "parallel_spring",
            "cogging",       "joint_offset",          "joint_elasticity", "backlash"};
  return {"pair_same_joint", false, {random.pick(friction), random.pick(other)}};
}

// Half of them with something below the feet, where most of a standing robot's story is.
CaseRequest draw_stand_pair(Prng& random) {
  static const std::vector<std::string> below{"foot_compliance", "ground_slope", "foot_compliance"},
      any{"joint_offset",    "sensor_bias",           "payload",       "com_error",      "sensor_misalignment",
          "sensor_delay",    "coulomb_friction",      "sensor_scale",  "rotor_inertia",  "viscous_friction",
          "parallel_spring", "torque_constant_error", "command_delay", "external_force", "mass_error"};
  const std::string first = random.chance(0.5) ? random.pick(below) : random.pick(any);
  for (;;) {
    const std::string& second = random.pick(any);
    if (second != first) return make_request({first, second}, true);
  }
}

void add_arm_round(std::vector<CaseRequest>& round, Prng& random) {
  for (const auto* list : {&joint_effects(), &link_effects(), &arm_sensor_effects(), &unknown_effects()}) {
    for (const std::string& effect : *list) round.push_back(make_request({effect}, false));
  }
  for (int i = 0; i < 5; ++i) round.push_back(make_request({}, false));
  for (int i = 0; i < 8; ++i) round.push_back(make_request(draw_mixture(2, random), false));
  for (int i = 0; i < 3; ++i) round.push_back(draw_same_joint(random));
  for (int i = 0; i < 2; ++i) round.push_back(make_request(draw_mixture(3, random), false));
}

// Joint effects that show in a robot that stands and sways.
void add_stand_round(std::vector<CaseRequest>& round, Prng& random) {
  for (const auto* list : {&foot_effects(), &biped_sensor_effects(), &stand_unknown_effects()}) {
    for (const std::string& effect : *list) round.push_back(make_request({effect}, true));
  }
  for (const char* effect :
       {"foot_compliance", "sensor_bias", "payload", "mass_error", "com_error", "external_force", "joint_offset",
        "rotor_inertia", "coulomb_friction", "viscous_friction", "torque_constant_error", "joint_elasticity",
        "backlash", "command_delay", "parallel_spring"}) {
    round.push_back(make_request({effect}, true));
  }
  for (int i = 0; i < 3; ++i) round.push_back(make_request({}, true));
  for (int i = 0; i < 4; ++i) round.push_back(draw_stand_pair(random));
}

// Worlds like reality, two arms to a standing robot.
void add_dirty_round(std::vector<CaseRequest>& round, Prng& random) {
  for (int i = 0; i < 9; ++i) {
    const bool biped = i % 3 == 2;
    round.push_back({biped ? "stand_dirty" : "arm_dirty", biped, draw_on_top(biped, random)});
  }
}

// One round: every single effect once, and the other families in the proportions of a sensible trial.
std::vector<CaseRequest> make_round(bool dirty, Prng& random) {
  std::vector<CaseRequest> round;
  if (dirty) add_dirty_round(round, random);
  add_arm_round(round, random);
  add_stand_round(round, random);
  random.shuffle(round);
  return round;
}

}  // namespace

std::vector<CaseRequest> make_case_plan(int count, std::uint64_t seed, const std::string& family) {
  check_rounds(family);
  Prng random(seed ^ 0x5eedULL);
  std::vector<CaseRequest> requests;
  for (int rounds = 0; static_cast<int>(requests.size()) < count; ++rounds) {
    // Walks are made where they are asked for: seeds of trials before them keep their cases.
    const bool walks = family.find("walk") != std::string::npos, dirty = family.find("dirty") != std::string::npos;
    const auto walk_round = dirty ? make_dirty_walk_round : make_walk_round;
    for (CaseRequest& request : walks ? walk_round(random) : make_round(dirty, random)) {
      if (is_wanted(request, family)) requests.push_back(std::move(request));
    }
    if (requests.empty() && rounds > 3) throw std::invalid_argument("no family is called '" + family + "'");
  }
  requests.resize(static_cast<std::size_t>(count));
  return requests;
}

CaseRequest parse_request(const std::string& text) {
  std::string rest = text;
  const bool stand = rest.rfind("stand:", 0) == 0, walk = rest.rfind("walk:", 0) == 0, arm = rest.rfind("arm:", 0) == 0;
  if (stand || walk || arm) rest = rest.substr(rest.find(':') + 1);
  std::vector<std::string> effects;
  for (std::size_t at = 0; rest != "none" && at <= rest.size();) {
    const std::size_t end = std::min(rest.find('+', at), rest.size());
    effects.push_back(rest.substr(at, end - at));
    at = end + 1;
  }
  if (walk) return make_walk_request(std::move(effects));
  bool biped = stand;
  for (const std::string& effect : effects) {
    const bool known = has(joint_effects(), effect) || has(link_effects(), effect) || has(foot_effects(), effect) ||
                       has(biped_sensor_effects(), effect) || has(unknown_effects(), effect) ||
                       has(stand_unknown_effects(), effect);
    if (!known) throw std::invalid_argument("no effect is called '" + effect + "'");
    biped = biped || has(foot_effects(), effect) || effect == "sensor_misalignment" || effect == "clock_skew" ||
            effect == "gust";
  }
  return make_request(std::move(effects), biped && !arm);
}

}  // namespace hrp::cases
