// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/base_parameters.h"

#include <random>

#include "common/multibody/kinematics.h"

namespace hrp {
namespace {

// Numbers in [-1, 1) with the same bits on every machine (distributions of the library are not portable).
class Noise {
 public:
  double next() { return static_cast<double>(engine_()) / 2147483648.0 - 1.0; }
  Eigen::VectorXd values(Eigen::Index n, double size) {
    Eigen::VectorXd v(n);
    for (Eigen::Index i = 0; i < n; ++i) v[i] = size * next();
    return v;
  }

 private:
  std::mt19937 engine_{20140824u};
};

State make_random_state(const Model& model, Noise* noise) {
  State state = make_state(model);
  state.q = noise->values(model.num_joints(), 2.0);
  state.qd = noise->values(model.num_joints(), 3.0);
  if (!model.floating()) return state;
  const Eigen::VectorXd turn = noise->values(4, 1.0);
  state.R_WB = Eigen::Quaterniond(turn[0], turn[1], turn[2], turn[3]).normalized();
  state.V_WB = noise->values(6, 3.0);
  return state;
}

Eigen::MatrixXd select_rows(const Regressor& Y, RegressorRows rows) {
  if (rows == RegressorRows::kBase) return Y.Y_BI;
  if (rows == RegressorRows::kJoints) return Y.Y_JI;
  Eigen::MatrixXd all(Y.Y_BI.rows() + Y.Y_JI.rows(), Y.Y_BI.cols());
  all << Y.Y_BI, Y.Y_JI;
  return all;
}

// Upper triangle of the QR of many motions' rows, motion by motion, so that memory stays small.
Eigen::MatrixXd calc_triangle(const Model& model, RegressorRows rows, int num_motions) {
  const Eigen::Index columns = kInertialParameters * model.num_links();
  Data data(model);
  Regressor regressor(model);
  Noise noise;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(columns, columns);
  for (int done = 0; done < num_motions;) {
    std::vector<Eigen::MatrixXd> blocks;
    for (Eigen::Index height = 0; height < columns && done < num_motions; ++done) {
      update_kinematics(model, make_random_state(model, &noise), &data);
      calc_regressor(model, noise.values(model.nv(), 20.0), &data, &regressor);
      blocks.push_back(select_rows(regressor, rows));
      height += blocks.back().rows();
    }
    const Eigen::Index height = blocks[0].rows();
    Eigen::MatrixXd stack(columns + height * static_cast<Eigen::Index>(blocks.size()), columns);
    stack.topRows(columns) = R;
    for (size_t i = 0; i < blocks.size(); ++i)
      stack.middleRows(columns + height * static_cast<Eigen::Index>(i), height) = blocks[i];
    R = Eigen::HouseholderQR<Eigen::MatrixXd>(stack).matrixQR().topRows(columns).triangularView<Eigen::Upper>();
  }
  return R;
}

}  // namespace

BaseParameters calc_base_parameters(const Model& model, RegressorRows rows, int num_motions) {
  const Eigen::Index columns = kInertialParameters * model.num_links();
  const Eigen::Index height = rows == RegressorRows::kBase ? 6 : std::max(1, model.num_joints());
  if (num_motions <= 0) num_motions = static_cast<int>(4 * columns / height + 10);  // four equations an unknown
  const Eigen::MatrixXd R = calc_triangle(model, rows, num_motions);
  BaseParameters base;
  for (Eigen::Index c = 0; c < columns; ++c) {
    // 1e-9 of the column: a dependent one leaves rounding (1e-13), an independent one far more than 1e-6.
    const bool independent = std::abs(R(c, c)) > 1e-9 * R.col(c).norm() && R.col(c).norm() > 1e-9;
    (independent ? base.independent : base.dependent).push_back(static_cast<int>(c));
  }
  // Least squares of the dependent columns on the kept ones.
  const Eigen::MatrixXd kept = get_independent_columns(base, R);
  const Eigen::HouseholderQR<Eigen::MatrixXd> solver(kept);
  base.T = Eigen::MatrixXd::Zero(kept.cols(), columns);
  for (size_t i = 0; i < base.independent.size(); ++i) base.T(static_cast<Eigen::Index>(i), base.independent[i]) = 1;
  for (int c : base.dependent) base.T.col(c) = solver.solve(R.col(c));
  return base;
}

Eigen::MatrixXd get_independent_columns(const BaseParameters& base, const Eigen::MatrixXd& Y) {
  Eigen::MatrixXd kept(Y.rows(), static_cast<Eigen::Index>(base.independent.size()));
  for (size_t i = 0; i < base.independent.size(); ++i)
    kept.col(static_cast<Eigen::Index>(i)) = Y.col(base.independent[i]);
  return kept;
}

}  // namespace hrp
