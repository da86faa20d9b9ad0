// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/ground_plane.h"

namespace hrp {

GroundPlane make_ground_plane(const GroundSpec& ground) {
  GroundPlane plane;
  // A level ground has exactly the normal z: no rounding of sines in the common case.
  if (ground.roll != 0.0 || ground.pitch != 0.0) {
    plane.n_W = make_rotation_from_rpy({ground.roll, ground.pitch, 0.0}).col(2);
  }
  plane.offset = plane.n_W.z() * ground.height;
  plane.present = ground.present;
  return plane;
}

}  // namespace hrp
