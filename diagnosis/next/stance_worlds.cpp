// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_worlds.h"

#include <cmath>
#include <optional>

#include "common/base/diagnostics.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis {
namespace {

std::string make_label(const Json& effects) {
  std::string text;
  for (const Json& one : effects) {
    const Json& where = one["where"];
    text += (text.empty() ? "" : " + ") + one["effect"].get<std::string>() +
            (where.empty() ? "" : "@" + where.begin()->get<std::string>());
  }
  return text.empty() ? "nothing" : text;
}

// The scenario with these effects; empty if the simulator lacks a law for one of them.
std::optional<Scenario> make_scenario(const Experiment& e, const Json& effects) {
  try {
    const std::string text = make_scenario_text(e, nlohmann::json::parse(effects.dump()));
    if (text.find("# not simulated") != std::string::npos) return std::nullopt;
    return parse_scenario(text, e.scenario.path);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

const Json* get_number(const Json& parameter) {
  const Json* value = parameter.is_object() && parameter.contains("value") ? &parameter["value"] : &parameter;
  return value->is_number() ? value : nullptr;
}

// Standard deviation from the 95 % interval; 0 if there is none.
double find_std(const Json& parameter) {
  if (!parameter.is_object() || !parameter.contains("ci95") || parameter["ci95"].size() != 2 || !parameter["ci95"][0].is_number()) return 0.0;
  return 0.5 * (parameter["ci95"][1].get<double>() - parameter["ci95"][0].get<double>()) / kNinetyFive;
}

double find_step(const Json& parameter) {
  const double value = get_number(parameter)->get<double>(), std = find_std(parameter);
  return std > 0.0 ? std : kUnknownStep * std::abs(value);
}

Json move(Json effects, size_t effect, const std::string& name, double by) {
  effects[effect]["parameters"][name] = get_number(effects[effect]["parameters"][name])->get<double>() + by;
  return effects;
}

// Calls visit(effect, name, parameter) for every number of the model that is not zero.
template <typename Visit>
void for_each_value(const Json& effects, const Visit& visit) {
  for (size_t i = 0; i < effects.size(); ++i) {
    const Json parameters = effects[i].value("parameters", Json::object());
    for (const auto& [name, parameter] : parameters.items()) {
      if (get_number(parameter) && find_step(parameter) > 0.0) visit(i, name, parameter);
    }
  }
}

class Maker {
 public:
  Maker(const Experiment& e, const Json& report) : e_(e) {
    const Json findings = report.value("findings", Json::array());
    Json model = report.value("model", Json::array());
    if (model.empty()) model = findings;
    if (!add(model)) return;
    add_ends(model);
    for (const Json& finding : findings) add_alternatives(model, finding);
    if (const auto nominal = make_scenario(e, Json::array())) out_.ends.push_back({"the nominal model", *nominal, {}});
  }

  const StanceWorlds& worlds() const { return out_; }

 private:
  bool add(const Json& effects) {
    const std::string label = make_label(effects);
    const auto scenario = make_scenario(e_, effects);
    if (!scenario) {
      out_.remarks.push_back("no simulation has these values: neither its safety nor what it would show was looked at: " + label);
      return false;
    }
    StanceWorld world{label, *scenario, {}};
    const bool best = out_.list.empty();
    for_each_value(effects, [&](size_t i, const std::string& name, const Json& parameter) {
      const auto moved = make_scenario(e_, move(effects, i, name, find_step(parameter)));
      if (!moved) return;
      world.moved.push_back(*moved);
      if (best) out_.values.push_back({make_label(Json::array({effects[i]})), name, parameter.is_object() ? parameter.value("unit", "") : "", get_number(parameter)->get<double>(), find_std(parameter)});
    });
    out_.list.push_back(std::move(world));
    return true;
  }

  void add_ends(const Json& model) {
    for_each_value(model, [&](size_t i, const std::string& name, const Json& parameter) {
      for (double side : {-1.0, 1.0}) {
        const auto end = make_scenario(e_, move(model, i, name, side * kNinetyFive * find_step(parameter)));
        if (end) out_.ends.push_back({name + " at the end of its interval", *end, {}});
      }
    });
  }

  void add_alternatives(const Json& model, const Json& finding) {
    Json rest = Json::array();
    for (const Json& one : model) {
      if (one["effect"] != finding["effect"] || one["where"] != finding["where"]) rest.push_back(one);
    }
    for (Json other : finding.value("alternatives", Json::array())) {
      if (!other.contains("where") || other["where"].empty()) other["where"] = finding["where"];
      Json together = rest;
      together.push_back(other);
      add(together);
    }
  }

  const Experiment& e_;
  StanceWorlds out_;
};

}  // namespace

StanceWorlds make_stance_worlds(const Experiment& experiment, const Json& report) { return Maker(experiment, report).worlds(); }

}  // namespace hrp::diagnosis
