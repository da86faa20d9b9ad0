// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/close_loops.h"

#include <algorithm>

#include "common/multibody/kinematics.h"

namespace hrp {
namespace {

constexpr int kMostSteps = 100;
constexpr double kLongestStep = 0.3;  // [rad or m] of one joint: further a linkage is no longer nearly linear
constexpr double kClosed = 1e-12;     // [m, rad]

void update_pose(const Model& model, const State& state, Data* data, Loops* loops) {
  update_kinematics(model, state, data);
  loops->update(model, state, data);
}

}  // namespace

std::vector<LoopGap> calc_gaps(const Model& model, const std::vector<LoopConstraint>& loops, const State& state) {
  Data data(model);
  std::vector<LoopGap> gaps;
  for (const LoopConstraint& loop : loops) {
    Loops one(model, {loop});
    update_pose(model, state, &data, &one);
    const Eigen::VectorXd& error = one.position_error();
    gaps.push_back({error.head<3>().norm(), error.tail(error.size() - 3).norm()});
  }
  return gaps;
}

void close_loops(const Model& model, const std::vector<LoopConstraint>& constraints, const std::vector<int>& joints,
                 State* state) {
  if (joints.empty() || constraints.empty()) return;
  Data data(model);
  Loops loops(model, constraints);
  Eigen::MatrixXd J(loops.rows(), static_cast<Eigen::Index>(joints.size()));
  for (int k = 0; k < kMostSteps; ++k) {
    update_pose(model, *state, &data, &loops);
    if (loops.position_error().cwiseAbs().maxCoeff() < kClosed) return;
    for (size_t i = 0; i < joints.size(); ++i) {
      J.col(static_cast<Eigen::Index>(i)) = loops.jacobian().col(model.num_base() + joints[i]);
    }
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(J.rows(), J.cols());
    solver.setThreshold(1e-9);  // equations of a planar linkage are redundant up to rounding
    solver.compute(J);
    const Eigen::VectorXd step = -solver.solve(loops.position_error());
    const double longest = step.cwiseAbs().maxCoeff();
    const double share = longest > kLongestStep ? kLongestStep / longest : 1.0;
    for (size_t i = 0; i < joints.size(); ++i) state->q[joints[i]] += share * step[static_cast<Eigen::Index>(i)];
    if (longest < kClosed) return;
  }
}

}  // namespace hrp
