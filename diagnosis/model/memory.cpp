// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/memory.h"

namespace hrp::diagnosis {

Eigen::VectorXd calc_memory_state(const EffectInfo& effect, const Eigen::VectorXd& q, double shape) {
  Eigen::VectorXd z = Eigen::VectorXd::Zero(q.size());
  for (long k = 1; k < z.size(); ++k) z[k] = effect.torque.advance(z[k - 1], q[k] - q[k - 1], &shape);
  return z;
}

}  // namespace hrp::diagnosis
