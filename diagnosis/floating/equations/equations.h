// SPDX-License-Identifier: BSD-3-Clause
// Every equation whose signals were recorded, along the recorded motion:
//
//   balance        the six equations of the whole body: feet's wrenches against what the motion takes, base axes
//   balance by legs  the same, where no sensor feels the ground, with forces by torques of standing legs (leg_forces.h)
//   weight         the vertical one of them, where feet tell no more
//   joint          a drive's torque (logged, else by its servo law) against inverse dynamics with the feet's wrenches
//   servo          a logged effort against the servo law
//   gyroscope, accelerometer   an IMU against the base's pose, or against another IMU through the encoders
//   gravity        specific force of a body at rest against its attitude, or its size alone
//   tilt           roll and pitch of a flat foot that stands, against the level ground
//   height         of a foot that stands, against the other feet that do
//
// Units: [N], [N m], [rad/s], [m/s^2], [rad], [m].
#pragma once

#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

// [s] of a row: two or three deviations of the kernel, so that errors of neighbours are nearly free
constexpr double kCell = 0.04;

RowTable make_equations(const LeggedLog& log, const Contacts& contacts);

}  // namespace hrp::diagnosis::floating
