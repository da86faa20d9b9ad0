// SPDX-License-Identifier: BSD-3-Clause
// Samples along the recorded motion, and what friction, rotor and a constant explain of each joint's effort: for
// searches over other zeros, senses and ratios of joints, which move the whole inverse dynamics.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

struct SampledMotion {
  Eigen::MatrixXd q, v, a, effort;     // sample x joint
  Eigen::MatrixXd use;                 // 1 if the joint moves and its effort is known, else 0
  std::vector<Eigen::MatrixXd> basis;  // by joint: orthonormal columns of the nuisance
  Eigen::VectorXd weight;              // by joint: 1 / variance of the effort; 0 if it is not judged

  bool tell_nothing() const;
  // Used samples of all judged joints: the squares of their efforts, over each effort's variance.
  double count_judged() const;
  // Squares of a missing torque (sample x joint) that friction, rotor and a constant leave, over each effort's
  // variance.
  double calc_left(const Eigen::MatrixXd& missing) const;
};

// About 600 samples of these recordings, at equal distances; of each from the share `from` of its time to the share
// `to`.
SampledMotion take_rows(const TorqueData& data, const std::vector<size_t>& recordings, double from = 0.0,
                        double to = 1.0);

// Training recordings without loads or forces by hand.
std::vector<size_t> list_unloaded_training(const TorqueData& data);

}  // namespace hrp::diagnosis
