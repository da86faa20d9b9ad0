// SPDX-License-Identifier: BSD-3-Clause
// All joints of a step: references in, efforts and implicit terms for the articulated-body algorithm out.
#pragma once

#include <vector>

#include "common/multibody/model.h"
#include "common/robot/reference.h"
#include "common/robot/scenario.h"
#include "servers/dynamics/joint_drive.h"

namespace hrp {

class JointSystem {
 public:
  JointSystem(const Model& model, const Scenario& scenario, const std::vector<JointLaws>& laws);
  // Memories afresh; stiffness of mimic couplings and of holding from the mass matrix at this state.
  void reset(const Model& model, const State& state, Data* data);

  // fraction: of the step at which references are read; horizon: time step (implicit) or 0 (explicit).
  void start(const State& state, const Reference& reference, double horizon, double fraction, double dt);
  // Efforts at the velocities of `state` and what implicit terms add to the inertia (zero when explicit).
  void linearise(const State& state, Eigen::VectorXd* effort, Eigen::VectorXd* inertia_extra);
  bool resolve(const State& state, const double* qdd);
  // Efforts that acted. qd (in: velocities at the end of the step; out: exactly zero where friction holds, exactly the
  // reference's where joints are perfect) and the memories at the end of the step.
  void finish(const State& state, const double* qdd, Eigen::VectorXd* qd, Eigen::VectorXd* effort,
              Eigen::VectorXd* servo_effort);
  void accept() { memories_.swap(next_memories_); }
  // Positions that perfect joints have at the end of the step, written over q.
  void put_perfect_positions(Eigen::VectorXd* q) const;

  const std::vector<DriveMemory>& memories() const { return memories_; }
  const std::vector<DriveMemory>& next_memories() const { return next_memories_; }
  const std::vector<JointLaws>& laws() const { return laws_; }

 private:
  enum class Kind : signed char { kDrive, kMimic, kPerfect };
  ReferenceSample find_reference(int joint, const State& state, const Reference& reference, double horizon,
                                 double fraction) const;
  double calc_held_acceleration(int joint, const State& state) const;
  bool is_held(int joint) const {
    return kinds_[static_cast<size_t>(joint)] == Kind::kPerfect || steps_[static_cast<size_t>(joint)].held;
  }

  std::vector<Kind> kinds_;
  std::vector<MimicSpec> mimics_;
  std::vector<JointLaws> laws_;
  std::vector<DriveMemory> memories_, next_memories_;
  std::vector<DriveStep> steps_;
  std::vector<double> hold_inertia_;  // added to a held joint's inertia: it then moves as it is told
  std::vector<double> target_v_;      // of perfect joints at the end of the step
  std::vector<double> target_q_;
};

}  // namespace hrp
