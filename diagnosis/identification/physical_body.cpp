// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/physical_body.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/noise.h"

namespace hrp::identification {
namespace {

using Vector = Eigen::VectorXd;
using Eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>;

constexpr int kSplits = 400;      // rounds: the copies agree to 1e-4 of a link's scale after a third of them
constexpr double kInside = 1e-3;  // smallest eigenvalue of a pseudo-inertia, over that of the description
constexpr double kPenalty = 3.0;  // of the splitting, over the prior's precision

Eigen::Matrix4d put_inside(const Eigen::Matrix4d& P, double least) {
  const Eigenvalues solver(P);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(least).asDiagonal() * solver.eigenvectors().transpose();
}

// A link's pseudo-inertia from parameters z in units of their own: P = S (sum of z_i unit_i P_i) S with S so that P of
// a body is near one; `back` = S^-1. Distances between such P are what the splitting weighs, so its projection is
// exact.
struct PseudoMap {
  Eigen::Matrix<double, 16, kInertialParameters> L;
  Eigen::Matrix4d back;
};

PseudoMap make_pseudo_map(const LinkParameters& unit) {
  const double length = unit[1] / unit[0], mass = unit[0];
  const Eigen::Vector4d scale = Eigen::Vector4d(1.0 / length, 1.0 / length, 1.0 / length, 1.0) / std::sqrt(mass);
  PseudoMap map;
  map.back = scale.cwiseInverse().asDiagonal();
  for (int i = 0; i < kInertialParameters; ++i) {
    const LinkParameters one = unit[i] * LinkParameters::Unit(i);
    const Eigen::Matrix4d P = scale.asDiagonal() * make_pseudo_inertia(one) * scale.asDiagonal();
    map.L.col(i) = Eigen::Map<const Eigen::Matrix<double, 16, 1>>(P.data());
  }
  return map;
}

}  // namespace

Eigen::Matrix4d make_pseudo_inertia(const LinkParameters& phi) {
  Matrix3d I;
  I << phi[4], phi[5], phi[6], phi[5], phi[7], phi[8], phi[6], phi[8], phi[9];
  Eigen::Matrix4d P;
  P << 0.5 * I.trace() * Matrix3d::Identity() - I, phi.segment<3>(1), phi.segment<3>(1).transpose(), phi[0];
  return P;
}

LinkParameters get_parameters(const Eigen::Matrix4d& P) {
  const Matrix3d S = P.topLeftCorner<3, 3>(), I = S.trace() * Matrix3d::Identity() - S;
  LinkParameters phi;
  phi << P(3, 3), P(0, 3), P(1, 3), P(2, 3), I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2);
  return phi;
}

double calc_smallest_eigenvalue(const Vector& phi) {
  double smallest = 1.0;
  for (Eigen::Index i = 0; i < phi.size(); i += kInertialParameters) {
    const Eigen::Vector4d values = Eigenvalues(make_pseudo_inertia(phi.segment<kInertialParameters>(i))).eigenvalues();
    smallest = std::min(smallest, values[0] / values[3]);
  }
  return smallest;
}

Vector distort_bodies(const Vector& phi, double size, unsigned long long seed) {
  Vector out = phi;
  for (Eigen::Index i = 0; i < phi.size(); i += kInertialParameters) {
    Eigen::Matrix4d D = Eigen::Matrix4d::Identity();
    for (int k = 0; k < 16; ++k) {
      // Lengths are of a tenth of a metre: the entry that moves a body is that much smaller.
      const double unit = k / 4 < 3 && k % 4 == 3 ? 0.1 : k / 4 == 3 && k % 4 < 3 ? 0.0 : 1.0;
      D(k / 4, k % 4) +=
          unit * size * calc_noise(seed, static_cast<unsigned long long>(i), static_cast<unsigned long long>(k));
    }
    out.segment<kInertialParameters>(i) =
        get_parameters(D * make_pseudo_inertia(phi.segment<kInertialParameters>(i)) * D.transpose());
  }
  return out;
}

BodyPrior make_body_prior(const Vector& description, double trust) {
  BodyPrior prior{description, Vector(description.size())};
  for (Eigen::Index i = 0; i < description.size(); i += kInertialParameters) {
    const double m = std::max(description[i], 1e-3);
    const double l = std::sqrt(std::max(description.segment<6>(i + 4).cwiseAbs().maxCoeff() / m, 1e-4));
    LinkParameters scale;
    scale << m, m * l, m * l, m * l, Eigen::Matrix<double, 6, 1>::Constant(m * l * l);
    prior.precision.segment<kInertialParameters>(i) = (trust * scale).cwiseAbs2().cwiseInverse();
  }
  return prior;
}

Vector solve_bodies(const Eigen::MatrixXd& A, const Vector& b, const BodyPrior& prior) {
  // In units of what is known beforehand all numbers are near one, and a link's pseudo-inertia is L z.
  const Vector unit = prior.precision.cwiseSqrt().cwiseInverse();
  const Eigen::Index links = b.size() / kInertialParameters;
  Eigen::MatrixXd whole = unit.asDiagonal() * A * unit.asDiagonal();
  whole.diagonal().array() += 1.0;
  std::vector<PseudoMap> maps;
  for (Eigen::Index i = 0; i < links; ++i) {
    maps.push_back(make_pseudo_map(unit.segment<kInertialParameters>(kInertialParameters * i)));
    whole.block<kInertialParameters, kInertialParameters>(kInertialParameters * i, kInertialParameters * i) +=
        kPenalty * maps.back().L.transpose() * maps.back().L;
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(whole);
  const Vector pull = unit.cwiseProduct(b) + prior.mean.cwiseQuotient(unit);
  Eigen::Matrix<double, 16, Eigen::Dynamic> copies(16, links),
      duals = Eigen::Matrix<double, 16, Eigen::Dynamic>::Zero(16, links);
  const auto get = [&](const Vector& z, Eigen::Index i) {
    return Vector(z.segment<kInertialParameters>(kInertialParameters * i));
  };
  const Vector start = prior.mean.cwiseQuotient(unit);
  for (Eigen::Index i = 0; i < links; ++i) copies.col(i) = maps[static_cast<size_t>(i)].L * get(start, i);
  const Eigen::Matrix<double, 16, Eigen::Dynamic> described = copies;
  for (int k = 0; k < kSplits; ++k) {
    Vector right = pull;
    for (Eigen::Index i = 0; i < links; ++i) {
      right.segment<kInertialParameters>(kInertialParameters * i) +=
          kPenalty * maps[static_cast<size_t>(i)].L.transpose() * (copies.col(i) - duals.col(i));
    }
    const Vector z = factor.solve(right);
    for (Eigen::Index i = 0; i < links; ++i) {
      const Vector wanted = maps[static_cast<size_t>(i)].L * get(z, i) + duals.col(i);
      const Eigen::Matrix4d nominal = Eigen::Map<const Eigen::Matrix4d>(described.col(i).data());
      const Eigen::Matrix4d inside =
          put_inside(Eigen::Map<const Eigen::Matrix4d>(wanted.data()), kInside * Eigenvalues(nominal).eigenvalues()[0]);
      copies.col(i) = Eigen::Map<const Eigen::Matrix<double, 16, 1>>(inside.data());
      duals.col(i) = wanted - copies.col(i);
    }
  }
  Vector phi(b.size());
  for (Eigen::Index i = 0; i < links; ++i) {
    const PseudoMap& map = maps[static_cast<size_t>(i)];
    const Eigen::Matrix4d P = Eigen::Map<const Eigen::Matrix4d>(copies.col(i).data());
    phi.segment<kInertialParameters>(kInertialParameters * i) = get_parameters(map.back * P * map.back);
  }
  return phi;
}

}  // namespace hrp::identification
