// SPDX-License-Identifier: BSD-3-Clause
// Cameras and lidars of a scenario, and when they look.
//
// Frames, as in REP 103. A sensor's mount C has x forward, y left, z up: with rpy 0 it looks along the link's x axis.
// Pictures are in the optical frame O of the same origin: z forward, x right, y down. Points of a lidar are in its
// mount.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "common/spatial/transform.h"

namespace hrp {

struct CameraSpec {
  std::string name;
  std::string link;                 // any URDF link; empty: fixed to the world
  Transform X_LC;                   // mount
  int width = 320, height = 240;    // [pixels]
  double fov = 1.2;                 // [rad] horizontal, between the outer edges of the outer pixels
  double rate = 30.0;               // [1/s of simulated time]
  double near = 0.05, far = 100.0;  // [m] along the optical axis: nothing is seen that is nearer or farther
  bool color = true, depth = true;  // pictures that it takes
  double color_noise = 0.0;         // standard deviation, full scale is 1
  double depth_noise = 0.0;         // [m] standard deviation
};

struct LidarSpec {
  std::string name;
  std::string link;             // as a camera's
  Transform X_LC;               // mount
  double rate = 10.0;           // [1/s of simulated time] of whole scans; all rays of one are of the same instant
  int columns = 360, rows = 1;  // rays in a scan
  // [rad] Ray j of `columns` has the azimuth of the middle of the j-th of as many equal parts; rows likewise. Azimuth
  // turns from x to y, positive elevation is up.
  double first_azimuth = -M_PI, last_azimuth = M_PI;
  double first_elevation = 0.0, last_elevation = 0.0;
  double min_range = 0.1, max_range = 30.0;  // [m]
  double noise = 0.0;                        // [m] standard deviation of the range
};

// X_CO: optical frame of a camera in its mount.
Transform make_optical_frame();

// frame_id of a camera's messages (its optical frame) and of a lidar's (its mount).
std::string find_optical_frame_name(const CameraSpec& camera);
std::string find_frame_name(const LidarSpec& lidar);

// A sensor with this rate [1/s] looks at this step: the first control step at or after each multiple of 1 / rate. With
// it come sensor data, clock and frames of the same time. `time_step` [s], `control_period` [steps].
bool is_look_due(double rate, uint64_t step, double time_step, int control_period);

// Sensors are numbered: cameras in the scenario's order, then lidars. Those that look at this step.
std::vector<size_t> find_looking_sensors(const std::vector<CameraSpec>& cameras, const std::vector<LidarSpec>& lidars,
                                         uint64_t step, double time_step, int control_period);

}  // namespace hrp
