// SPDX-License-Identifier: BSD-3-Clause
// Checks by simulation under every explanation whether a motion is safe.
#pragma once

#include <memory>
#include <string>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/trial_motion.h"
#include "servers/collision_checker/collision_world.h"

namespace hrp::diagnosis {

class Safety {
 public:
  Safety(const Experiment& experiment, const Limits& limits);

  // Empty if the robot keeps all limits under this explanation, else the fault: "elbow reaches 1.62 rad". `leave`, if
  // given: by joint [rad or m], increased to the largest difference from the command. `faulty`, if given: by joint,
  // marks those that pass their own limits.
  std::string find_fault(const TrialMotion& motion, const Hypothesis& hypothesis, std::vector<double>* leave = nullptr,
                         std::vector<char>* faulty = nullptr);

  // The same for given readings [sample][joint][quantity] of a motion: commands of `motion`, whoever predicts the rest.
  std::string find_fault_of(const TrialMotion& motion, const std::vector<double>& readings,
                            std::vector<double>* leave = nullptr, std::vector<char>* faulty = nullptr);

  // What is not checked, and why.
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  std::string find_joint_fault(const std::vector<double>& readings, size_t first, size_t rows,
                               std::vector<char>* faulty) const;
  std::string find_contact(const std::vector<double>& readings, size_t first, size_t rows, double period);

  const Experiment& experiment_;
  Limits limits_;
  Scenario scenario_;
  std::unique_ptr<CollisionWorld> world_;  // null: no shapes
  std::unique_ptr<Model> model_;
  std::vector<std::string> remarks_;
};

}  // namespace hrp::diagnosis
