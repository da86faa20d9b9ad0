// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/contact_law.h"

#include <cmath>

namespace hrp {

PointContactParameters make_point_parameters(const ContactSpec& spec) {
  const double share = 1.0 / spec.shared_points;
  PointContactParameters point;
  point.stiffness = share * spec.stiffness;
  point.exponent = spec.exponent;
  point.lambda = calc_lambda(spec.alpha, point.stiffness);
  point.tangential_stiffness = share * spec.tangential_stiffness;
  point.tangential_damping = share * spec.tangential_damping;
  point.two_sided = spec.damping == "two_sided";
  return point;
}

// [H03 eq. 1], powers as in [H03 eq. 3] so that spring and damper grow alike.
NormalSpring calc_normal_spring(const PointContactParameters& parameters, double depth) {
  if (!(depth > 0.0)) return {};
  if (parameters.exponent == 1.0) return {parameters.stiffness * depth, parameters.stiffness};
  const double power = std::pow(depth, parameters.exponent - 1.0);
  return {parameters.stiffness * power * depth, parameters.stiffness * parameters.exponent * power};
}

// [H03 eq. 3]
double calc_damper_coefficient(const PointContactParameters& parameters, double depth) {
  if (!(depth > 0.0)) return 0.0;
  return parameters.lambda * (parameters.exponent == 1.0 ? depth : std::pow(depth, parameters.exponent));
}

// [H03 eq. 6]
bool clip_to_cone(double normal_force, double friction, Vector3d* tangential) {
  const double limit = friction * (normal_force > 0.0 ? normal_force : 0.0);
  const double length = tangential->norm();
  if (length <= limit) return false;
  *tangential *= limit / length;
  return true;
}

}  // namespace hrp
