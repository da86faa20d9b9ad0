// SPDX-License-Identifier: BSD-3-Clause
// How two feet share the load, by their vertical forces alone, against the zero-moment point. It names no effect: a
// wrong zero of one foot and a centre of mass elsewhere look alike here.
#pragma once

#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

// Share of the robot's load on the first of two feet.
struct LoadShare {
  double measured = 0;  // by the forces
  // By the zero-moment point: 1 at the first foot's middle, 0 at the second's, between them beside
  double required = 0;
};

// A robot's zero-moment point on the plane through `p_B` across `up_B` [m], base axes; from the moment and force that
// its motion takes, about the base's origin.
Vector3d calc_zero_moment_point(const Vector3d& moment_B, const Vector3d& force_B, const Vector3d& up_B,
                                const Vector3d& p_B);

// Sentences with figures; none where the robot has not two feet whose forces are there.
std::vector<std::string> compare_loads(const LeggedLog& log);

}  // namespace hrp::diagnosis::floating
