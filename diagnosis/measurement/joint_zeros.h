// SPDX-License-Identifier: BSD-3-Clause
// Joints whose zero, or whose sense of turning, is not the model's: a driver counts from another pose than the URDF.
//
// Effort = tau(s q + d, s v, s a) + friction + rotor, with d the zero of each joint and s = +-1 its sense. An offset of a
// quarter of a radian is beyond what a linear term tells from loads and forces, so zeros are searched for with the whole
// inverse dynamics, joint by joint.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

struct JointZero {
  int joint = 0;
  double offset = 0.0, std = 0.0;  // [rad] encoder reads true + offset
  bool turned = false;             // positions, rates and efforts have the other sign
};

struct JointZeros {
  std::vector<JointZero> joints;  // that are turned, or off by more than a linear term tells
  double left = 1.0;              // share of the squares of the missing torque that stays with them, friction and rotor taken out
};

// Revolute joints of a robot on a fixed base whose gravity tells. `data` must have recordings.
JointZeros find_joint_zeros(const TorqueData& data);

// Gravity in world axes [m/s^2] that the efforts ask for, by least squares: torques are linear in it.
struct FoundGravity {
  Vector3d g_W = Vector3d::Zero();
  double left = 1.0;  // as above
};
FoundGravity find_gravity(const TorqueData& data);

// The same experiment with readings and commands that count as the model does.
Experiment convert_zeros(Experiment experiment, const std::vector<JointZero>& joints);

}  // namespace hrp::diagnosis
