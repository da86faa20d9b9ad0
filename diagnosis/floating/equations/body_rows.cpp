// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/body_rows.h"

#include "diagnosis/floating/equations/leg_forces.h"

namespace hrp::diagnosis::floating {

BodyRows::BodyRows(const BodyEquations& equations, const BodySample& sample)
    : equations_(equations),
      at_(sample),
      normal_(find_normal(at_)),
      nominal_(calc_residuals(at_, equations.channels, normal_)) {
  const BodyChannels& channels = equations.channels;
  open_.assign(channels.row.size(), 0);
  if (!channels.legs.empty()) open_by_legs();
  for (int row = 0; row < kJointRow && channels.legs.empty(); ++row) {
    if (channels.row[static_cast<size_t>(row)] < 0) continue;
    if (!channels.weighs || is_weight_known(at_, equations.contacts, channels))
      open(row, nominal_.y(row), nominal_.measured(row));
  }
  for (int j = 0; j < equations.layout.joints; ++j) {
    const int row = kJointRow + j;
    if (channels.joint(j) >= 0 && is_joint_known(at_, equations.contacts, j))
      open(row, nominal_.y(row), nominal_.measured(row));
  }
}

void BodyRows::open(int row, double y, double measured) {
  open_[static_cast<size_t>(row)] = 1;
  equations_.table.begin_row(equations_.channels.row[static_cast<size_t>(row)], y, measured);
}

// What is measured is what the legs' torques say of the ground.
void BodyRows::open_by_legs() {
  shares_ = find_leg_shares(at_, equations_.contacts);
  if (shares_.size() == 0) return;
  const Eigen::VectorXd ground = -shares_ * nominal_.y.tail(shares_.cols());
  for (int row = 0; row < kJointRow; ++row) open(row, nominal_.y(row) + ground(row), ground(row));
  for (int j = 0; j < shares_.cols(); ++j) {
    if (shares_.col(j).any()) nominal_.load(j) = nominal_.measured(kJointRow + j);  // the ground's part is in it
  }
}

void BodyRows::put_all(const Eigen::VectorXd& by_row, int column) {
  for (int row = 0; row < by_row.size(); ++row) put(row, by_row(row), column);
}

void BodyRows::put_wrench(const PointWrench& wrench, double sign, int column) {
  project(at_, equations_.channels, normal_, wrench, sign, [&](int row, double value) { put(row, value, column); });
}

Eigen::VectorXd BodyRows::calc_slope(double step) const {
  const Eigen::VectorXd y = calc_residuals(at_, equations_.channels, normal_).y;
  Eigen::VectorXd slope = (y - nominal_.y) / step;
  if (shares_.size() == 0) return slope;
  // The levers of the legs move, too.
  const Eigen::MatrixXd shares = find_leg_shares(at_, equations_.contacts);
  if (shares.size() > 0) slope.head<kJointRow>() -= (shares - shares_) * y.tail(shares_.cols()) / step;
  return slope;
}

}  // namespace hrp::diagnosis::floating
