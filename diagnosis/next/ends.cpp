// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/ends.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/next/information.h"
#include "diagnosis/search/parameters.h"

namespace hrp::diagnosis {

std::vector<Hypothesis> list_ends(const Hypothesis& hypothesis, const Eigen::MatrixXd& fisher,
                                  const Hypothesis& looked_at) {
  const auto parameters = flatten<EffectParameter>(
      hypothesis, [](const Effect& e) -> const std::vector<EffectParameter>& { return list_infos(e.id); },
      [](size_t, const EffectParameter& info) { return !info.scanned; });
  if (fisher.rows() != static_cast<long>(parameters.size())) return {};
  Eigen::VectorXd largest(fisher.rows());
  for (size_t i = 0; i < parameters.size(); ++i) {
    const double value = hypothesis[parameters[i].effect].p[parameters[i].index];
    largest[static_cast<long>(i)] = kHalf * std::max(std::abs(value), parameters[i].info->step) / kNinetyFive;
  }
  const Eigen::VectorXd std = calc_expected_std(fisher, largest);
  std::vector<Hypothesis> ends;
  for (size_t i = 0; i < parameters.size(); ++i) {
    const Effect& own = hypothesis[parameters[i].effect];
    if (contains(looked_at, own.id, own.place)) continue;
    for (double side : {-kNinetyFive, kNinetyFive}) {
      Hypothesis end = hypothesis;
      double& value = end[parameters[i].effect].p[parameters[i].index];
      value = std::clamp(value + side * std[static_cast<long>(i)], parameters[i].info->low, parameters[i].info->high);
      ends.push_back(end);
    }
  }
  return ends;
}

}  // namespace hrp::diagnosis
