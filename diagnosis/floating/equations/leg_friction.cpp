// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/leg_friction.h"

#include "diagnosis/data/mean.h"

namespace hrp::diagnosis::floating {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMap = Eigen::Map<RowMatrix>;

RowMap map_rows(std::vector<double>* x, size_t width) {
  return {x->data(), static_cast<long>(width > 0 ? x->size() / width : 0), static_cast<long>(width)};
}

std::vector<ChannelRows*> list_balances(std::vector<ChannelRows>* channels) {
  std::vector<ChannelRows*> out;
  for (ChannelRows& c : *channels) {
    if (c.info.equation.is_balance_by_legs() && c.rows() > 0) out.push_back(&c);
  }
  return out;
}

// Places in a row of what drives take of their torques.
std::vector<long> list_losses(const ColumnLayout& layout, const ChannelRows& rows) {
  std::vector<long> out;
  for (int j = 0; j < layout.joints; ++j) {
    for (const int c : {kViscousColumn, kDryColumn, kLoadColumn, kRotorColumn}) {
      const int at = rows.find_column(layout.joint(j, c));
      if (at >= 0) out.push_back(at);
    }
  }
  return out;
}

// Coefficients of the regression of all columns, and of y in the last one, on the losses. Of fitted rows, each equation in
// the unit of its own spread.
Eigen::MatrixXd regress(const std::vector<ChannelRows*>& balances, const std::vector<long>& losses) {
  const size_t width = balances[0]->columns.size();
  size_t count = 0;
  for (const ChannelRows* c : balances) count += c->rows();
  RowMatrix all = RowMatrix::Zero(static_cast<long>(count), static_cast<long>(width) + 1);
  long at = 0;
  for (ChannelRows* c : balances) {
    const double spread = calc_rms(c->y);
    for (size_t i = 0; i < c->rows(); ++i, ++at) {
      if (!c->train[i] || !(spread > 0)) continue;
      all.row(at).head(static_cast<long>(width)) = map_rows(&c->x, width).row(static_cast<long>(i)) / spread;
      all(at, static_cast<long>(width)) = c->y[i] / spread;
    }
  }
  const Eigen::MatrixXd lost = all(Eigen::all, losses);
  return lost.completeOrthogonalDecomposition().solve(Eigen::MatrixXd(all));
}

void subtract(const Eigen::MatrixXd& by, const std::vector<long>& losses, size_t width, std::vector<double>* x, std::vector<double>* y) {
  RowMap rows = map_rows(x, width);
  const Eigen::MatrixXd lost = rows(Eigen::all, losses);
  rows -= lost * by.leftCols(static_cast<long>(width));
  Eigen::Map<Eigen::VectorXd>(y->data(), static_cast<long>(y->size())) -= lost * by.rightCols<1>();
  for (const long at : losses) rows.col(at).setZero();
}

}  // namespace

void leave_out_leg_friction(const ColumnLayout& layout, std::vector<ChannelRows>* channels) {
  const std::vector<ChannelRows*> balances = list_balances(channels);
  if (balances.empty()) return;
  const std::vector<long> losses = list_losses(layout, *balances[0]);
  if (losses.empty()) return;
  const Eigen::MatrixXd by = regress(balances, losses);
  for (ChannelRows* c : balances) {
    subtract(by, losses, c->columns.size(), &c->x, &c->y);
    if (!c->noise_y.empty()) subtract(by, losses, c->columns.size(), &c->noise_x, &c->noise_y);
  }
}

}  // namespace hrp::diagnosis::floating
