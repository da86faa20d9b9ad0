// SPDX-License-Identifier: BSD-3-Clause
// Tells friction of a drive that turns with two joints from friction of one joint.
//
// Differential wrists, hollow shafts inside one another, parallelograms and tendons couple joints: a motor turns at
// v_j + r v_k, and the power of its friction acts at both joints. The rates of the two joints are not those of the
// motors, so
//
//   missing_j = own friction and rotor + c sign(v_j + r v_k) + b v_k + J a_k,   c > 0.
//
// Nothing else is like the first of these terms. Torques of bodies depend on rates through squares and products, which
// do not change when all rates turn around; springs do not depend on rates; a delay has no jump where a rate changes
// its sign.
#pragma once

#include <vector>

#include "diagnosis/evidence/joint_rows.h"

namespace hrp::diagnosis {

// A motor whose friction acts at `joint`.
struct CoupledDrive {
  int other = 0;       // joint that it turns with, too
  double ratio = 0.0;  // [1] r; the unit is that of both joints' rates
  double level = 0.0;  // [N m or N] c
};

struct CoupledDrives {
  std::vector<CoupledDrive> drives;  // up to two: a differential has two motors; empty: none
  double left = 0.0;                 // [(N m)^2] mean square that remains beside them, held out
};

// Drives with whose friction the joint's laws leave less than half of the squares on held-out recordings; without any,
// on the last third of the samples.
CoupledDrives find_coupled_drives(const TorqueData& data, const FoundLaws& joint);

}  // namespace hrp::diagnosis
