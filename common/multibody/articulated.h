// SPDX-License-Identifier: BSD-3-Clause
// The three inner steps of the articulated-body algorithm for one joint, and the base's 6 x 6 solve. Internal.
//
// A link and all that hangs on it obey [n; f] = A [alpha; acc] + p about the link's origin, A = [J H; H^T M]. alpha and
// acc are deviations from the motion with qdd = 0, whose forces are already in p: no velocity terms appear here, and
// the same steps serve any right-hand side. Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7, with the
// velocity-product terms moved to the outward pass.
#pragma once

#include "common/multibody/model.h"

namespace hrp::articulated {

using small::M3;
using small::S3;
using small::V3;

inline void add(const S3& B, S3* A) {
  A->xx += B.xx;
  A->xy += B.xy;
  A->xz += B.xz;
  A->yy += B.yy;
  A->yz += B.yz;
  A->zz += B.zz;
}

// A -= u v^T s, where u v^T is symmetric.
inline void subtract_square(V3 u, double s, S3* A) {
  const V3 v = u * s;
  A->xx -= u.x * v.x;
  A->xy -= u.x * v.y;
  A->xz -= u.x * v.z;
  A->yy -= u.y * v.y;
  A->yz -= u.y * v.z;
  A->zz -= u.z * v.z;
}

// Adds an articulated inertia whose origin is r away. With acc_child = acc - r x alpha:
//   M' = M, H' = H + [r]M, J' = J - H[r] + [r]H'^T.
inline void add_shifted(const S3& J, const M3& H, const S3& M, V3 r, LinkArticulated* parent) {
  const M3 K{H.x + cross(r, V3{M.xx, M.xy, M.xz}), H.y + cross(r, V3{M.xy, M.yy, M.yz}),
             H.z + cross(r, V3{M.xz, M.yz, M.zz})};
  S3& P = parent->J;
  P.xx += J.xx + r.y * (H.z.x + K.z.x) - r.z * (H.y.x + K.y.x);
  P.yy += J.yy + r.z * (H.x.y + K.x.y) - r.x * (H.z.y + K.z.y);
  P.zz += J.zz + r.x * (H.y.z + K.y.z) - r.y * (H.x.z + K.x.z);
  P.xy += J.xy + r.z * H.x.x - r.x * H.z.x + r.y * K.z.y - r.z * K.y.y;
  P.xz += J.xz + r.x * H.y.x - r.y * H.x.x + r.y * K.z.z - r.z * K.y.z;
  P.yz += J.yz + r.x * H.y.y - r.y * H.x.y + r.z * K.x.z - r.x * K.z.z;
  parent->H.x += K.x;
  parent->H.y += K.y;
  parent->H.z += K.z;
  add(M, &parent->M);
}

// U = A s, 1 / D with D = s^T U + extra. False when D has no right digit: below 1e-14 of what it is a difference of.
inline bool project(bool slides, V3 axis, double extra, LinkArticulated* A) {
  double D, scale;
  if (slides) {
    A->Un = A->H * axis;
    A->Uf = A->M * axis;
    D = dot(axis, A->Uf) + extra;
    scale = A->M.xx + A->M.yy + A->M.zz;
  } else {
    A->Un = A->J * axis;
    A->Uf = transpose_times(A->H, axis);
    D = dot(axis, A->Un) + extra;
    scale = A->J.xx + A->J.yy + A->J.zz;
  }
  A->D_inverse = 1.0 / D;
  return D > 1e-14 * scale;
}

// The parent gets A - U U^T / D.
inline void pass_inertia(const LinkArticulated& A, V3 r, LinkArticulated* parent) {
  S3 J = A.J, M = A.M;
  M3 H = A.H;
  const V3 v = A.Uf * A.D_inverse;
  subtract_square(A.Un, A.D_inverse, &J);
  subtract_square(A.Uf, A.D_inverse, &M);
  H.x -= A.Un * v.x;
  H.y -= A.Un * v.y;
  H.z -= A.Un * v.z;
  add_shifted(J, H, M, r, parent);
}

// u, and the parent gets p + U u / D.
inline void pass_force(bool slides, V3 axis, V3 r, double effort, LinkArticulated* A, LinkArticulated* parent) {
  A->u = effort - dot(axis, slides ? A->f : A->n);
  const double s = A->u * A->D_inverse;
  const V3 f = A->f + A->Uf * s;
  parent->f += f;
  parent->n += A->n + A->Un * s + cross(r, f);
}

// Deviation of a link's acceleration from its parent's; returns that of the joint.
inline double pass_acceleration(bool slides, V3 axis, V3 r, const LinkArticulated& parent, LinkArticulated* A) {
  V3 alpha = parent.alpha, acc = parent.acc + cross(parent.alpha, r);
  const double qdd = (A->u - dot(A->Un, alpha) - dot(A->Uf, acc)) * A->D_inverse;
  (slides ? acc : alpha) += axis * qdd;
  A->alpha = alpha;
  A->acc = acc;
  return qdd;
}

// A = L D L^T of the base: unit lower L below the diagonal, 1 / D on it. False when not positive.
bool factor_base(const LinkArticulated& base, Matrix6d* factor);
// base->alpha, acc = -A^-1 [n; f].
void solve_base(const Matrix6d& factor, LinkArticulated* base);

}  // namespace hrp::articulated
