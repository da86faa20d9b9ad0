// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/gain_spread.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

bool scales_effort(const Term& term) { return term.row->scales_effort; }

// Place of the gain among the joint's terms in the model; none if it is not fitted.
std::optional<size_t> find_fitted_gain(const TorqueDesign& design, const TorqueModel& model, size_t joint) {
  const std::vector<size_t>& own = model.own[joint];
  const auto at =
      std::find_if(own.begin(), own.end(), [&](size_t t) { return scales_effort(design.joints[joint].terms[t]); });
  return at == own.end() ? std::nullopt : std::optional<size_t>(static_cast<size_t>(at - own.begin()));
}

// Standard deviation [1] of the joint's gain if it were fitted beside the model; infinite if its motion does not show
// one.
double calc_std_if_fitted(const TorqueDesign& design, const TorqueModel& model, size_t joint) {
  const std::vector<Term>& terms = design.joints[joint].terms;
  const auto gain = std::find_if(terms.begin(), terms.end(), &scales_effort);
  if (gain == terms.end() || !design.joints[joint].loaded) return HUGE_VAL;
  TorqueModel with = model;
  const size_t at = add_own_term(joint, static_cast<size_t>(gain - terms.begin()), &with);
  const long slot = list_slots(design, with).own[joint][at];
  return std::sqrt(std::max(0.0, fit_torque(design, with, true).covariance(slot, slot)));
}

}  // namespace

std::vector<double> calc_gain_std(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit) {
  const size_t n = design.joints.size();
  std::vector<double> known(n, kKnown), shown(n, HUGE_VAL);
  std::vector<size_t> others;  // joints without a fitted gain
  const Slots slots = list_slots(design, model);
  double square = 0.0, fitted = 0.0;
  for (size_t i = 0; i < n; ++i) {
    const std::optional<size_t> at = find_fitted_gain(design, model, i);
    if (at) {
      square += std::pow(fit.theta[slots.own[i][*at]], 2);
      fitted += 1.0;  // the column's coefficient is 1 - gain
    } else {
      others.push_back(i);
    }
  }
  if (fitted == 0.0) return known;
  // A joint whose gain would show at two standard errors and is not in the model counts as one that is right.
  const double typical = std::sqrt(square / fitted);
  double told = fitted;
  for (size_t i : others) {
    shown[i] = calc_std_if_fitted(design, model, i);
    if (shown[i] < kHalf * typical) told += 1.0;
  }
  const double spread = std::sqrt(square / told * (1.0 + 1.0 / told));  // for the gain of one more drive
  for (size_t i : others) known[i] = std::max(kKnown, 1.0 / std::hypot(1.0 / spread, 1.0 / shown[i]));
  return known;
}

}  // namespace hrp::diagnosis
