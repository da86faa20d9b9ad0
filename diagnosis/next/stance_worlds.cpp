// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_worlds.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/diagnostics.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/model/tree.h"
#include "diagnosis/next/explanations.h"
#include "diagnosis/next/limits.h"
#include "diagnosis/next/stance_rivals.h"
#include "diagnosis/next/torque_worlds.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis {
namespace {

// Simulations along every motion: of values that change by a step, six of each of two soles.
constexpr size_t kMostValues = 12;

std::string make_label(const Json& effects) {
  std::string text;
  for (const Json& one : effects) {
    const Json& where = one["where"];
    text += (text.empty() ? "" : " + ") + one["effect"].get<std::string>() +
            (where.empty() ? "" : "@" + where.begin()->get<std::string>());
  }
  return text.empty() ? "nothing" : text;
}

// The scenario with these effects; empty if the simulator lacks a law for one of them, or the report states no values.
std::optional<Scenario> make_scenario(const Experiment& e, const Json& effects) {
  if (std::any_of(effects.begin(), effects.end(), [](const Json& one) { return !one.contains("parameters"); }))
    return std::nullopt;
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
  if (!parameter.is_object() || !parameter.contains("ci95") || parameter["ci95"].size() != 2 ||
      !parameter["ci95"][0].is_number())
    return 0.0;
  return 0.5 * (parameter["ci95"][1].get<double>() - parameter["ci95"][0].get<double>()) / kNinetyFive;
}

// A value without an interval moves by a minor part of itself.
double find_step(const Json& parameter) {
  const double value = get_number(parameter)->get<double>(), std = find_std(parameter);
  return std > 0.0 ? std : kMinor * std::abs(value);
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
    const bool empty = model.empty();
    model = keep_known(model);
    const Json rivals = list_rivals(report);
    if (!rivals.empty()) model.push_back(rivals[0]);
    best_ = model;
    if (!add(model, name_best(!empty, rivals))) return;
    add_ends(model);
    for (const Json& finding : findings) add_alternatives(model, finding);
    if (!rivals.empty()) add_alternatives(model, make_riddle(rivals));
    find_still();
    out_.open = !empty || report.value("verdict", "") != "no_mismatch";
    if (empty && model.empty() && report.value("verdict", "") == "no_mismatch") add_hidden();
    if (const auto nominal = make_scenario(e, Json::array()))
      out_.ends.push_back({"the nominal model", *nominal, {}, {}});
  }

  const StanceWorlds& worlds() const { return out_; }

 private:
  static std::string name_best(bool found, const Json& rivals) {
    const std::string guess = rivals.empty() ? "" : make_label(Json::array({rivals[0]}));
    if (!found) return guess.empty() ? "nothing" : guess;
    return guess.empty() ? "the report's model" : "the report's model + " + guess;
  }

  // Scenario and faults of logs; empty if neither a simulator nor the readings know one of the effects.
  std::optional<StanceWorld> make_world(const Json& effects) const {
    Json acting = Json::array();
    StanceWorld world;
    for (const Json& effect : effects) {
      const auto fault = effect.contains("parameters") ? find_log_fault(e_, effect) : std::nullopt;
      if (fault)
        world.faults.push_back(*fault);
      else
        acting.push_back(effect);
    }
    const auto scenario = make_scenario(e_, acting);
    if (!scenario) return std::nullopt;
    world.scenario = *scenario;
    return world;
  }

  // Without what neither a simulator nor the readings know.
  Json keep_known(const Json& model) {
    Json kept = Json::array();
    for (const Json& effect : model) {
      if (make_world(Json::array({effect})))
        kept.push_back(effect);
      else
        out_.remarks.push_back(
            "no simulation has these values: neither their safety nor what they would show was looked at: " +
            make_label(Json::array({effect})));
    }
    return kept;
  }

  bool add(const Json& effects, const std::string& label) {
    auto world = make_world(effects);
    if (!world) {
      out_.remarks.push_back(
          "no simulation has these values: neither its safety nor what it would show was looked at: " + label);
      return false;
    }
    world->label = label;
    out_.list.push_back(std::move(*world));
    out_.list.size() == 1 ? add_moves_of_best(effects) : add_moves_of_rival(effects);
    return true;
  }

  std::optional<StanceMove> make_move(const Json& effects, size_t effect, const std::string& name, double step) const {
    const auto world = make_world(move(effects, effect, name, step));
    if (!world) return std::nullopt;
    return StanceMove{-1, find_log_fault(e_, effects[effect]).has_value(), world->scenario, world->faults};
  }

  void add_moves_of_best(const Json& effects) {
    std::vector<std::pair<double, StanceValue>> values;
    std::vector<StanceMove> moves;
    for_each_value(effects, [&](size_t i, const std::string& name, const Json& parameter) {
      const double value = get_number(parameter)->get<double>(), step = find_step(parameter);
      const auto moved = make_move(effects, i, name, step);
      if (!moved) return;
      moves.push_back(*moved);
      values.push_back({step / std::max(1e-9, std::abs(value)),
                        {make_label(Json::array({effects[i]})), name,
                         parameter.is_object() ? parameter.value("unit", "") : "", value, find_std(parameter)}});
    });
    std::vector<double> widths;
    for (const auto& [width, value] : values) widths.push_back(width);
    std::sort(widths.rbegin(), widths.rend());
    const double least = widths.size() > kMostValues ? widths[kMostValues - 1] : 0.0;
    for (size_t i = 0; i < values.size() && out_.values.size() < kMostValues; ++i) {
      if (values[i].first < least) continue;
      out_.values.push_back(values[i].second);
      out_.list[0].moves.push_back(moves[i]);
    }
  }

  // What both models have changes the readings alike.
  void add_moves_of_rival(const Json& effects) {
    StanceWorld& world = out_.list.back();
    for_each_value(effects, [&](size_t i, const std::string& name, const Json& parameter) {
      const std::string label = make_label(Json::array({effects[i]}));
      const auto same = std::find_if(out_.values.begin(), out_.values.end(),
                                     [&](const StanceValue& v) { return v.label == label && v.parameter == name; });
      if (same != out_.values.end()) {
        world.moves.push_back({static_cast<int>(same - out_.values.begin()), false, {}, {}});
      } else if (!is_in_best(effects[i])) {
        const auto moved = make_move(effects, i, name, find_step(parameter));
        if (moved) world.moves.push_back(*moved);
      }
    });
  }

  bool is_in_best(const Json& effect) const {
    return std::any_of(best_.begin(), best_.end(), [&](const Json& one) {
      return one["effect"] == effect["effect"] && one["where"] == effect["where"];
    });
  }

  // The least certain values one by one, the rest together: in a dirty world every joint has several, each of them well
  // known.
  void add_ends(const Json& model) {
    Json together[2] = {model, model};
    bool more = false;
    for_each_value(model, [&](size_t i, const std::string& name, const Json& parameter) {
      const std::string label = make_label(Json::array({model[i]}));
      const bool alone = std::any_of(out_.values.begin(), out_.values.end(),
                                     [&](const StanceValue& v) { return v.label == label && v.parameter == name; });
      for (int side : {0, 1}) {
        const double by = (2.0 * side - 1.0) * kNinetyFive * find_step(parameter);
        const auto end = make_world(move(model, i, name, by));
        if (end && alone) {
          out_.ends.push_back({name + " at the end of its interval", end->scenario, {}, {}});
        } else if (end) {
          together[side] = move(together[side], i, name, by);
          more = true;
        }
      }
    });
    for (int side : {0, 1}) {
      const auto end = more ? make_world(together[side]) : std::nullopt;
      if (end)
        out_.ends.push_back(
            {std::string("all other values at the ") + (side ? "upper" : "lower") + " ends of their intervals",
             end->scenario,
             {},
             {}});
    }
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
      if (out_.list.size() <= kShortList)
        add(together, make_label(Json::array({other})) + " instead of " + make_label(Json::array({finding})));
      else if (++left_out_ == 1)
        out_.remarks.push_back("only the first " + std::to_string(kShortList) + " alternatives were simulated");
    }
  }

  // What may be at the loudest joint that nothing explains. The motion has to tell these apart, so one of them is in
  // the model that the others are compared with.
  Json list_rivals(const Json& report) {
    for (const Riddle& riddle : list_riddles(e_, report)) {
      Json rivals = list_joint_rivals(e_, riddle);
      if (rivals.empty()) continue;
      out_.remarks.push_back(
          "nothing explains " + riddle.joint +
          " yet: the explanations are guesses of what its drive may have, each as large as what is missing there");
      return rivals;
    }
    return Json::array();
  }

  static Json make_riddle(const Json& rivals) {
    Json finding = rivals[0];
    finding["alternatives"] = Json::array();
    for (size_t i = 1; i < rivals.size(); ++i) finding["alternatives"].push_back(rivals[i]);
    return finding;
  }

  // Hip yaws stand still in many walks that are explained: joints of legs do not count here.
  bool is_limb(int joint) const {
    const TreeSpec& tree = e_.robot.tree;
    return std::none_of(e_.scenario.feet.begin(), e_.scenario.feet.end(), [&](const std::string& foot) {
      const int frame = tree.find_frame(foot);
      return frame >= 0 &&
             is_above(tree, joint + 1, tree.frames[static_cast<size_t>(frame)].link);  // link j + 1 moves with joint j
    });
  }

  void find_still() {
    for (int j = 0; j < e_.num_joints(); ++j) out_.still = out_.still || (is_limb(j) && calc_travel(e_, j) < kStill);
  }

  // The stillest joints first. A motion tells of such a friction whatever its level is, so it has no free value.
  void add_hidden() {
    out_.unseen = true;
    std::vector<std::pair<double, int>> still;
    for (int j = 0; j < e_.num_joints(); ++j) {
      const double travel = calc_travel(e_, j);
      if (travel < kStill) still.push_back({travel, j});
    }
    std::stable_sort(still.begin(), still.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (size_t i = 0; i < still.size() && out_.list.size() <= kShortList; ++i) {
      for (const Effect& friction : make_hidden_friction(e_, still[i].second)) {
        Json parameters = Json::object();
        const std::vector<EffectParameter>& infos = list_infos(friction.id);
        for (size_t p = 0; p < infos.size(); ++p) {
          if (std::isfinite(infos[p].neutral)) parameters[infos[p].name] = {{"value", friction.p[p]}};
        }
        const Json where = {{"joint", e_.robot.tree.joint(still[i].second).name}};
        const Json effects =
            Json::array({{{"effect", get_effect(friction.id).name}, {"where", where}, {"parameters", parameters}}});
        if (add(effects, make_label(effects))) out_.list.back().moves.clear();
      }
    }
  }

  const Experiment& e_;
  StanceWorlds out_;
  Json best_;
  int left_out_ = 0;
};

}  // namespace

StanceWorlds make_stance_worlds(const Experiment& experiment, const Json& report) {
  return Maker(experiment, report).worlds();
}

}  // namespace hrp::diagnosis
