// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/exchanged_legs.h"

#include <vector>

#include "common/base/rounding.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/imu_over_legs.h"
#include "diagnosis/floating/conventions/sides.h"

namespace hrp::diagnosis::floating {
namespace {

// Feet lie a little askew, each its own way: only how the body turns tells legs apart.
std::vector<Standing> list_turning(const LeggedLog& log, size_t imu) {
  std::vector<Standing> out = list_standing(log, imu, Purpose::kForTurns);
  for (Standing& s : out) forget_up(&s.feet);
  return out;
}

}  // namespace

std::string find_exchanged_legs(const Experiment& e) {
  if (!e.scenario.floating_base || e.num_joints() == 0) return "";
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const int imu = BodyMotion::find_main_imu(log);
  const std::vector<std::pair<size_t, size_t>> pairs = list_leg_pairs(log);
  if (imu < 0 || pairs.empty()) return "";
  const auto i = static_cast<size_t>(imu);
  const LeggedLog other = exchange_legs(log, pairs);
  const std::vector<Standing> as_named = list_turning(log, i), exchanged = list_turning(other, i);
  if (as_named.empty() || as_named.size() != exchanged.size()) return "";
  const std::vector<double> left = list_left(log, i, as_named, {}), left_exchanged = list_left(other, i, exchanged, {});
  const double nats = calc_odds(list_instants(as_named), left_exchanged, left);
  const double before = calc_mean(left), after = calc_mean(left_exchanged);
  if (nats < kOdds || after * after > kHalf * before * before) return "";
  return "the columns of left and right legs look exchanged (" + log.tree.joint(static_cast<int>(pairs[0].first)).name +
         " and " + log.tree.joint(static_cast<int>(pairs[0].second)).name +
         ", and so on): over feet that stand, /imu/" + log.imus[i].name + " leaves " + number(after / before, 2) +
         " of what it leaves now, if they are taken the other way round";
}

}  // namespace hrp::diagnosis::floating
