// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/report.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

void fill_torque_fit(const std::vector<SignalFit>& torque, Fit* fit) {
  double before = 0.0, after = 0.0;
  for (const SignalFit& s : torque) {
    const double scale = 1.0 / std::max(1e-12, s.spread);
    before += std::pow(s.before * scale, 2);
    after += std::pow(s.after * scale, 2);
    fit->signals.push_back(s);
  }
  const double n = std::max(1.0, static_cast<double>(torque.size()));
  fit->over_spread = true;
  fit->train_before = fit->validate_before = std::sqrt(before / n);
  fit->train_after = fit->validate_after = std::sqrt(after / n);
}

namespace {

// Where the first parameter is outside the finding's interval: the simulation was fitted after the missing torque.
std::string describe_difference(const std::vector<double>& p, const Json& finding) {
  const Json& parameters = finding["parameters"];
  if (p.empty() || parameters.empty() || !parameters.begin()->contains("ci95")) return "";
  const Json &interval = (*parameters.begin())["ci95"], &value = (*parameters.begin())["value"];
  if (!value.is_number() || (p[0] >= interval[0].get<double>() && p[0] <= interval[1].get<double>())) return "";
  return "; the missing torque gives " + number(value.get<double>(), 3);
}

}  // namespace

Json list_torque_model(const Experiment& e, const Hypothesis& model, const Json& findings) {
  Json list = Json::array();
  for (const Effect& effect : model) {
    const Json where = make_where(e, effect);
    const std::string name = get_effect(effect.id).name;
    const std::string family = get_family_name(get_effect(effect.id).family);
    std::string grade = "not named: it helps to predict";
    for (const Json& f : findings) {
      if (f["where"] == where && f.value("family", "") == family)
        grade = f["grade"].get<std::string>() + " as " + f["effect"].get<std::string>();
    }
    for (const Json& f : findings) {
      if (f["effect"] == name && f["where"] == where)
        grade = f["grade"].get<std::string>() + describe_difference(effect.p, f);
    }
    Json parameters = make_estimates(list_estimates(e, effect, {}));
    for (Json& p : parameters) p = Json(p["value"]);  // the search's own, which have no intervals
    parameters.update(list_also_fitted(effect));
    list.push_back({{"effect", name}, {"where", where}, {"parameters", parameters}, {"grade", grade}});
  }
  return list;
}

Json list_whole_model(const Experiment& e, const Hypothesis& model, const Json& findings, const Json& body) {
  Json list = Json::array();
  for (const Json& f : body) list.push_back(make_model_entry(f));
  for (const Json& effect : list_torque_model(e, model, findings)) list.push_back(effect);
  return list;
}

}  // namespace hrp::diagnosis
