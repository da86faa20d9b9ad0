// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/load_or_unit.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/torque/terms.h"

namespace hrp::diagnosis {
namespace {

// Sums of squares of weighted rows: y = X p, p = mass [kg] and moment [kg m] of a load.
struct Squares {
  Eigen::MatrixXd xx = Eigen::MatrixXd::Zero(kLoadColumns, kLoadColumns);
  Eigen::VectorXd xy = Eigen::VectorXd::Zero(kLoadColumns);
  double yy = 0.0;

  void add(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, double weight) {
    xx += weight * x.transpose() * x;
    xy += weight * x.transpose() * y;
    yy += weight * y.squaredNorm();
  }

  // What the best load of at most `most` [kg] leaves.
  double calc_left(double most) const {
    const double mass = xx.completeOrthogonalDecomposition().solve(xy)[0];
    if (mass >= 0.0 && mass <= most) return yy - xy.dot(xx.completeOrthogonalDecomposition().solve(xy));
    const double limit = mass < 0.0 ? 0.0 : most;
    const Eigen::Vector3d rest = xy.tail<3>() - limit * xx.col(0).tail<3>();
    const Eigen::Vector3d moment = xx.bottomRightCorner<3, 3>().completeOrthogonalDecomposition().solve(rest);
    return yy - 2.0 * limit * xy[0] + limit * limit * xx(0, 0) - rest.dot(moment);
  }
};

}  // namespace

UnitRows collect_efforts(const TorqueData& data, int joint) {
  UnitRows rows;
  long count = 0;
  for (const TorqueRecording& r : data.recordings) {
    if (r.train) count += r.use.col(joint).count();
  }
  rows.tau.resize(count);
  rows.effort.resize(count);
  rows.nuisance.resize(count, kNuisance);
  long at = 0;
  for (const TorqueRecording& r : data.recordings) {
    if (!r.train) continue;
    const Eigen::VectorXd sign = data.calc_sign(r, joint);
    for (long k = 0; k < r.kept(); ++k) {
      if (!r.use(k, joint)) continue;
      const long i = r.full_row(k);
      rows.tau[at] = r.tau(i, joint);
      rows.effort[at] = r.effort(i, joint);
      rows.nuisance.row(at++) << r.v(i, joint), sign[i], r.a(i, joint), 1.0;
    }
  }
  return rows;
}

std::vector<Eigen::MatrixXd> collect_loads(const TorqueData& data, const std::vector<int>& joints,
                                           const std::vector<Term>& loads) {
  std::vector<Eigen::MatrixXd> out(joints.size());
  for (const TorqueRecording& r : data.recordings) {
    if (!r.train) continue;
    const std::vector<Eigen::MatrixXd> columns = calc_whole_columns(data, r, loads);
    for (size_t i = 0; i < joints.size(); ++i) {
      const Eigen::MatrixXd& from = columns[static_cast<size_t>(joints[i])];
      long at = out[i].rows();
      out[i].conservativeResize(at + r.use.col(joints[i]).count(), from.cols());
      for (long k = 0; k < r.kept(); ++k) {
        if (r.use(k, joints[i])) out[i].row(at++) = from.row(k);
      }
    }
  }
  return out;
}

double find_moving_mass(const TreeSpec& tree) {
  double mass = 0.0;
  for (size_t link = 1; link < tree.links.size(); ++link) mass += tree.links[link].inertia.mass;
  return mass;
}

Eigen::MatrixXd take_out(const Eigen::MatrixXd& X, const Eigen::MatrixXd& y) {
  return y - X * X.colPivHouseholderQr().solve(y);
}

bool may_be_load(const TorqueData& data, const std::vector<int>& joints) {
  std::vector<Term> loads;
  for (size_t link = 1; link < data.experiment->robot.tree.links.size(); ++link)
    loads.push_back({&find_term_row(&TermRow::load), static_cast<int>(link)});
  const std::vector<Eigen::MatrixXd> of_loads = collect_loads(data, joints, loads);
  std::vector<Squares> of_link(loads.size());
  double of_unit = 0.0;  // [samples] each joint's squares over what its own scale leaves
  for (size_t i = 0; i < joints.size(); ++i) {
    const UnitRows rows = collect_efforts(data, joints[i]);
    const Eigen::VectorXd tau = take_out(rows.nuisance, rows.tau), effort = take_out(rows.nuisance, rows.effort);
    const double left = effort.squaredNorm() - std::pow(tau.dot(effort), 2) / std::max(1e-300, tau.squaredNorm());
    const double weight = static_cast<double>(tau.size()) / std::max(1e-300, left);
    of_unit += static_cast<double>(tau.size());
    const Eigen::MatrixXd columns = take_out(rows.nuisance, of_loads[i]);
    for (size_t link = 0; link < loads.size(); ++link)
      of_link[link].add(columns.middleCols(kLoadColumns * static_cast<long>(link), kLoadColumns), effort - tau, weight);
  }
  const double most = find_moving_mass(data.experiment->robot.tree);
  // Evidence of the scales against the load [nats].
  const auto prefers_unit = [&](const Squares& s) {
    return 0.5 * of_unit / kPerPeriod * std::log(std::max(1e-300, s.calc_left(most)) / of_unit) > kOdds;
  };
  return !std::all_of(of_link.begin(), of_link.end(), prefers_unit);
}

}  // namespace hrp::diagnosis
