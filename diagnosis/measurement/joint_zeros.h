// SPDX-License-Identifier: BSD-3-Clause
// Finds joints whose zero or sense of rotation differs from the model, because the driver counts from another pose than
// the URDF.
//
// Effort = tau(s q + d, s v, s a) + friction + rotor, with the zero d and the sense s = +-1 of each joint. A linear
// term cannot represent an offset of a quarter of a radian well enough to separate it from loads and forces. Therefore
// the search uses the full inverse dynamics, joint by joint.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

struct JointZero {
  int joint = 0;
  double offset = 0.0, std = 0.0;  // [rad] encoder reading = true position + offset
  bool turned = false;             // positions, rates and efforts have the opposite sign
};

struct JointZeros {
  std::vector<JointZero> joints;  // reversed joints, and offsets too large for a linear term
  double left = 1.0;  // squared missing torque that remains, relative to the nominal zeros, beside friction and rotor
  double of_effort = 1.0;  // the same relative to the efforts' variance, mean over the joints
};

// Checks the revolute joints of a robot on a fixed base. Empty without gravity. `data` must have recordings.
JointZeros find_joint_zeros(const TorqueData& data);

// Gravity in world axes [m/s^2] that fits the efforts by least squares; torques are linear in it.
struct FoundGravity {
  Vector3d g_W = Vector3d::Zero();
  double left = 1.0;  // squared missing torque that remains, relative to the stated gravity
};
FoundGravity find_gravity(const TorqueData& data);

// The experiment with readings and commands in the model's zeros and senses.
Experiment convert_zeros(Experiment experiment, const std::vector<JointZero>& joints);

// The effort of one joint with the other sign.
Experiment turn_effort(Experiment experiment, int joint);

}  // namespace hrp::diagnosis
