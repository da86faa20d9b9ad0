// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/leg_friction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "diagnosis/data/mean.h"
#include "diagnosis/estimate/shares.h"

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

// Places in a row of what a joint's drive changes.
struct DrivePlaces {
  long constant, gain, viscous, dry, load, rotor;
  std::array<long, 4> list_losses() const { return {viscous, dry, load, rotor}; }
};

std::vector<DrivePlaces> list_drives(const ColumnLayout& layout, const ChannelRows& rows) {
  std::vector<DrivePlaces> out;
  for (int j = 0; j < layout.joints; ++j) {
    const auto find = [&](int c) { return static_cast<long>(rows.find_column(layout.joint(j, c))); };
    if (find(kDryColumn) < 0) continue;
    out.push_back({find(kConstantColumn), find(kGainColumn), find(kViscousColumn), find(kDryColumn), find(kLoadColumn),
                   find(kRotorColumn)});
  }
  return out;
}

// Coefficients of the regression of all columns, and of y in the last one, on the losses. Of fitted rows, each equation
// in the unit of its own spread.
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

// Rows of one block are of one motion: it is one look at each equation. Fewer looks than losses do not tell how large
// these are.
bool do_tell(const std::vector<ChannelRows*>& balances, const std::vector<long>& losses) {
  size_t looks = 0;
  for (const ChannelRows* c : balances) {
    std::set<int> blocks;
    for (size_t i = 0; i < c->rows(); ++i) {
      if (c->train[i]) blocks.insert(c->block[i]);
    }
    looks += blocks.size();
  }
  return looks > losses.size();
}

void subtract(const Eigen::MatrixXd& by, const std::vector<long>& losses, size_t width, std::vector<double>* x,
              std::vector<double>* y) {
  RowMap rows = map_rows(x, width);
  const Eigen::MatrixXd lost = rows(Eigen::all, losses);
  rows -= lost * by.leftCols(static_cast<long>(width));
  Eigen::Map<Eigen::VectorXd>(y->data(), static_cast<long>(y->size())) -= lost * by.rightCols<1>();
  for (const long at : losses) rows.col(at).setZero();
}

// [the equation's unit^2] Variance of what a joint's drive hides in a row. Its effort is good to some percent. Its
// friction shows while it moves. While it stands, a gear holds any torque up to its friction, of either sign.
double find_hidden(const DrivePlaces& at, const double* x, const Eigen::VectorXd& losses) {
  if (x[at.constant] == 0) return 0;
  const double moves = x[at.dry] / x[at.constant];
  const double friction = losses(at.dry) * std::abs(x[at.constant]) + losses(at.load) * std::abs(x[at.gain]);
  return std::pow(kMinor * x[at.gain], 2) + std::max(0.0, 1 - moves * moves) * friction * friction / 3;
}

// `losses`: coefficients that the fit gives to the losses, by place in a row.
double find_exactness(const std::vector<DrivePlaces>& drives, const ChannelRows& c, const Eigen::VectorXd& losses) {
  double sum = 0;
  for (size_t i = 0; i < c.rows(); ++i) {
    for (const DrivePlaces& at : drives) sum += find_hidden(at, c.row(i), losses);
  }
  return std::sqrt(sum / static_cast<double>(c.rows()));
}

}  // namespace

void leave_out_leg_friction(const ColumnLayout& layout, std::vector<ChannelRows>* channels) {
  const std::vector<ChannelRows*> balances = list_balances(channels);
  if (balances.empty()) return;
  const std::vector<DrivePlaces> drives = list_drives(layout, *balances[0]);
  std::vector<long> losses;
  for (const DrivePlaces& at : drives) {
    for (const long place : at.list_losses()) losses.push_back(place);
  }
  if (losses.empty()) return;
  const Eigen::MatrixXd by = regress(balances, losses);
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(static_cast<long>(balances[0]->columns.size()));
  if (do_tell(balances, losses)) sizes(losses) = by.rightCols<1>();
  for (ChannelRows* c : balances) {
    c->info.error = find_exactness(drives, *c, sizes);
    subtract(by, losses, c->columns.size(), &c->x, &c->y);
    if (!c->noise_y.empty()) subtract(by, losses, c->columns.size(), &c->noise_x, &c->noise_y);
  }
}

}  // namespace hrp::diagnosis::floating
