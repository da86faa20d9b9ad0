// SPDX-License-Identifier: BSD-3-Clause
// A sample of a recording, and the wrenches that force sensors read there, in the axes of the base.
#pragma once

#include "diagnosis/floating/log/body_motion.h"

namespace hrp::diagnosis::floating {

struct BodySample {
  const LeggedLog& log;
  const Clip& clip;
  size_t clip_index;
  size_t k;            // sample of the clip
  BodyMotion& motion;  // stands at the sample
};

// A wrench on a link, base axes.
struct PointWrench {
  int link = 0;
  Vector3d p, force, moment;  // [m] where it acts, [N], [N m] about p
  bool whole = true;          // false: a part of the wrench is unknown, so that joints are not to see it
};

// Whether a sensor tells all that the ground does to the robot there: six axes, or three under a foot that touches in a
// point. Joints above any other sensor are compared only while its foot is in the air.
bool is_whole(const LeggedLog& log, const ForceSensor& sensor);
// The same of a foot whose sensor tells the wrench whenever the foot is loaded.
bool is_known(const LeggedLog& log, const Foot& foot);

// Axes of a sensor and the point where its wrench acts. A force without a moment acts where the foot touches.
void find_sensor_frame(const BodySample& at, int sensor, Matrix3d* R, Vector3d* p);
PointWrench read_wrench(const BodySample& at, int sensor);

// [N] What the ground carries of the robot below its sensors. After inverse dynamics.
Vector3d calc_force_below(const BodySample& at);

// [N m] The moment about a link's origin that its parent passes on to it. After inverse dynamics.
Vector3d calc_passed_moment(const BodySample& at, int link);

// Along it the weight is compared where feet tell no other force: the mean of the soles' normals by load, or the
// vertical.
Vector3d find_normal(const BodySample& at);

}  // namespace hrp::diagnosis::floating
