// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/live_pushes.h"

#include <algorithm>
#include <cmath>

#include "common/messages/convert.h"

namespace hrp {
namespace {

constexpr double kHardestPush = 1e5;      // [N] nobody pushes a robot with more
constexpr uint64_t kMostSteps = 1000000;  // of one push, as of RunControl.steps

bool has_begun(const msg::Push& push, uint64_t step) { return push.number() > 0 && step > push.from_step(); }

}  // namespace

std::string find_push_fault(const msg::Push& push) {
  const Vector3d force = from_message(push.force()), point = from_message(push.p_LQ());
  if (!force.allFinite() || !point.allFinite()) return "a push needs a force [N] and a point [m] of finite numbers";
  if (force.norm() > kHardestPush)
    return "a push of " + std::to_string(force.norm()) + " N is more than the " +
           std::to_string(static_cast<long>(kHardestPush)) + " N that are allowed";
  if (push.steps() > kMostSteps)
    return "a push lasts at most " + std::to_string(kMostSteps) + " steps, not " + std::to_string(push.steps());
  return "";
}

std::string find_push_fault(const msg::Push& push, const TreeSpec& tree, const std::vector<Mover>& movers) {
  const bool known = tree.find_frame(push.link()) >= 0 || tree.find_link(push.link()) >= 0 ||
                     std::any_of(movers.begin(), movers.end(), [&](const Mover& m) {
                       return !find_own_link(push.link(), m.name, m.is_robot, m.robot.tree).empty();
                     });
  if (known) return find_push_fault(push);
  return "there is no link '" + push.link() + "' to push" +
         (movers.empty() ? "" : ", and no object; a link of another robot is ROBOT/LINK");
}

void PushQueue::add(const msg::Push& push) {
  const auto same = std::find_if(pushes_.begin(), pushes_.end(),
                                 [&](const msg::Push& p) { return p.number() == 0 && p.link() == push.link(); });
  msg::Push& kept = same != pushes_.end() ? *same : pushes_.emplace_back();
  kept = push;
  kept.number(0);
}

std::vector<msg::Push> PushQueue::give_out(uint64_t granted, uint64_t step) {
  const auto begun = [step](const msg::Push& push) { return has_begun(push, step); };
  pushes_.erase(std::remove_if(pushes_.begin(), pushes_.end(), begun), pushes_.end());
  for (msg::Push& push : pushes_) {
    if (push.number() > 0) continue;
    push.number(next_number_++);
    push.from_step(granted);
  }
  return pushes_;
}

void LivePushes::add(const msg::Push& push) {
  if (push.number() <= last_number_) return;
  last_number_ = push.number();
  pushes_.push_back(push);
}

void LivePushes::add_from(uint64_t step, msg::Push push) {
  push.number(last_number_ + 1);
  push.from_step(step);
  add(push);
}

PushForces LivePushes::find(uint64_t step) {
  PushForces acting;
  std::vector<msg::Push> left;
  for (size_t i = 0; i < pushes_.size(); ++i) {
    const msg::Push& push = pushes_[i];
    const bool replaced =
        std::any_of(pushes_.begin() + static_cast<long>(i) + 1, pushes_.end(),
                    [&](const msg::Push& next) { return next.link() == push.link() && next.from_step() <= step; });
    if (replaced || (push.from_step() <= step && step - push.from_step() >= push.steps())) continue;
    left.push_back(push);
    if (push.from_step() <= step)
      acting.push_back({"", push.link(), from_message(push.p_LQ()), from_message(push.force())});
  }
  pushes_ = std::move(left);
  return acting;
}

}  // namespace hrp
