// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/proposal_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/next/plan_list.h"

namespace hrp::diagnosis {

double calc_worth(double decided, const std::vector<ExpectedInterval>& before,
                  const std::vector<ExpectedInterval>& after) {
  double narrowed = 0.0;
  for (size_t i = 0; i < after.size(); ++i) {
    // A parameter without an interval today cannot become narrower.
    const double ratio = before[i].before > 0.0 ? before[i].after / std::max(1e-300, after[i].after) : 1.0;
    narrowed += std::min(1.0, std::log2(std::max(1.0, ratio)) / 2.0) / static_cast<double>(after.size());
  }
  return decided + kHalf * narrowed;
}

double calc_expected_width(double half_width, const WidthParts& before, const WidthParts& after) {
  double other = half_width * half_width, left = 0.0;
  const auto take = [&](double now, double then, double most) {
    const double part = std::min(other, now * now);
    other -= part;
    left += part * (now > 0.0 ? std::min(most, then * then / (now * now)) : 1.0);
  };
  take(before.masses, after.masses, 1.0);
  take(before.noise, after.noise, 1.0);
  take(before.unseen, after.unseen, 1.0);
  take(before.considered, after.considered, std::numeric_limits<double>::infinity());
  return std::sqrt(other + left);
}

bool is_held_out(size_t number) { return number % 2 == 1; }

double calc_drawback(const MotionPlan& plan, const std::vector<Proposal>& proposals) {
  double factor = plan.loads.empty() ? 1.0 : kDrawback;
  for (const Proposal& p : proposals) factor *= p.plan.family == plan.family ? kDrawback : 1.0;
  return factor;
}

Proposal begin_proposal(size_t number, const MotionPlan& plan, const Commands& commands, double worth) {
  Proposal p;
  p.file = std::string(is_held_out(number) ? "validate_" : "train_") + std::to_string(number / 2 + 1) + ".csv";
  p.plan = plan;
  p.commands = commands;
  p.worth = worth;
  return p;
}

double calc_rms(const Comparison& comparison, double left) { return std::sqrt(left / std::max(1.0, comparison.count)); }

std::string describe_plan(const MotionPlan& plan) {
  return std::string(get_family_word(plan.family)) + (plan.loads.empty() ? "" : " with a load");
}

}  // namespace hrp::diagnosis
