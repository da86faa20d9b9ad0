// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/effect_section.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/effects/effect_target.h"

namespace hrp {
namespace {

const char* const kSpreads[] = {"std", "ci95", "unit"};  // of a finding: a simulation has no use for them

// A number, or a finding's {value: ..., std: ..., ci95: ..., unit: ...}.
void read_number(YamlMap& map, const std::string& key, double* value) {
  if (!map.is_mapping(key)) return map.number(key, value, Bound::kAny, "");
  map.child(key, [&](YamlMap& child) {
    child.require("value", "a number");
    child.number("value", value, Bound::kAny, "");
    for (const char* spread : kSpreads) child.ignore(spread);
  });
}

void read_vector(YamlMap& map, const std::string& key, Vector3d* value) {
  if (!map.is_mapping(key)) return map.axes3(key, value, Bound::kAny, "");
  map.child(key, [&](YamlMap& child) {
    child.require("value", "a list of 3 numbers");
    child.axes3("value", value, Bound::kAny, "");
    for (const char* spread : kSpreads) child.ignore(spread);
  });
}

// The parameters of one effect, whichever it is. What is out of bounds is complained about.
StatedEffect read_stated(const EffectInfo& effect, YamlMap& map) {
  StatedEffect out;
  out.effect = effect.name;
  Vector3d vector = Vector3d::Zero();
  for (const EffectParameter& parameter : effect.parameters) {
    if (!parameter.stated) continue;
    const bool first = parameter.axis <= 0;
    if (first && parameter.required) {
      map.require(parameter.name, parameter.axis == 0 ? "a list of 3 numbers" : "a number (docs/scenario.md)");
    }
    if (!map.has(parameter.name)) continue;
    double value = std::isfinite(parameter.neutral) ? parameter.neutral : std::max(0.0, parameter.lower);
    if (parameter.axis < 0) read_number(map, parameter.name, &value);
    if (parameter.axis == 0) read_vector(map, parameter.name, &vector);
    if (parameter.axis >= 0) value = vector[parameter.axis];
    const std::string fault = find_fault(parameter, value);
    if (!fault.empty()) map.error(parameter.name, fault);
    out.parameters[parameter.key()] = value;
  }
  return out;
}

std::vector<std::string> list_names() {
  std::vector<std::string> names;
  for (const EffectInfo& effect : list_effects()) {
    if (effect.reported) names.push_back(effect.name);
  }
  return names;
}

// Laws by name of a joint or link.
void read_laws(YamlMap& map, PlaceKind kind, std::map<std::string, std::vector<StatedEffect>>* laws) {
  map.each([&](const std::string& place, YamlMap& child) {
    for (const EffectInfo& effect : list_effects()) {
      if (effect.place != kind || !effect.reported) continue;
      child.child(effect.name, [&](YamlMap& law) { (*laws)[place].push_back(read_stated(effect, law)); });
    }
  });
}

// ---- effects: a list of {effect, where, parameters} ---------------------------------------------------------------

struct Place {
  std::string joint, link, foot, sensor;
};

// Reading groups of a sensor's path: "/wrench/NAME/torque" is one group, "/wrench/NAME" or "NAME" both, "/wrench" those
// of all force sensors.
std::vector<SensorErrors*> find_sensor(const std::string& path, Scenario* scenario) {
  const auto matches = [&](const char* kind, const std::string& name, const char* group) {
    const std::string of_kind = "/" + std::string(kind), all = of_kind + "/" + name;
    return path == name || path == of_kind || path == all || path == all + "/" + group;
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

// Acts on what the scenario has at the place; a value that makes no sense was complained about before.
void apply(const EffectInfo& effect, const StatedEffect& stated, const EffectTarget& target) {
  std::vector<double> values;
  if (find_values(effect, stated.parameters, &values).message.empty()) effect.apply(values.data(), target);
}

void apply_to_sensors(const EffectInfo& effect, const StatedEffect& stated, const std::string& path, YamlMap& map,
                      Scenario* scenario) {
  const std::vector<SensorErrors*> found = find_sensor(path, scenario);
  if (found.empty()) return map.error("", "there is no sensor '" + path + "' in 'sensors' that has this effect");
  for (SensorErrors* errors : found) {
    EffectTarget target;
    target.sensor = errors;
    apply(effect, stated, target);
  }
}

void read_effect(const EffectInfo& effect, const Place& place, YamlMap& map, Scenario* scenario) {
  const auto has = [&](const std::string& name, const char* kind) {
    if (name.empty()) map.error("", effect.name + " needs where: {" + kind + ": NAME}");
    return !name.empty();
  };
  if (!place.joint.empty()) map.mark_as("joint_laws." + place.joint);
  if (!place.link.empty()) map.mark_as("link_laws." + place.link);
  if (!place.foot.empty()) map.mark_as("foot_bush." + place.foot);
  const StatedEffect stated = read_stated(effect, map);
  EffectTarget target;
  switch (effect.place) {
    case PlaceKind::kJoint:
      if (has(place.joint, "joint")) scenario->joint_laws[place.joint].push_back(stated);
      break;
    case PlaceKind::kLink:
      if (has(place.link, "link")) scenario->link_laws[place.link].push_back(stated);
      break;
    case PlaceKind::kFoot:
      if (!has(place.foot, "foot")) break;
      target.bush = &scenario->foot_bush[place.foot];
      apply(effect, stated, target);
      break;
    case PlaceKind::kSensor:
      if (has(place.sensor, "sensor")) apply_to_sensors(effect, stated, place.sensor, map, scenario);
      break;
    case PlaceKind::kGround:
    case PlaceKind::kNone:
      target.ground = &scenario->ground;
      target.contact = &scenario->contact;
      target.gravity_W = &scenario->gravity_W;
      apply(effect, stated, target);
      break;
  }
}

void read_finding(YamlMap& map, Scenario* scenario) {
  map.require("effect", "the name of an effect");
  std::string effect;
  map.choice("effect", &effect, list_names());
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
    const EffectInfo* info = find_effect(effect);
    if (!info || !info->reported) return parameters.error("", "belong to no effect");
    read_effect(*info, place, parameters, scenario);
  });
  for (const char* comment : {"probability", "statement"}) map.ignore(comment);
}

void check_bushes(YamlMap& map, const Scenario& scenario) {
  for (const auto& [foot, bush] : scenario.foot_bush) {
    const bool complete = bush.kz > 0.0 && bush.k_roll > 0.0 && bush.k_pitch > 0.0;
    const char* section = map.has("foot_bush") ? "foot_bush" : "effects";
    if (!complete) map.error(section, "the bush of '" + foot + "' needs kz, k_roll and k_pitch > 0");
    if (has(scenario.feet, foot)) continue;
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
  for (const ImuSpec& imu : scenario.sensors.imus) {
    check(imu.name, imu.gyro);
    check(imu.name, imu.accelerometer);
  }
  for (const WrenchSpec& wrench : scenario.sensors.wrenches) {
    check(wrench.name, wrench.force);
    check(wrench.name, wrench.torque);
  }
}

}  // namespace

void read_effect_sections(YamlMap& map, Scenario* scenario) {
  map.child("joint_laws", [&](YamlMap& child) { read_laws(child, PlaceKind::kJoint, &scenario->joint_laws); });
  map.child("link_laws", [&](YamlMap& child) { read_laws(child, PlaceKind::kLink, &scenario->link_laws); });
  map.list("effects", [&](size_t, YamlMap& child) { read_finding(child, scenario); });
  check_bushes(map, *scenario);
  check_clocks(map, *scenario);
}

}  // namespace hrp
