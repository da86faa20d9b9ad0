// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/plan_list.h"

#include "common/base/has.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/next/hung_loads.h"
#include "diagnosis/search/starts.h"

namespace hrp::diagnosis {
namespace {

constexpr unsigned kSeeds = 2;  // of each family

// Adds motions with loads. A weight shows best if joints are slow or at rest.
void add_loaded(const Experiment& e, const Limits& limits, std::vector<MotionPlan>* plans) {
  const std::vector<MotionPlan> bare = *plans;
  for (const LoadSpec& load : list_hung_loads(e.robot.tree, limits.load)) {
    for (MotionPlan plan : bare) {
      const bool slow =
          plan.family == Family::kPostures || plan.family == Family::kCreep || plan.family == Family::kTwoSpeeds;
      if (!slow || plan.seed > kSeeds) continue;
      plan.loads = {load};
      plans->push_back(plan);
    }
  }
}

// The same motions with slow sines.
void add_slow_sines(std::vector<MotionPlan>* plans) {
  const std::vector<MotionPlan> quick = *plans;
  for (MotionPlan plan : quick) {
    if (plan.family != Family::kMultisine) continue;
    plan.quickest = kSlowSines;
    plans->push_back(plan);
  }
}

// A joint with `mimic` moves as its leader does.
void mark_mover(const TreeSpec& tree, int joint, std::vector<char>* moves) {
  const int leader = tree.joint(joint).mimic.joint;
  (*moves)[static_cast<size_t>(leader < 0 ? joint : leader)] = 1;
}

}  // namespace

void mark_concerned(const Experiment& e, const Hypothesis& hypothesis, std::vector<char>* moves) {
  for (const Effect& effect : hypothesis) {
    const int joint = find_joint(effect);
    if (joint >= 0) mark_mover(e.robot.tree, joint, moves);
    if (effect.place.kind != PlaceKind::kLink) continue;
    for (int link = effect.place.index; link > 0; link = e.robot.tree.links[static_cast<size_t>(link)].parent)
      mark_mover(e.robot.tree, link - 1, moves);
  }
}

bool make_smaller(const std::vector<char>& faulty, MotionPlan* plan) {
  // A joint of half the size that stays at fault suffers from what the others do to it, or from the posture.
  bool any = false;
  plan->shares.resize(faulty.size(), 1.0);
  for (size_t j = 0; j < faulty.size(); ++j) {
    if (!faulty[j] || !plan->moves[j] || plan->shares[j] * kMostly < kHalf) continue;
    plan->shares[j] *= kMostly;
    any = true;
  }
  if (!any) plan->size *= kMostly;
  return plan->size >= kMinority;
}

std::vector<MotionPlan> list_plans(const Experiment& e, const Limits& limits, const std::vector<char>& concerned,
                                   double seconds) {
  std::vector<MotionPlan> plans;
  std::vector<char> all(static_cast<size_t>(e.num_joints()), 1);
  for (size_t j = 0; j < all.size(); ++j) all[j] = limits.joints[j].mimic.joint < 0;
  const bool apart = concerned != all && has(concerned, 1);
  for (int f = 0; f < static_cast<int>(Family::kCount); ++f) {
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      MotionPlan plan;
      plan.family = static_cast<Family>(f);
      plan.seed = seed;
      plan.seconds = seconds;
      plan.period = kPeriod;
      plan.moves = all;
      plans.push_back(plan);
      if (!apart) continue;
      plan.moves = concerned;
      plan.seed += kSeeds;
      plans.push_back(plan);
    }
  }
  add_slow_sines(&plans);
  add_loaded(e, limits, &plans);
  return plans;
}

}  // namespace hrp::diagnosis
