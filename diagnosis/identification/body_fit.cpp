// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/body_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "diagnosis/identification/physical_body.h"

namespace hrp::identification {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using BaseRows = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr int kWeightRounds = 4;               // of weights by what the fit before left of moments and of forces
constexpr double kBlock = 0.5, kMemory = 2.0;  // [s] of scores; residuals are alike over the IMU's drift window
constexpr double kEnough = 20.0;               // [s] of motion: fewer rows of use than parameters otherwise
constexpr double kMoving = 0.02;               // [rad/s] slower than this, noise decides the sign of a velocity
constexpr double kOneWay = 0.99;               // Coulomb friction near a turn is smoothed over both signs
constexpr double kMoved = 5.0;                 // [s] faster than that: friction shows

struct Columns {
  std::vector<int> independent;  // of the base rows, feet left out
  Matrix T;                      // base parameters from all links'
};

// Base parameters of the robot above its ankles [M14 eq. 2]. Feet are leaves: no other link's parameter needs them.
Columns find_columns(const BodyRig& rig) {
  const BaseParameters base = calc_base_parameters(rig.model, RegressorRows::kBase);
  Columns columns;
  std::vector<int> rows;
  for (size_t i = 0; i < base.independent.size(); ++i) {
    if (rig.is_foot(base.independent[i] / kInertialParameters)) continue;
    columns.independent.push_back(base.independent[i]);
    rows.push_back(static_cast<int>(i));
  }
  columns.T = base.T(rows, Eigen::all);
  for (int foot : rig.feet) columns.T.middleCols(kInertialParameters * foot, kInertialParameters).setZero();
  return columns;
}

// Sums of squares of moments and forces apart, so that any weights can be put to them.
struct Sums {
  Matrix A[2];
  Vector b[2];
  double yy[2] = {}, count = 0.0;
};

Sums sum_up_base(const BodyRig& rig, const Columns& columns, const std::vector<BodyMotion>& motions) {
  const auto n = static_cast<Eigen::Index>(columns.independent.size());
  Sums sums{{Matrix::Zero(n, n), Matrix::Zero(n, n)}, {Vector::Zero(n), Vector::Zero(n)}, {}, 0.0};
  BodyEquations equations(rig);
  for (const BodyMotion& m : motions) {
    Matrix rows[2] = {Matrix(3 * m.size(), n), Matrix(3 * m.size(), n)};
    Vector y[2] = {Vector(3 * m.size()), Vector(3 * m.size())};
    for (Eigen::Index k = 0; k < m.size(); ++k) {
      equations.update(m, k);
      const BaseRows X = equations.Y().Y_BI(Eigen::all, columns.independent);
      for (int g = 0; g < 2; ++g) {
        rows[g].middleRows<3>(3 * k) = X.middleRows<3>(3 * g);
        y[g].segment<3>(3 * k) = m.exerted.col(k).segment<3>(3 * g);
      }
    }
    for (int g = 0; g < 2; ++g) {
      sums.A[g].selfadjointView<Eigen::Lower>().rankUpdate(rows[g].transpose());
      sums.b[g].noalias() += rows[g].transpose() * y[g];
      sums.yy[g] += y[g].squaredNorm();
    }
    sums.count += static_cast<double>(3 * m.size());
  }
  for (Matrix& A : sums.A) A = Matrix(A.selfadjointView<Eigen::Lower>());
  return sums;
}

struct Solution {
  Matrix A, inverse;
  Vector b, theta;
  double weight[2] = {1.0, 1.0};
};

// [M14 eq. 2] with weights from the residuals of moments and of forces.
Solution solve_base(const Sums& sums, double (&residual)[2]) {
  Solution s;
  for (int round = 0; round < kWeightRounds; ++round) {
    s.A = s.weight[0] * sums.A[0] + s.weight[1] * sums.A[1];
    s.b = s.weight[0] * sums.b[0] + s.weight[1] * sums.b[1];
    s.inverse = invert_scaled(s.A);
    s.theta = s.inverse * s.b;
    for (int g = 0; g < 2; ++g) {
      const double square = sums.yy[g] - 2.0 * s.theta.dot(sums.b[g]) + s.theta.dot(sums.A[g] * s.theta);
      const double variance = std::max(square / sums.count, 1e-12);
      residual[g] = std::sqrt(variance);
      s.weight[g] = 1.0 / variance;
    }
  }
  return s;
}

// What one joint's equation has left when the inertial parameters are known: effort = Y_JJ phi_J [M14 eq. 3].
struct JointRows {
  Matrix Z;                        // samples x 3
  Vector y;                        // [N m]
  Matrix gain;                     // 3 x inertial parameters: Z^T Y_JI
  std::vector<Eigen::Index> used;  // samples
};

struct SecondPass {
  Matrix S;         // of the base parameters' scores
  Matrix zero_sum;  // X^T W times what errors of the force sensors' zeros do
  double blocks = 0.0;
  std::vector<JointRows> joints;
};

std::vector<JointRows> make_joint_rows(const BodyRig& rig, const std::vector<BodyMotion>& motions) {
  Eigen::Index samples = 0;
  for (const BodyMotion& m : motions) samples += m.size();
  const Eigen::Index parameters = kInertialParameters * static_cast<Eigen::Index>(rig.robot.tree.links.size());
  std::vector<JointRows> joints(static_cast<size_t>(rig.model.num_joints()));
  for (JointRows& j : joints)
    j = {
        Matrix::Zero(samples, kJointParameters), Vector::Zero(samples), Matrix::Zero(kJointParameters, parameters), {}};
  return joints;
}

void add_joint_rows(const BodyMotion& m, Eigen::Index k, Eigen::Index at, const Regressor& Y, const Vector& phi,
                    std::vector<JointRows>* joints) {
  for (size_t j = 0; j < joints->size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    if (!m.measured[j] || m.effort.size() == 0 || std::abs(m.qd(i, k)) < kMoving ||
        std::abs(m.direction(i, k)) < kOneWay)
      continue;
    JointRows& rows = (*joints)[j];
    rows.Z.row(at) = Y.Y_JJ.row(i).segment<kJointParameters>(kJointParameters * i);
    rows.y[at] = m.effort(i, k) + m.exerted(6 + i, k) - Y.Y_JI.row(i).dot(phi);
    rows.gain.noalias() += rows.Z.row(at).transpose() * Y.Y_JI.row(i);
    rows.used.push_back(at);
  }
}

SecondPass look_again(const BodyRig& rig, const Columns& columns, const std::vector<BodyMotion>& motions,
                      const Solution& s, const Vector& phi) {
  const auto zeros = 6 * static_cast<Eigen::Index>(rig.feet.size());
  SecondPass pass{Matrix::Zero(s.theta.size(), s.theta.size()), Matrix::Zero(s.theta.size(), zeros), 0.0,
                  make_joint_rows(rig, motions)};
  BodyEquations equations(rig);
  Eigen::Index at = 0;
  for (const BodyMotion& m : motions) {
    const auto block = static_cast<Eigen::Index>(std::lround(kBlock / m.period));
    Matrix scores = Matrix::Zero(s.theta.size(), (m.size() + block - 1) / block);
    for (Eigen::Index k = 0; k < m.size(); ++k, ++at) {
      equations.update(m, k);
      const BaseRows X = equations.Y().Y_BI(Eigen::all, columns.independent);
      Vector6d e = m.exerted.col(k).head<6>() - X * s.theta;
      for (int g = 0; g < 2; ++g) e.segment<3>(3 * g) *= s.weight[g];
      scores.col(k / block) += X.transpose() * e;
      for (int g = 0; g < 2; ++g)
        pass.zero_sum += s.weight[g] * X.middleRows<3>(3 * g).transpose() * m.zero_gain.middleRows<3>(3 * g);
      add_joint_rows(m, k, at, equations.Y(), phi, &pass.joints);
    }
    pass.S += sum_scores(scores, static_cast<int>(kMemory / kBlock));
    pass.blocks += static_cast<double>(scores.cols());
  }
  return pass;
}

// [M14 eq. 3], none negative. What is not known of the inertial parameters (their covariance) is not known here either.
bool fit_joint(const JointRows& rows, const Matrix& covariance, double period, JointEstimate* out) {
  if (static_cast<double>(rows.used.size()) * period < kMoved) return false;
  const Matrix A = rows.Z.transpose() * rows.Z, inverse = invert_scaled(A);
  std::vector<Eigen::Index> held;
  const Vector theta = solve_signed(A, rows.Z.transpose() * rows.y, std::vector<bool>(kJointParameters, false), &held);
  const auto block = static_cast<Eigen::Index>(std::lround(kBlock / period));
  Matrix scores = Matrix::Zero(kJointParameters, rows.used.back() / block + 1);
  for (Eigen::Index k : rows.used)
    scores.col(k / block) += rows.Z.row(k).transpose() * (rows.y[k] - rows.Z.row(k).dot(theta));
  const Matrix gain = inverse * rows.gain;
  const Matrix all =
      inverse * sum_scores(scores, static_cast<int>(kMemory / kBlock)) * inverse + gain * covariance * gain.transpose();
  for (int i = 0; i < kJointParameters; ++i) out->values[i] = {theta[i], std::sqrt(std::max(0.0, all(i, i)))};
  return true;
}

std::string name_parameter(const BodyRig& rig, const Columns& columns, Eigen::Index i) {
  static const char* const kNames[kInertialParameters] = {"m",   "m x", "m y", "m z", "Ixx",
                                                          "Ixy", "Ixz", "Iyy", "Iyz", "Izz"};
  const int column = columns.independent[static_cast<size_t>(i)];
  const bool more = columns.T.row(i).cwiseAbs().sum() > std::abs(columns.T(i, column)) + 1e-9;
  return rig.robot.tree.links[static_cast<size_t>(column / kInertialParameters)].name + " " +
         kNames[column % kInertialParameters] + (more ? " +" : "");
}

BodyError validate_motion(const BodyRig& rig, const Columns& columns, const BodyMotion& m,
                          const std::array<Vector, 3>& thetas) {
  BodyError error;
  error.motion = m.name;
  BodyEquations equations(rig);
  const Vector6d mean = m.exerted.topRows<6>().rowwise().mean();
  double* const sums[3] = {error.described, error.estimated, error.physical};
  for (Eigen::Index k = 0; k < m.size(); ++k) {
    equations.update(m, k);
    const BaseRows X = equations.Y().Y_BI(Eigen::all, columns.independent);
    const Vector6d y = m.exerted.col(k).head<6>();
    for (int g = 0; g < 2; ++g) {
      error.largest[g] = std::max(error.largest[g], (y - mean).segment<3>(3 * g).cwiseAbs().maxCoeff());
      for (size_t i = 0; i < 3; ++i)
        sums[i][g] += (y - X * thetas[i]).segment<3>(3 * g).cwiseAbs().mean() / static_cast<double>(m.size());
    }
  }
  return error;
}

}  // namespace

BodyFit fit_body(const BodyRig& rig, const std::vector<BodyMotion>& fitted, const std::vector<BodyMotion>& unseen,
                 const BodyOptions& options) {
  double time = 0.0;
  for (const BodyMotion& m : fitted) time += m.period * static_cast<double>(m.size());
  if (time < kEnough) throw std::runtime_error("too little motion that nobody pushes");
  const Columns columns = find_columns(rig);
  BodyFit fit;
  fit.T = columns.T;
  const Solution s = solve_base(sum_up_base(rig, columns, fitted), fit.residual);
  const BodyPrior prior = make_body_prior(options.description, options.trust);
  Matrix information = columns.T.transpose() * s.A * columns.T;
  fit.physical = solve_bodies(information, columns.T.transpose() * s.b, prior);
  fit.smallest_eigenvalue = calc_smallest_eigenvalue(fit.physical);
  const SecondPass pass = look_again(rig, columns, fitted, s, fit.physical);
  // As many blocks as parameters are lost: they fit their own residuals.
  const double lost = pass.blocks / std::max(1.0, pass.blocks - static_cast<double>(s.theta.size()));
  Matrix covariance = lost * s.inverse * pass.S * s.inverse;
  // The same in all motions, so no residual shows it: errors of the force sensors' zeros.
  for (size_t f = 0; f < options.zeros.size(); ++f) {
    const Matrix shift = s.inverse * pass.zero_sum.middleCols<6>(6 * static_cast<Eigen::Index>(f));
    covariance += shift * options.zeros[f] * shift.transpose();
  }
  const Vector described = columns.T * options.description, physical = columns.T * fit.physical;
  for (Eigen::Index i = 0; i < s.theta.size(); ++i) {
    fit.parameters.push_back({name_parameter(rig, columns, i),
                              {s.theta[i], std::sqrt(std::max(0.0, covariance(i, i)))},
                              described[i],
                              physical[i]});
  }
  information.diagonal() += prior.precision;
  const Matrix unknown = invert_scaled(information);
  for (size_t j = 0; j < pass.joints.size(); ++j) {
    JointEstimate joint{rig.robot.tree.joint(static_cast<int>(j)).name, static_cast<int>(j), {}};
    if (fit_joint(pass.joints[j], unknown, fitted[0].period, &joint)) fit.joints.push_back(joint);
  }
  for (const auto* list : {&fitted, &unseen}) {
    for (const BodyMotion& m : *list) {
      fit.errors.push_back(validate_motion(rig, columns, m, {described, s.theta, physical}));
      fit.errors.back().fitted = list == &fitted;
    }
  }
  return fit;
}

}  // namespace hrp::identification
