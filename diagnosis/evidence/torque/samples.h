// SPDX-License-Identifier: BSD-3-Clause
// Training samples of one joint with the columns of a chosen model. For analyses that need samples instead of sums.
#pragma once

#include <vector>

#include "diagnosis/evidence/joint_rows.h"
#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// Regressors and missing torque of one joint, by sample.
struct TorqueSamples {
  Eigen::MatrixXd x;                    // sample x column: the joint's own terms, then the whole robot's
  Eigen::VectorXd y;                    // missing torque [N m]
  Eigen::MatrixXd of;                   // sample x quantity, in the order of kQuantitiesOfParts
  Eigen::VectorXd effort, effort_rate;  // [N m], [N m/s]
};

// Quantities that divide samples into parts: recording, share of its time, |speed| [rad/s], position [rad], |load| [N
// m].
constexpr long kQuantitiesOfParts = 5;

// Training samples in use of a joint (index in the design). Empty matrices if there are none.
TorqueSamples list_torque_samples(const TorqueDesign& design, const TorqueModel& model, size_t joint);

// Column of one of the joint's terms at the same samples.
Eigen::VectorXd list_column(const TorqueDesign& design, size_t joint, const Term& term);

// Columns of the model in a joint's rows at the kept samples of one recording: its own terms, then those of the whole
// robot.
Eigen::MatrixXd list_law_columns(const TorqueDesign& design, const TorqueModel& model, size_t joint,
                                 const TorqueRecording& recording);

// The same of all recordings.
FoundLaws list_laws(const TorqueDesign& design, const TorqueModel& model, size_t joint);

// Inverse of X^T X, with a small ridge for collinear columns.
Eigen::MatrixXd invert_gram(const Eigen::MatrixXd& x);
// The same of G = X^T X.
Eigen::MatrixXd invert_sums(Eigen::MatrixXd G);

}  // namespace hrp::diagnosis
