// SPDX-License-Identifier: BSD-3-Clause
// Servo references within a control period, and late ones. The command of a control step acts from that step on: held,
// or approached from the reference before it over one period (linear, or cubic Hermite of position and velocity). With
// a control period of one step the reference at the end of a step is its command, whatever the interpolation.
#pragma once

#include <string>
#include <vector>

#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

struct ReferenceSample {
  double q = 0.0, qd = 0.0, effort = 0.0;
};

enum class Interpolation { kHold, kLinear, kHermite };
Interpolation parse_interpolation(const std::string& name);

// Between samples a and b a time T apart, s in [0, 1].
ReferenceSample interpolate(Interpolation kind, const ReferenceSample& a, const ReferenceSample& b, double T, double s);

class Reference {
 public:
  // delays: by joint [s].
  Reference(Interpolation kind, int control_period, double dt, const std::vector<double>& delays);
  // References rest at q.
  void reset(const Eigen::VectorXd& q);
  // Text and joint of what is wrong with a command; nullptr when it can be used.
  static const char* find_fault(const JointCommand& command, int joints, int* joint);
  // Takes the command at the beginning of a control period, ignores it in between.
  void start_step(long step, const JointCommand& command);
  // Reference of a joint at the start of the current step + fraction x dt, its delay included.
  ReferenceSample get(int joint, double fraction) const;
  // The current step is done.
  void finish_step();
  template <typename Visit>
  void visit_memory(const Visit& visit) const;

 private:
  struct Delayed {
    int slots = 0;  // of the ring, 0: not delayed
    double steps = 0.0;
    size_t first = 0;
  };
  ReferenceSample get_now(int joint, double fraction) const;

  Interpolation kind_;
  int period_;
  double dt_;
  long step_ = 0;
  std::vector<ReferenceSample> from_, to_;
  std::vector<Delayed> delayed_;
  std::vector<ReferenceSample> ring_;
};

template <typename Visit>
void Reference::visit_memory(const Visit& visit) const {
  for (const auto* list : {&from_, &to_, &ring_}) {
    for (const ReferenceSample& sample : *list) {
      visit(sample.q);
      visit(sample.qd);
      visit(sample.effort);
    }
  }
}

}  // namespace hrp
