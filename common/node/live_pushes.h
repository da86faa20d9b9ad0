// SPDX-License-Identifier: BSD-3-Clause
// Pushes of people (RunControl, REQUEST_PUSH) on their way through step grants: the scheduler says from which state on
// each acts, so that a run with its pushes can be repeated to the bit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/multibody/tree_spec.h"
#include "common/robot/movers.h"
#include "common/robot/signals.h"
#include "hrp_idl/scheduling.h"

namespace hrp {

// Why nobody can push like this; empty when one can. The robot's links are not looked at.
std::string find_push_fault(const msg::Push& push);
// The same with what can be pushed: links of the robot, lumped ones too, and the bodies of movers (Mover::name_body()).
std::string find_push_fault(const msg::Push& push, const TreeSpec& tree, const std::vector<Mover>& movers);

// Of the scheduler: gives pushes their number and the state from which on they act.
class PushQueue {
 public:
  // Of an epoch, dynamics takes only numbers that are larger than the last one. A scheduler that was restarted has to
  // begin with a larger one than the scheduler before it.
  explicit PushQueue(uint64_t first_number = 1) : next_number_(first_number) {}
  void reset() { pushes_.clear(); }
  // Instead of a push of the same link that was not given out yet.
  void add(const msg::Push& push);
  // Those that belong into a grant, when steps through `granted` are allowed already and dynamics has done `step`.
  std::vector<msg::Push> give_out(uint64_t granted, uint64_t step);

 private:
  std::vector<msg::Push> pushes_;  // number 0: not given out
  uint64_t next_number_;
};

// Of a dynamics server: which pushes act when.
class LivePushes {
 public:
  void reset() {
    pushes_.clear();
    last_number_ = 0;
  }
  void add(const msg::Push& push);               // ignored when it was added before
  void add_from(uint64_t step, msg::Push push);  // the next one, without a scheduler: acts from this state on
  bool empty() const { return pushes_.empty(); }
  // What acts in the step that begins at state `step`. Steps come in order: what is over is forgotten.
  PushForces find(uint64_t step);

 private:
  std::vector<msg::Push> pushes_;  // in the order of their numbers, so of from_step, too
  uint64_t last_number_ = 0;
};

}  // namespace hrp
