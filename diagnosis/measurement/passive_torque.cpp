// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/passive_torque.h"

#include <algorithm>

#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {

std::vector<double> calc_passive_squares(const TorqueData& data) {
  const Plant plant = make_plant(*data.experiment, {});
  std::vector<double> squares(data.source.size(), 0.0);
  double n = 0.0;
  for (const TorqueRecording& r : data.recordings) {
    const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(r.q.rows(), r.q.cols());
    const Eigen::MatrixXd gravity = calc_efforts(plant, r.q, none, none),
                          motion = calc_efforts(plant, r.q, r.v, r.a) - gravity;
    for (size_t j = 0; j < squares.size(); ++j) {
      const auto column = static_cast<long>(j);
      squares[j] += gravity.col(column).squaredNorm() + motion.col(column).squaredNorm();
    }
    n += static_cast<double>(r.q.rows());
  }
  for (double& square : squares) square /= std::max(1.0, n);
  return squares;
}

}  // namespace hrp::diagnosis
