// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/effect.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

bool is_fitted(const EffectParameter& parameter) { return parameter.stated && !parameter.nuisance; }

// A sensor's fault is one number where one number is read, and where its axes have it in common.
bool is_one_number(const EffectInfo& info, const Place& place) {
  return is_of_joint(place.reading) || (place.kind == PlaceKind::kSensor && !info.vector);
}

}  // namespace

const char* get_unit(Reading reading) {
  switch (reading) {
    case Reading::kPosition: case Reading::kOrientation: return "rad";
    case Reading::kVelocity: case Reading::kAngularVelocity: return "rad/s";
    case Reading::kEffort: case Reading::kTorque: return "N m";
    case Reading::kForce: return "N";
    case Reading::kAcceleration: return "m/s^2";
    default: return "";
  }
}

bool has_columns(EffectId id) {
  const EffectInfo& info = get_effect(id);
  if (info.torque.num_columns < 2 || !info.torque.shapes.empty() || info.torque.shape_from_data) return false;
  return info.torque.num_columns == std::count_if(info.parameters.begin(), info.parameters.end(), is_fitted);
}

std::vector<Coordinate> list_coordinates(EffectId id, const Place& place) {
  const EffectInfo& info = get_effect(id);
  std::vector<Coordinate> out;
  for (const EffectParameter& p : is_one_number(info, place) ? list_scalar_parameters(id) : info.parameters) {
    if (!is_fitted(p)) continue;
    const double neutral = std::isfinite(p.neutral) ? p.neutral : 0.0;
    out.push_back({&p, neutral, p.step, p.low == neutral});
  }
  return out;
}

PlacedEffect make_absent(EffectId id, const Place& place) {
  PlacedEffect effect{id, place, {}};
  for (const Coordinate& c : list_coordinates(id, place)) effect.p.push_back(c.neutral);
  return effect;
}

bool contains(const PlacedHypothesis& hypothesis, EffectId id, const Place& place) {
  return std::any_of(hypothesis.begin(), hypothesis.end(),
                     [&](const PlacedEffect& e) { return e.id == id && e.place == place; });
}

std::vector<double> make_values(const PlacedEffect& effect) {
  const EffectInfo& info = get_effect(effect.id);
  const bool one = is_one_number(info, effect.place);
  std::vector<double> values;
  size_t at = 0;
  for (const EffectParameter& p : info.parameters) {
    const bool repeated = one && p.axis > 0;
    if (!is_fitted(p))
      values.push_back(p.value);
    else
      values.push_back(std::clamp(effect.p[repeated ? at - 1 : at++], p.low, p.high));
  }
  return values;
}

ParameterValues make_parameter_values(const PlacedEffect& effect, const std::vector<double>& std) {
  ParameterValues out;
  for (const Coordinate& c : list_coordinates(effect.id, effect.place)) out.parameters.push_back(c.parameter);
  out.value = effect.p, out.std = std;
  if (!has_columns(effect.id)) return out;
  const EffectInfo& info = get_effect(effect.id);
  const size_t n = effect.p.size();
  const auto calc = [&](const std::vector<double>& x) {
    std::vector<double> all(info.parameters.size(), 0.0);
    info.torque.make_parameters(x.data(), nullptr, all.data());
    all.resize(n);  // fitted ones come first
    return all;
  };
  out.value = calc(effect.p);
  std::vector<double> variance(n, 0.0);
  for (size_t i = 0; i < n; ++i) {
    std::vector<double> moved = effect.p;
    const double step = std::max(1e-9, 1e-3 * std[i]);
    moved[i] += step;
    const std::vector<double> there = calc(moved);
    for (size_t k = 0; k < n; ++k) variance[k] += std::pow((there[k] - out.value[k]) / step * std[i], 2);
  }
  for (size_t k = 0; k < n; ++k) out.std[k] = std::sqrt(variance[k]);
  return out;
}

}  // namespace hrp::diagnosis
