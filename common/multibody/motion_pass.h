// SPDX-License-Identifier: BSD-3-Clause
// Outward pass that inverse dynamics, bias forces and forward dynamics share. Internal to common/multibody.
//
// Gravity enters as an acceleration -g of the base, so acc below is the true acceleration minus g, what an
// accelerometer measures.
#pragma once

#include "common/multibody/model.h"

namespace hrp::motion_pass {

using small::V3;

// Acceleration of a link from its parent's, qdd of its joint and the velocities.
inline void accelerate(const LinkConstants& L, const LinkKinematics& parent, const LinkKinematics& k, double qd,
                       double qdd, const LinkMotion& parent_motion, LinkMotion* m) {
  const V3 w = parent.w;
  m->alpha = parent_motion.alpha;
  m->acc = parent_motion.acc + cross(parent_motion.alpha, k.r) + cross(w, cross(w, k.r));
  if (L.code == JointCode::kSlide) {
    m->acc += k.axis * qdd + cross(w, k.axis) * (2 * qd);
  } else {
    m->alpha += k.axis * qdd + cross(w, k.axis) * qd;
  }
}

// The same for qdd = 0.
inline void accelerate(const LinkConstants& L, const LinkKinematics& parent, const LinkKinematics& k, double qd,
                       const LinkMotion& parent_motion, LinkMotion* m) {
  const V3 w = parent.w;
  m->alpha = parent_motion.alpha;
  m->acc = parent_motion.acc + cross(parent_motion.alpha, k.r) + cross(w, cross(w, k.r));
  const V3 c = cross(w, k.axis);
  if (L.code == JointCode::kSlide) {
    m->acc += c * (2 * qd);
  } else {
    m->alpha += c * qd;
  }
}

// Force and moment (about the link's origin) that the motion takes. Newton and Euler about the origin, c = h / m:
//   f = m acc + alpha x h + w x (w x h),  n = I alpha + w x I w + h x acc.
inline void load_link(const LinkKinematics& k, V3 h, const small::S3& I, double mass, LinkMotion* m) {
  m->f = m->acc * mass + cross(m->alpha, h) + cross(k.w, cross(k.w, h));
  m->n = I * m->alpha + cross(k.w, I * k.w) + cross(h, m->acc);
}

// The same without turning the inertia into world axes: turns three vectors instead.
inline void load_link(const LinkConstants& L, const LinkKinematics& k, LinkMotion* m) {
  const V3 h = k.R * L.h;
  const V3 w = transpose_times(k.R, k.w), alpha = transpose_times(k.R, m->alpha);
  m->f = m->acc * L.mass + cross(m->alpha, h) + cross(k.w, cross(k.w, h));
  m->n = k.R * (L.I * alpha + cross(w, L.I * w)) + cross(h, m->acc);
}

}  // namespace hrp::motion_pass
