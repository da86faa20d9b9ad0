// SPDX-License-Identifier: BSD-3-Clause
// A recorded pose of the base in another convention than the model's, or by another clock than that of the encoders:
// what an IMU and the encoders over feet that stand agree about, and the pose does not.
#pragma once

#include <string>

#include "diagnosis/floating/conventions/frame_search.h"

namespace hrp::diagnosis::floating {

// Numbers of a quaternion in columns that say x y z w.
enum class Order { kAsNamed, kScalarFirst, kInverse };

struct PoseFrame {
  Order order = Order::kAsNamed;
  Matrix3d R_world = Matrix3d::Identity();  // from the capture's world to the model's: its up is z
  Matrix3d R_body = Matrix3d::Identity();   // of the base's link in the capture's body: R_WB = R_world R R_body
  double late = 0.0;                        // [s] its stamps are behind those of the encoders by so much
  double left = 1.0;                        // share of the error, in squares, that is left without all of that
  bool is_turned() const { return order != Order::kAsNamed || !R_world.isIdentity(1e-9) || !R_body.isIdentity(1e-9); }
  bool any() const { return is_turned() || late != 0.0; }
};

// The base's pose against the main IMU, which is taken as right. Nominal where nothing leaves a quarter.
PoseFrame find_pose_frame(const Experiment& experiment);

// "the quaternion is taken as w x y z"; of conventions, without the clock.
std::string describe(const PoseFrame& frame);

// The same experiment with the base's pose in the model's axes and at the encoders' time.
Experiment convert_pose(Experiment experiment, const PoseFrame& frame);

}  // namespace hrp::diagnosis::floating
