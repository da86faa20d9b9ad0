// SPDX-License-Identifier: BSD-3-Clause
// Friction outside the list that may look like a gear that the load hardly turns (`backdriving_friction`): the share r
// of the load where it drives the joint. In its place are tried
//   friction, or friction of the load, that follows an angle: s q_k, |tau| s q_k (hydraulic legs, Bowden cables, worn
//   gears) friction of the load or the speed that differs by direction: |tau|, |v| an effort that reads differently
//   with each sign: y, |y| (cylinders with a rod, rectified currents)
// s: direction of the joint's motion, q_k: angle of any joint that carries it or that it carries.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/evidence/joint_rows.h"
#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// The law that leaves least on samples that were not fitted, in words, if it leaves clearly less than the gear of
// `gear` (its column by recording) does; "" if there is none. `laws`: all others at the joint, fitted again.
std::string find_unlisted_friction(const TorqueData& data, const FoundLaws& laws,
                                   const std::vector<Eigen::VectorXd>& gear);

// Makes each supported gear of this kind ambiguous in whose place such a law does better.
void doubt_gears(const TorqueDesign& design, const Choice& choice, std::vector<GradedTerm>* graded);

}  // namespace hrp::diagnosis
