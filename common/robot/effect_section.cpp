// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/effect_section.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hrp {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

struct Range {
  double lower, upper;
};

// What a parameter of a joint effect may be; beyond it the laws mean nothing. Tests hold it against the simulator's list.
Range get_range(const std::string& effect, const std::string& key) {
  if (key == "phase" || key == "rest" || key == "amplitude") return {-kInf, kInf};
  if (key == "asymmetry") return {-1.0, 1.0};
  if (key == "offset") return {-3.2, 3.2};
  if (key == "scale") return {0.0, 10.0};
  if (key == "ratio" || key == "gap" || key == "delay" || key == "time_constant") return {0.0, 1.0};
  if (key == "stribeck_velocity") return {1e-6, kInf};
  if (key == "yield_angle") return {1e-9, kInf};
  const bool transmission = effect == "joint_elasticity" || effect == "backlash";
  if (key == "stiffness") return {transmission ? 1e-3 : 0.0, kInf};
  if (key == "rotor_inertia") return {effect == "joint_elasticity" ? 1e-9 : 0.0, kInf};
  return {0.0, kInf};
}

// A number, or a finding's {value: ..., std: ..., ci95: ..., unit: ...}.
void read_number(YamlMap& map, const std::string& key, double* value, Bound bound = Bound::kAny) {
  if (!map.is_mapping(key)) return map.number(key, value, bound, "");
  map.child(key, [&](YamlMap& child) {
    child.require("value", "a number");
    child.number("value", value, bound, "");
    for (const char* spread : {"std", "ci95", "unit"}) child.ignore(spread);
  });
}

void read_vector(YamlMap& map, const std::string& key, Vector3d* value) {
  if (!map.is_mapping(key)) return map.axes3(key, value, Bound::kAny, "");
  map.child(key, [&](YamlMap& child) {
    child.require("value", "a list of 3 numbers");
    child.axes3("value", value, Bound::kAny, "");
    for (const char* spread : {"std", "ci95", "unit"}) child.ignore(spread);
  });
}

const EffectSpec* find_effect(const std::string& name) {
  for (const EffectSpec& effect : get_joint_effects()) {
    if (effect.name == name) return &effect;
  }
  return nullptr;
}

JointLawSpec read_joint_law(const EffectSpec& effect, YamlMap& map) {
  JointLawSpec law;
  law.effect = effect.name;
  for (const std::string& key : effect.required) map.require(key, "a number (docs/scenario.md)");
  for (const auto* keys : {&effect.required, &effect.optional}) {
    for (const std::string& key : *keys) {
      if (!map.has(key)) continue;
      const Range range = get_range(effect.name, key);
      double value = std::max(0.0, range.lower);
      read_number(map, key, &value);
      law.parameters[key] = value;
      if (value >= range.lower && value <= range.upper) continue;
      map.error(key, "is " + std::to_string(value) + ", expected " + std::to_string(range.lower) + " to " +
                         std::to_string(range.upper));
    }
  }
  return law;
}

const std::vector<std::string>& list_link_effects() {
  static const std::vector<std::string> names = {"payload", "mass_error", "com_error", "external_force"};
  return names;
}

LinkLawSpec read_link_law(const std::string& effect, YamlMap& map) {
  LinkLawSpec law;
  law.effect = effect;
  const bool has_number = effect == "payload" || effect == "mass_error";
  if (has_number) {
    const char* key = effect == "payload" ? "mass" : "scale";
    map.require(key, "a number > 0");
    law.number = 1.0;
    read_number(map, key, &law.number, Bound::kPositive);
  }
  if (effect == "mass_error") return law;
  const char* key = effect == "payload" ? "com" : (effect == "com_error" ? "offset" : "force");
  map.require(key, "a list of 3 numbers");
  read_vector(map, key, &law.vector);
  return law;
}

void read_joint_laws(YamlMap& map, Scenario* scenario) {
  map.each([&](const std::string& joint, YamlMap& child) {
    for (const EffectSpec& effect : get_joint_effects()) {
      child.child(effect.name, [&](YamlMap& law) { scenario->joint_laws[joint].push_back(read_joint_law(effect, law)); });
    }
  });
}

void read_link_laws(YamlMap& map, Scenario* scenario) {
  map.each([&](const std::string& link, YamlMap& child) {
    for (const std::string& effect : list_link_effects()) {
      child.child(effect, [&](YamlMap& law) { scenario->link_laws[link].push_back(read_link_law(effect, law)); });
    }
  });
}

// ---- effects: a list of {effect, where, parameters} ---------------------------------------------------------------

struct Place {
  std::string joint, link, foot, sensor;
};

// Reading groups of a sensor's path: "/wrench/NAME/torque" is one group, "/wrench/NAME" or "NAME" both.
std::vector<SensorErrors*> find_sensor(const std::string& path, Scenario* scenario) {
  const auto matches = [&](const char* kind, const std::string& name, const char* group) {
    const std::string all = "/" + std::string(kind) + "/" + name;
    return path == name || path == all || path == all + "/" + group;
  };
  std::vector<SensorErrors*> found;
  for (ImuSpec& imu : scenario->sensors.imus) {
    if (matches("imu", imu.name, "angular_velocity")) found.push_back(&imu.gyro);
    if (matches("imu", imu.name, "linear_acceleration")) found.push_back(&imu.accelerometer);
  }
  for (WrenchSpec& wrench : scenario->sensors.wrenches) {
    if (matches("wrench", wrench.name, "force")) found.push_back(&wrench.force);
    if (matches("wrench", wrench.name, "torque")) found.push_back(&wrench.torque);
  }
  return found;
}

void read_sensor_effect(const std::string& effect, YamlMap& map, SensorErrors* errors) {
  if (effect == "sensor_bias") read_vector(map, "value", &errors->bias);
  if (effect == "sensor_scale") read_vector(map, "scale", &errors->scale);
  if (effect == "sensor_misalignment") read_vector(map, "rpy", &errors->misalignment);
  if (effect == "sensor_delay") read_number(map, "delay", &errors->delay, Bound::kNotNegative);
  if (effect == "clock_skew") read_number(map, "skew", &errors->clock_skew);
  if (errors->delay > 10.0) map.error("delay", "expected at most 10 s");
  if (std::abs(errors->clock_skew) > 0.1) map.error("skew", "expected at most 0.1 either way");
}

void read_bush_effect(const std::string& effect, YamlMap& map, FootBushSpec* bush) {
  read_number(map, "kz", &bush->kz, Bound::kPositive);
  read_number(map, "cz", &bush->cz, Bound::kNotNegative);
  read_number(map, "k_roll", &bush->k_roll, Bound::kPositive);
  read_number(map, "c_roll", &bush->c_roll, Bound::kNotNegative);
  read_number(map, "k_pitch", &bush->k_pitch, Bound::kPositive);
  read_number(map, "c_pitch", &bush->c_pitch, Bound::kNotNegative);
  read_number(map, "offset_roll", &bush->offset_roll);
  read_number(map, "offset_pitch", &bush->offset_pitch);
  if (effect == "foot_hardening") read_number(map, "hardening_angle", &bush->hardening_angle, Bound::kPositive);
  if (map.has("center")) {
    Vector3d center = Vector3d::Zero();
    read_vector(map, "center", &center);
    bush->center = center;
  }
}

bool read_ground_effect(const std::string& effect, YamlMap& map, Scenario* scenario) {
  if (effect == "ground_slope") {
    read_number(map, "roll", &scenario->ground.roll);
    read_number(map, "pitch", &scenario->ground.pitch);
    if (!(std::abs(scenario->ground.roll) <= 1.2 && std::abs(scenario->ground.pitch) <= 1.2)) {
      map.error("", "expected at most 1.2 rad either way");
    }
  } else if (effect == "ground_friction") {
    map.require("coefficient", "a number >= 0");
    read_number(map, "coefficient", &scenario->ground.friction, Bound::kNotNegative);
  } else if (effect == "restitution") {
    // Of the impulse model: there the coefficient is what comes out, not what a damper makes of it.
    map.require("coefficient", "a number from 0 to 1");
    read_number(map, "coefficient", &scenario->contact.restitution, Bound::kUnitInterval);
    scenario->contact.model = "impulse";
  } else {
    return false;
  }
  return true;
}

void read_sensor_effects(const std::string& effect, const Place& place, YamlMap& map, Scenario* scenario) {
  const std::vector<SensorErrors*> found = find_sensor(place.sensor, scenario);
  if (found.empty()) return map.error("", "there is no sensor '" + place.sensor + "' in 'sensors' that has this effect");
  for (SensorErrors* errors : found) read_sensor_effect(effect, map, errors);
}

// False: unknown effect.
bool read_effect(const std::string& effect, const Place& place, YamlMap& map, Scenario* scenario) {
  const auto need = [&](const std::string& name, const char* kind) {
    if (name.empty()) map.error("", effect + " needs where: {" + kind + ": NAME}");
    return !name.empty();
  };
  const auto& links = list_link_effects();
  if (!place.joint.empty()) map.mark_as("joint_laws." + place.joint);
  if (!place.link.empty()) map.mark_as("link_laws." + place.link);
  if (!place.foot.empty()) map.mark_as("foot_bush." + place.foot);
  if (const EffectSpec* spec = find_effect(effect)) {
    if (need(place.joint, "joint")) scenario->joint_laws[place.joint].push_back(read_joint_law(*spec, map));
  } else if (std::find(links.begin(), links.end(), effect) != links.end()) {
    if (need(place.link, "link")) scenario->link_laws[place.link].push_back(read_link_law(effect, map));
  } else if (effect == "foot_compliance" || effect == "foot_hardening") {
    if (need(place.foot, "foot")) read_bush_effect(effect, map, &scenario->foot_bush[place.foot]);
  } else if (effect.rfind("sensor_", 0) == 0 || effect == "clock_skew") {
    if (need(place.sensor, "sensor")) read_sensor_effects(effect, place, map, scenario);
  } else {
    return read_ground_effect(effect, map, scenario);
  }
  return true;
}

std::vector<std::string> list_effects() {
  std::vector<std::string> names = list_link_effects();
  for (const EffectSpec& effect : get_joint_effects()) names.push_back(effect.name);
  for (const char* name : {"foot_compliance", "foot_hardening", "ground_slope", "ground_friction", "restitution",
                           "sensor_bias", "sensor_scale", "sensor_delay", "sensor_misalignment", "clock_skew"}) {
    names.push_back(name);
  }
  return names;
}

void read_finding(YamlMap& map, Scenario* scenario) {
  map.require("effect", "the name of an effect");
  std::string effect;
  map.choice("effect", &effect, list_effects());
  Place place;
  map.child("where", [&](YamlMap& where) {
    where.text("joint", &place.joint);
    where.text("link", &place.link);
    where.text("foot", &place.foot);
    where.text("sensor", &place.sensor);
    where.ignore("ground");
  });
  map.require("parameters", "the effect's parameters");
  map.child("parameters", [&](YamlMap& parameters) {
    if (effect.empty() || !read_effect(effect, place, parameters, scenario)) parameters.error("", "belong to no effect");
  });
  for (const char* comment : {"probability", "statement"}) map.ignore(comment);
}

void check_bushes(YamlMap& map, const Scenario& scenario) {
  for (const auto& [foot, bush] : scenario.foot_bush) {
    const bool complete = bush.kz > 0.0 && bush.k_roll > 0.0 && bush.k_pitch > 0.0;
    const char* section = map.has("foot_bush") ? "foot_bush" : "effects";
    if (!complete) map.error(section, "the bush of '" + foot + "' needs kz, k_roll and k_pitch > 0");
    if (std::find(scenario.feet.begin(), scenario.feet.end(), foot) != scenario.feet.end()) continue;
    map.error(section, "'" + foot + "' is not in the list of feet");
  }
}

// What a clock gains or loses must be kept for as long: 60 s are a great many samples.
void check_clocks(YamlMap& map, const Scenario& scenario) {
  const auto check = [&](const std::string& name, const SensorErrors& errors) {
    if (errors.clock_skew == 0.0) return;
    const char* section = map.has("effects") ? "effects" : "sensors";
    if (scenario.duration <= 0.0) map.error(section, "the clock_skew of '" + name + "' needs steps.duration");
    if (std::abs(errors.clock_skew) * scenario.duration > 60.0) {
      map.error(section, "the clock of '" + name + "' is off by more than 60 s at the end of the run");
    }
  };
  for (const ImuSpec& imu : scenario.sensors.imus) check(imu.name, imu.gyro), check(imu.name, imu.accelerometer);
  for (const WrenchSpec& wrench : scenario.sensors.wrenches) check(wrench.name, wrench.force), check(wrench.name, wrench.torque);
}

}  // namespace

const std::vector<EffectSpec>& get_joint_effects() {
  static const std::vector<EffectSpec> effects = {
      {"viscous_friction", {"coefficient"}, {}},
      {"coulomb_friction", {"level"}, {"asymmetry"}},
      {"stribeck_friction", {"coulomb", "static", "stribeck_velocity"}, {"viscous"}},
      {"load_dependent_friction", {"ratio"}, {}},
      {"rotor_inertia", {"inertia"}, {}},
      {"joint_elasticity", {"stiffness", "damping", "rotor_inertia"}, {}},
      {"backlash", {"gap"}, {"stiffness", "damping", "rotor_inertia"}},
      {"torque_constant_error", {"scale"}, {}},
      {"torque_saturation", {"limit"}, {}},
      {"actuator_lag", {"time_constant"}, {}},
      {"command_delay", {"delay"}, {}},
      {"parallel_spring", {"stiffness"}, {"rest"}},
      {"cogging", {"amplitude", "periods"}, {"phase"}},
      {"hysteresis", {"stiffness", "yield_angle"}, {}},
      {"joint_offset", {"offset"}, {}}};
  return effects;
}

void read_effect_sections(YamlMap& map, Scenario* scenario) {
  map.child("joint_laws", [&](YamlMap& child) { read_joint_laws(child, scenario); });
  map.child("link_laws", [&](YamlMap& child) { read_link_laws(child, scenario); });
  map.list("effects", [&](size_t, YamlMap& child) { read_finding(child, scenario); });
  check_bushes(map, *scenario);
  check_clocks(map, *scenario);
}

}  // namespace hrp
