// SPDX-License-Identifier: BSD-3-Clause
// Joints whose log has the angle against the base, as a belt from the base or an inertial sensor reads it, where the
// model counts from the link before: the log's angle is the sum of both. The motors' efforts may do work on the same
// angles (motors on the base), or on the model's (motors at the joints).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/conventions/logged_motion.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// Joint `joint` turns about a parallel axis to that of `before`, the joint of its parent link: in the same sense (1) or
// in the opposite one (-1).
struct AbsoluteAngle {
  int joint = 0, before = 0;
  double sense = 1.0;
};

struct AbsoluteAngles {
  std::vector<AbsoluteAngle> joints;  // from the base on
  bool of_efforts = false;            // the efforts belong to these angles, too
  bool any() const { return !joints.empty(); }
};

// Every joint whose parent link turns about a parallel axis.
std::vector<AbsoluteAngle> list_parallel_joints(const TreeSpec& tree);

// Fixed bases. Throws InputError, with file and column, where servos hold such angles: their law is not the model's.
AbsoluteAngles find_absolute_angles(const TorqueData& data, const LoggedMotion& motion, int jobs);

// The recordings with the model's angles, and its efforts.
Experiment convert_angles(Experiment experiment, const AbsoluteAngles& angles);

// In one sentence.
std::string describe(const Experiment& experiment, const AbsoluteAngles& angles);

}  // namespace hrp::diagnosis
