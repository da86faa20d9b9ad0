// SPDX-License-Identifier: BSD-3-Clause
// The contact of Hirukawa et al. 2003 ("[H03]") as laws of one point; as laws of a pair: wrench_law.h. Derivations:
// docs/contact_laws.md.
//
// Signs: n points from body B to body A, forces act on A, approach speed is positive while the bodies close in.
// Horizon h: with h = 0 a law gives its force now; with h = dt the force at the end of the step as an affine function
// of the velocity there, which is what the linearly implicit step needs.
#pragma once

#include <Eigen/Dense>

#include "common/robot/scenario.h"
#include "common/spatial/transform.h"

namespace hrp {

// Share of one point in the parameters of its pair.
struct PointContactParameters {
  double stiffness = 0.0;             // [N/m^n] normal
  double exponent = 1.0;              // n of [H03 eq. 1, 3]
  double lambda = 0.0;                // [N s/m^(n+1)] 3/2 alpha K, [H03 eq. 3]
  double tangential_stiffness = 0.0;  // [N/m] of the sticking spring (beyond the paper)
  double tangential_damping = 0.0;    // [N s/m] C of [H03 eq. 5]
  bool two_sided = false;             // damper also while separating (Hunt-Crossley)
};

PointContactParameters make_point_parameters(const ContactSpec& spec);

// Normal spring of a point, [H03 eq. 1] with exponent n: force and its slope over depth. Zero when not touching.
struct NormalSpring {
  double force = 0.0;  // [N]
  double slope = 0.0;  // [N/m]
};
NormalSpring calc_normal_spring(const PointContactParameters& parameters, double depth);

// Coefficient of the non-linear damper, [H03 eq. 3]: lambda depth^n [N s/m].
double calc_damper_coefficient(const PointContactParameters& parameters, double depth);

// lambda of [H03 eq. 3].
inline double calc_lambda(double alpha, double stiffness) { return 1.5 * alpha * stiffness; }

// The part of a vector across the unit normal n. Inline, as every point needs it in every solve.
inline Vector3d remove_normal(const Vector3d& n, const Vector3d& v) { return v - n * n.dot(v); }

// Tangential force before clipping: damper of [H03 eq. 5] and the sticking spring. slip: displacement of A against B
// since it stuck; velocity: relative velocity of A at the point. Both without normal part.
inline Vector3d calc_tangential_force(const PointContactParameters& parameters, const Vector3d& slip,
                                      const Vector3d& velocity) {
  return -(parameters.tangential_stiffness * slip + parameters.tangential_damping * velocity);
}

// [H03 eq. 6] for one point: no force of more than friction x normal along the surface. Returns true when it clipped.
bool clip_to_cone(double normal_force, double friction, Vector3d* tangential);

}  // namespace hrp
