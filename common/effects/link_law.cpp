// SPDX-License-Identifier: BSD-3-Clause
#include "common/effects/link_law.h"

namespace hrp {

void add_payload(double mass, const Vector3d& p_LP, double inertia_about_centre, LinkInertia* link) {
  const double total = link->mass + mass;
  if (!(total > 0.0)) return;
  // Two bodies about their common centre of mass: the reduced mass on the distance between their centres.
  const Vector3d d = p_LP - link->p_LLcm_L;
  const double reduced = link->mass * mass / total;
  link->I_LLcm_L += reduced * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose());
  link->I_LLcm_L += inertia_about_centre * Matrix3d::Identity();
  link->p_LLcm_L += mass / total * d;
  link->mass = total;
}

void scale_mass(double scale, LinkInertia* inertia) {
  inertia->mass *= scale;
  inertia->I_LLcm_L *= scale;
}

void move_centre_of_mass(const Vector3d& offset, LinkInertia* inertia) { inertia->p_LLcm_L += offset; }

}  // namespace hrp
