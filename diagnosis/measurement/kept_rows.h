// SPDX-License-Identifier: BSD-3-Clause
// Rows of the full grid at the kept samples of a recording.
#pragma once

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

inline Eigen::MatrixXd keep_rows(const TorqueRecording& recording, const Eigen::MatrixXd& full) {
  Eigen::MatrixXd out(recording.kept(), full.cols());
  for (long k = 0; k < recording.kept(); ++k) out.row(k) = full.row(recording.full_row(k));
  return out;
}

}  // namespace hrp::diagnosis
