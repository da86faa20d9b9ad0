// SPDX-License-Identifier: BSD-3-Clause
// The contact of a pair of bodies as one wrench, as Hirukawa et al. 2003 ("[H03]") write it: eq. 1 to 6. What this
// keeps of the paper and what we had to choose: docs/contact_laws.md.
//
// Everything here is about the pair's centre Q, in axes of body A. Vectors are [angular; linear]: displacement [turn;
// translation], twist [w; v] of A against B, wrench [moment; force] on A. D is the displacement of A from where the
// bodies just do not overlap: sunk into a floor by 1 mm it is (0, 0, 0, 0, 0, -1e-3). Norms of wrenches and angles
// between them need one unit: moments are divided by `length`, angular velocities multiplied by it. The power stays the
// same.
#pragma once

#include <array>

#include "common/spatial/transform.h"
#include "servers/dynamics/twist_projection.h"

namespace hrp {

struct WrenchLaw {
  Vector6d stiffness = Vector6d::Ones();  // diagonal of K, [N m/rad] x 3, [N/m] x 3; positive
  Vector6d damping = Vector6d::Zero();    // diagonal of C, [N m s/rad] x 3, [N s/m] x 3
  double alpha = 0.0;                     // lambda = 3/2 alpha K; [s/m^n] for translations, [s/rad^n] for rotations
  double exponent = 1.0;                  // n of [H03 eq. 3]
  double length = 0.1;                    // [m]
  bool two_sided = false;                 // leaves [H03 eq. 2] out
};

// Points of contact: r from Q [m], n unit from B to A, both in axes of A; depth [m], negative above the surface.
struct PairPoint {
  Vector3d r, n;
  double depth = 0.0;
};

// The displacement that overlaps, and the forces [N] >= 0 along the points' normals that its spring wrench consists of.
struct PairDisplacement {
  Vector6d D = Vector6d::Zero();
  std::array<double, kMaxProjectionPoints> force;
  Matrix6d slope = Matrix6d::Zero();  // of K D over a displacement of A; symmetric, K where all points hold
};

// Of all small displacements that separate the bodies at every point, the one with the least energy in the spring, D
// its opposite. So -K D consists of forces that push at the points. Hildreth's method as in twist_projection.h.
PairDisplacement calc_pair_displacement(const WrenchLaw& law, const PairPoint* points, int num);

// [H03 eq. 1]: F = -K D.
Vector6d calc_spring_wrench(const Vector6d& stiffness, const Vector6d& D);

// [H03 eq. 3]: -lambda abs(D)^n V element by element, lambda = 3/2 alpha K; V: the twist projected by [H03 eq. 2].
Vector6d calc_damping_wrench(const WrenchLaw& law, const Vector6d& D, const Vector6d& V);

// Diagonal of the above's slope over V.
Vector6d calc_damping_coefficients(const WrenchLaw& law, const Vector6d& D);

// [H03 eq. 4]: the normal wrench. The spring is linear, the damper alone has the exponent.
Vector6d calc_normal_wrench(const Vector6d& spring, const Vector6d& damper);

// [H03 eq. 5]: damping -C V of what is orthogonal to the normal wrench, in six dimensions. Zero without a normal
// wrench.
Vector6d calc_tangential_wrench(const WrenchLaw& law, const Vector6d& normal, const Vector6d& V);

// Matrix of the above over V, negative: symmetric, not negative.
Matrix6d calc_tangential_slope(const WrenchLaw& law, const Vector6d& normal);

// [H03 eq. 6]: the norm of the tangential wrench is at most friction times that of the normal one. True when it
// clipped.
bool clip_wrench(double friction, double length, const Vector6d& normal, Vector6d* tangential);

// Norm of a wrench with moments over `length` [N].
double calc_wrench_norm(double length, const Vector6d& wrench);

}  // namespace hrp
