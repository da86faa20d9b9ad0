// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/body_rows.h"

namespace hrp::diagnosis::floating {

BodyRows::BodyRows(const BodyEquations& equations, const BodySample& sample)
    : equations_(equations),
      at_(sample),
      normal_(find_normal(at_)),
      nominal_(calc_residuals(at_, equations.channels, normal_)) {
  const BodyChannels& channels = equations.channels;
  open_.assign(channels.row.size(), 0);
  for (int row = 0; row < kJointRow; ++row) {
    if (channels.row[static_cast<size_t>(row)] < 0) continue;
    if (!channels.weighs || is_weight_known(at_, equations.contacts, channels)) open(row);
  }
  for (int j = 0; j < equations.layout.joints; ++j) {
    if (channels.joint(j) >= 0 && is_joint_known(at_, equations.contacts, j)) open(kJointRow + j);
  }
}

void BodyRows::open(int row) {
  open_[static_cast<size_t>(row)] = 1;
  equations_.table.begin_row(equations_.channels.row[static_cast<size_t>(row)], nominal_.y(row),
                             nominal_.measured(row));
}

void BodyRows::put_all(const Eigen::VectorXd& by_row, int column) {
  for (int row = 0; row < by_row.size(); ++row) put(row, by_row(row), column);
}

void BodyRows::put_wrench(const PointWrench& wrench, double sign, int column) {
  project(at_, equations_.channels, normal_, wrench, sign, [&](int row, double value) { put(row, value, column); });
}

Eigen::VectorXd BodyRows::calc_slope(double step) const {
  return (calc_residuals(at_, equations_.channels, normal_).y - nominal_.y) / step;
}

}  // namespace hrp::diagnosis::floating
