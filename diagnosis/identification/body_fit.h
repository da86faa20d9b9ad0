// SPDX-License-Identifier: BSD-3-Clause
// Inertial parameters of everything above the ankles without joint torques, from base wrench, encoders and IMU [M14 eq.
// 2]; rotor inertia, viscous and Coulomb friction of each joint from its effort [M14 eq. 3]; all motions one below the
// other [M14 eq. 7]. Weighted least squares with the paper's statistics; and the bodies (positive mass, pseudo-inertia)
// that fit best, which stay with the description where motions tell nothing.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/base_parameters.h"
#include "diagnosis/identification/body_motion.h"
#include "diagnosis/identification/least_squares.h"

namespace hrp::identification {

constexpr double kShown = 0.1;  // relative standard deviation below which motions are said to show a parameter

// One base parameter: a link's own or, with a +, what it stands for together with links after it.
struct BodyParameter {
  std::string name;
  Estimate estimate;
  double described = 0.0, physical = 0.0;  // of the description; of the bodies that fit best
  bool is_shown() const { return estimate.relative_std() < kShown; }
};

struct JointEstimate {
  std::string name;
  int joint = 0;
  // Rotor inertia [kg m^2], viscous [N m s/rad], Coulomb friction [N m]; none negative
  Estimate values[kJointParameters];
};

// Mean absolute errors of the base's moments and forces along one motion, over the largest change of what was measured.
struct BodyError {
  std::string motion;
  bool fitted = false;
  double largest[2] = {};  // [N m], [N]
  double described[2] = {}, estimated[2] = {}, physical[2] = {};
};

struct BodyFit {
  std::vector<BodyParameter> parameters;
  std::vector<JointEstimate> joints;  // those that moved
  std::vector<BodyError> errors;
  Eigen::MatrixXd T;                 // parameters from those of all links (feet: zero)
  Eigen::VectorXd physical;          // inertial parameters of all links
  double smallest_eigenvalue = 0.0;  // of any link's pseudo-inertia over its largest: positive
  double residual[2] = {};           // [N m], [N] root mean square
};

struct BodyOptions {
  Eigen::VectorXd description;  // inertial parameters of all links as they are believed to be
  double trust = 0.2;           // that is right to about this share of each link's own scale
  std::vector<Matrix6d> zeros;  // covariance of the force sensors' zeros, by foot [N; N m]
};

// Motions of a robot that nobody touches; `unseen` are only predicted. Throws std::runtime_error when there is too
// little.
BodyFit fit_body(const BodyRig& rig, const std::vector<BodyMotion>& fitted, const std::vector<BodyMotion>& unseen,
                 const BodyOptions& options);

}  // namespace hrp::identification
