// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/inertia_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace hrp {
namespace {

// Files carry about six digits: a thin plate, which reaches the bound exactly, may miss it by this much.
constexpr double kTriangleTolerance = 1e-5;
constexpr double kSmallestGyration = 1e-3;  // [m] of a repaired inertia
constexpr double kSmallestMass = 1e-3;      // [kg] of a link that had none: less than any screw that holds it

std::string format_moments(const Vector3d& moments) {
  char text[120];
  std::snprintf(text, sizeof text, "principal moments %.6g, %.6g, %.6g kg m^2", moments[0], moments[1], moments[2]);
  return text;
}

// m (p^2 1 - p p^T): inertia of a point mass at p.
Matrix3d calc_point_inertia(double mass, const Vector3d& p) {
  return mass * (p.squaredNorm() * Matrix3d::Identity() - p * p.transpose());
}

}  // namespace

std::string find_inertia_fault(const LinkInertia& inertia) {
  if (!std::isfinite(inertia.mass) || !inertia.p_LLcm_L.allFinite() || !inertia.I_LLcm_L.allFinite()) {
    return "mass, centre of mass or inertia is not finite";
  }
  const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(inertia.I_LLcm_L).eigenvalues();  // ascending
  // Rounding of the solver: a moment that is zero comes out as a few 1e-16 of the largest.
  if (moments[0] <= 1e-12 * std::max(moments[2], 0.0)) {
    return "inertia is not positive definite: " + format_moments(moments);
  }
  if (moments[0] + moments[1] < moments[2] * (1.0 - kTriangleTolerance)) {
    return "inertia breaks the triangle inequality (the two smaller moments add up to less than the largest): " +
           format_moments(moments);
  }
  return "";
}

LinkInertia repair_inertia(const LinkInertia& inertia) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(inertia.I_LLcm_L);
  const double mass = inertia.mass > 0.0 ? inertia.mass : kSmallestMass;
  const double smallest = std::max(mass * kSmallestGyration * kSmallestGyration, 1e-12);
  Vector3d moments = solver.eigenvalues().cwiseMax(smallest);
  const double missing = moments[2] - (moments[0] + moments[1]);
  if (missing > 0.0) moments.head<2>().array() += 0.5 * missing;
  LinkInertia repaired = inertia;
  repaired.mass = mass;
  const Matrix3d I = solver.eigenvectors() * moments.asDiagonal() * solver.eigenvectors().transpose();
  repaired.I_LLcm_L = 0.5 * (I + I.transpose());
  return repaired;
}

LinkInertia add_inertias(const LinkInertia& a, const LinkInertia& c, const Transform& X_LC) {
  if (c.mass == 0.0 && c.I_LLcm_L.isZero(0.0)) return a;
  const Vector3d p_LCcm_L = X_LC * c.p_LLcm_L;
  const Matrix3d I_CCcm_L = X_LC.R * c.I_LLcm_L * X_LC.R.transpose();
  LinkInertia sum;
  sum.mass = a.mass + c.mass;
  if (sum.mass > 0.0) sum.p_LLcm_L = (a.mass * a.p_LLcm_L + c.mass * p_LCcm_L) / sum.mass;
  const Matrix3d I = a.I_LLcm_L + calc_point_inertia(a.mass, a.p_LLcm_L - sum.p_LLcm_L) + I_CCcm_L +
                     calc_point_inertia(c.mass, p_LCcm_L - sum.p_LLcm_L);
  sum.I_LLcm_L = 0.5 * (I + I.transpose());
  return sum;
}

}  // namespace hrp
