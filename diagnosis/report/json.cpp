// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/report/json.h"

#include <limits>

#include "common/effects/units.h"

namespace hrp::diagnosis {

std::string get_place_unit(const Experiment& e, const Effect& effect, const EffectParameter& info) {
  return effect.place.kind == PlaceKind::kJoint ? get_joint_unit(e.robot.tree.joint(effect.place.index), info)
                                                : info.unit;
}

std::vector<Estimate> list_estimates(const Experiment& e, const Effect& effect, const std::vector<double>& std) {
  const std::vector<EffectParameter>& infos = list_infos(effect.id);
  std::vector<Estimate> list, vectors;
  const auto get_deviation = [&](size_t i) {
    return i < std.size() ? std::vector<double>{std[i]} : std::vector<double>();
  };
  for (size_t i = 0; i < infos.size(); ++i) {
    if (infos[i].axis < 0) {
      if (!infos[i].nuisance)
        list.push_back({infos[i].name, get_place_unit(e, effect, infos[i]), {effect.p[i]}, get_deviation(i), false});
      continue;
    }
    if (vectors.empty() || vectors.back().name != infos[i].name)
      vectors.push_back({infos[i].name, infos[i].unit, {}, {}, true});
    vectors.back().value.push_back(effect.p[i]);
    for (double deviation : get_deviation(i)) vectors.back().std.push_back(deviation);
  }
  list.insert(list.end(), vectors.begin(), vectors.end());
  return list;
}

Json make_value(double value, double std, const std::string& unit) {
  return make_estimate(make_one("", unit, value, std));
}

Json make_vector(const std::vector<double>& values, const std::vector<double>& std, const std::string& unit) {
  return make_estimate({"", unit, values, std, true});
}

std::string signal_name(const Experiment& e, size_t c) {
  return e.signal_name(static_cast<int>(c) / kQuantities, static_cast<Quantity>(c % kQuantities));
}

double read_value(const Json& parameters, const EffectParameter& p) {
  for (const std::string& name : {p.key(), p.name}) {
    if (!parameters.contains(name)) continue;
    const Json& value = parameters[name].is_object() ? parameters[name]["value"] : parameters[name];
    if (value.is_number()) return value.get<double>();
    const auto axis = static_cast<size_t>(p.axis);
    if (value.is_array() && p.axis >= 0 && axis < value.size() && value[axis].is_number())
      return value[axis].get<double>();
  }
  return std::numeric_limits<double>::quiet_NaN();
}

Json make_model_entry(const Json& finding) {
  return {{"effect", finding["effect"]},
          {"where", finding["where"]},
          {"parameters", finding["parameters"]},
          {"grade", finding["grade"]}};
}

Json make_where(const Experiment& e, const Effect& effect) {
  switch (effect.place.kind) {
    case PlaceKind::kJoint: return {{"joint", get_place_text(e, effect)}};
    case PlaceKind::kLink: return {{"link", get_place_text(e, effect)}};
    case PlaceKind::kSensor: return {{"sensor", get_place_text(e, effect)}};
    default:  // one clock, or the base
      if (get_effect(effect.id).family != EffectFamily::kTiming) return {{"link", e.robot.tree.links[0].name}};
      return {{"sensor", "clock"}};
  }
}

Place find_place(const Experiment& e, const EffectInfo& effect, const Json& where) {
  const PlaceKind kind = effect.place;
  if (kind == PlaceKind::kSensor && effect.family == EffectFamily::kTiming && !effect.change.any())
    return at_all();  // one clock
  if (kind == PlaceKind::kJoint && where.contains("joint"))
    return at_joint(e.robot.tree.find_joint(where["joint"].get<std::string>()));
  if (kind == PlaceKind::kLink && where.contains("link"))
    return at_link(e.robot.tree.find_link(where["link"].get<std::string>()));
  for (int c = 0; kind == PlaceKind::kSensor && where.contains("sensor") && c < e.num_joints() * kQuantities; ++c) {
    if (e.signal_name(c / kQuantities, static_cast<Quantity>(c % kQuantities)) == where["sensor"].get<std::string>())
      return at_signal(c);
  }
  return {kind, -1, Reading::kAll};
}

}  // namespace hrp::diagnosis
