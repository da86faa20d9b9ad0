// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/torque_worlds.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

// All values at one end of their intervals. Values without an interval change by half. One robot with all losses and
// inertias at their largest needs the largest efforts, one with all at their smallest overshoots most.
Hypothesis move_to_ends(const OpenTerms& terms, double side) {
  Hypothesis moved = terms.best.hypothesis;
  for (Effect& effect : moved) {
    const std::vector<EffectParameter>& infos = list_infos(effect.id);
    for (size_t i = 0; i < infos.size(); ++i) {
      if (!std::isfinite(infos[i].neutral) || infos[i].nuisance) continue;  // a shape of a law
      const auto value = std::find_if(terms.values.begin(), terms.values.end(), [&](const OpenValue& v) {
        return v.effect == effect.id && v.place == effect.place && v.parameter == infos[i].name;
      });
      const double width =
          value != terms.values.end() ? value->half_width : kHalf * std::abs(effect.p[i] - infos[i].neutral);
      effect.p[i] = std::clamp(effect.p[i] + side * width, infos[i].low, infos[i].high);
    }
  }
  return moved;
}

}  // namespace

std::vector<TorqueWorld> list_torque_worlds(const OpenTerms& terms, const std::vector<size_t>& questions) {
  TorqueSide nothing = terms.best;
  nothing.hypothesis.clear();
  nothing.fit.theta.setZero();
  std::vector<TorqueWorld> worlds{{" under the nominal model", nothing, 0.0},
                                  {" under the report's model", terms.best, 0.0}};
  for (const double end : {-1.0, 1.0}) {
    TorqueSide side = terms.best;
    side.hypothesis = move_to_ends(terms, end);
    worlds.push_back(
        {std::string(" with all values at the ") + (end < 0.0 ? "lower" : "upper") + " ends of their intervals", side,
         end});
  }
  for (size_t q : questions) {
    const OpenQuestion& question = terms.questions[q];
    worlds.push_back({" if it is " + question.label, question.shown(), 0.0});
  }
  return worlds;
}

}  // namespace hrp::diagnosis
