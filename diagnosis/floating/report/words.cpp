// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/words.h"

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis::floating {

Estimate make_value(const EffectInfo& effect, double value, double std, const std::string& reading_unit) {
  const EffectParameter& parameter = effect.parameters[0];
  return make_one(parameter.name, parameter.unit.empty() ? reading_unit : parameter.unit, value, std);
}

std::string describe(const std::vector<Estimate>& parameters) {
  std::string out;
  for (const Estimate& e : parameters) {
    out += (out.empty() ? "" : ", ") + e.name + " ";
    for (size_t i = 0; i < e.value.size(); ++i) {
      out +=
          (i ? ", " : "") + (e.is_unseen(i) ? "unknown" : format("%.4g +- %.2g", e.value[i], kNinetyFive * e.std[i]));
    }
    if (e.unit != "1") out += " " + e.unit;
  }
  return out;
}

std::string get_place(const Where& where) {
  return where.empty() ? std::string("the robot") : where.begin().value().get<std::string>();
}

}  // namespace hrp::diagnosis::floating
