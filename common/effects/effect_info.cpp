// SPDX-License-Identifier: BSD-3-Clause
#include "common/effects/effect_info.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/base/check.h"
#include "common/effects/effect_rows.h"

namespace hrp {
namespace {

std::vector<EffectInfo> make_table() {
  std::vector<EffectInfo> named(static_cast<size_t>(EffectId::kNamed)), others;
  for (auto* list : {&list_friction_rows, &list_drive_rows, &list_transmission_rows, &list_link_rows, &list_world_rows,
                     &list_sensor_rows}) {
    for (EffectInfo& row : (*list)()) {
      if (row.id == EffectId::kNamed)
        others.push_back(std::move(row));
      else
        named[static_cast<size_t>(row.id)] = std::move(row);
    }
  }
  for (EffectInfo& row : others) {
    row.id = static_cast<EffectId>(named.size());
    named.push_back(std::move(row));
  }
  for (const EffectInfo& row : named) {
    HRP_CHECK(!row.name.empty() && !row.parameters.empty(), "the table of effects lacks the row of an enumerator");
  }
  return named;
}

std::vector<std::vector<EffectParameter>> make_scalars() {
  std::vector<std::vector<EffectParameter>> all;
  for (const EffectInfo& row : list_effects()) {
    all.emplace_back();
    for (const EffectParameter& parameter : row.parameters) {
      if (parameter.axis > 0) continue;
      all.back().push_back(parameter);
      all.back().back().axis = -1;
    }
  }
  return all;
}

}  // namespace

std::string EffectParameter::key() const {
  static const char* const kAxes[] = {"_x", "_y", "_z"};
  return axis < 0 ? name : name + kAxes[axis];
}

EffectParameter& EffectParameter::absent_at(double x) {
  neutral = x;
  return *this;
}

EffectParameter& EffectParameter::bounds(double lower_in, double upper_in) {
  lower = lower_in;
  upper = upper_in;
  return search(std::max(low, lower), std::min(high, upper));
}

EffectParameter& EffectParameter::search(double low_in, double high_in) {
  low = low_in;
  high = high_in;
  return *this;
}
EffectParameter& EffectParameter::size(double step_in) {
  step = step_in;
  return *this;
}
EffectParameter& EffectParameter::optional(double value_in) {
  required = false;
  value = value_in;
  return *this;
}
EffectParameter& EffectParameter::internal() {
  required = stated = false;
  nuisance = true;
  return *this;
}
EffectParameter& EffectParameter::as_nuisance() {
  nuisance = true;
  return *this;
}
EffectParameter& EffectParameter::of_direction() {
  by_direction = nuisance = true;
  return *this;
}
EffectParameter& EffectParameter::as_scanned() {
  scanned = true;
  return *this;
}
EffectParameter& EffectParameter::as_angle() {
  angle = true;
  return *this;
}
EffectParameter& EffectParameter::as_walked() {
  walked = true;
  return *this;
}
EffectParameter& EffectParameter::as_factor() {
  factor = true;
  neutral = value = 1.0;
  return *this;
}

EffectParameter& EffectParameter::starts(std::vector<double> factors, std::vector<double> values) {
  start_factors = std::move(factors);
  start_values = std::move(values);
  return *this;
}
EffectParameter& EffectParameter::swings(int rotor) {
  swings_with = rotor;
  return *this;
}
EffectParameter& EffectParameter::at_least(int index) {
  not_below = index;
  return *this;
}
EffectParameter& EffectParameter::probed_by(double step_in) {
  probe = step_in;
  return *this;
}

EffectInfo make_row(EffectId id, const char* name, PlaceKind place, EffectFamily family, const char* phrase,
                    std::vector<EffectParameter> parameters) {
  EffectInfo row;
  row.id = id;
  row.name = name;
  row.place = place;
  row.family = family;
  row.phrase = phrase;
  row.parameters = std::move(parameters);
  return row;
}

std::vector<EffectParameter> make_axes(const EffectParameter& parameter) {
  std::vector<EffectParameter> axes(3, parameter);
  for (int i = 0; i < 3; ++i) axes[static_cast<size_t>(i)].axis = i;
  return axes;
}

const char* get_family_name(EffectFamily family) {
  switch (family) {
    case EffectFamily::kDryFriction: return "dry friction";
    case EffectFamily::kSpeedLoss: return "speed-dependent loss";
    case EffectFamily::kReflectedInertia: return "reflected inertia";
    case EffectFamily::kMass: return "mass and its place";
    case EffectFamily::kGain: return "gain";
    case EffectFamily::kTiming: return "timing";
    case EffectFamily::kPlay: return "give and play";
    case EffectFamily::kTorqueOverPosition: return "torque over position";
    case EffectFamily::kZero: return "zero";
    case EffectFamily::kLimits: return "limits";
    case EffectFamily::kContact: return "contact";
    case EffectFamily::kSensorGeometry: return "geometry of sensors";
  }
  return "";
}

const std::vector<EffectInfo>& list_effects() {
  static const std::vector<EffectInfo> table = make_table();
  return table;
}

const EffectInfo& get_effect(EffectId id) { return list_effects().at(static_cast<size_t>(id)); }

const EffectInfo* find_effect(const std::string& name) {
  for (const EffectInfo& row : list_effects()) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

int find_parameter(const EffectInfo& effect, const std::string& name) {
  for (size_t i = 0; i < effect.parameters.size(); ++i) {
    if (effect.parameters[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

const std::vector<EffectParameter>& list_scalar_parameters(EffectId id) {
  static const std::vector<std::vector<EffectParameter>> all = make_scalars();
  return all.at(static_cast<size_t>(id));
}

ValueFault find_values(const EffectInfo& effect, const std::map<std::string, double>& stated,
                       std::vector<double>* values) {
  values->clear();
  for (const EffectParameter& parameter : effect.parameters) {
    const auto at = stated.find(parameter.key());
    const bool given = at != stated.end();
    if (!given && parameter.required) return {parameter.name, "is missing"};
    if (given && !parameter.stated) return {parameter.name, "is no parameter of a robot"};
    const std::string fault = given ? find_fault(parameter, at->second) : "";
    if (!fault.empty()) return {parameter.name, fault + " " + parameter.unit};
    const double open = parameter.scanned ? std::nan("") : parameter.value;  // searches scan what a law leaves open
    values->push_back(given ? at->second : open);
  }
  for (const auto& [key, value] : stated) {
    const auto same = [&k = key](const EffectParameter& parameter) { return parameter.key() == k; };
    if (std::none_of(effect.parameters.begin(), effect.parameters.end(), same)) return {key, "is unknown"};
  }
  return {};
}

std::string find_fault(const EffectParameter& parameter, double value) {
  if (value >= parameter.lower && value <= parameter.upper) return "";
  std::ostringstream text;
  text << "is " << value << ", expected " << parameter.lower << " to " << parameter.upper;
  return text.str();
}

}  // namespace hrp
