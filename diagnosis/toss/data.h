// SPDX-License-Identifier: BSD-3-Clause
// Recordings of one tossed rigid body: poses, velocities where they say something of their own, and the short stretches
// ("windows") over which its motion is predicted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/toss/rollout.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::toss {

struct Toss {
  std::string file;
  bool train = true;
  std::vector<double> time;           // [s] of the samples with a whole pose
  std::vector<Vector3d> p;            // [m] origin of the body's frame, world axes
  std::vector<Eigen::Quaterniond> R;  // attitude, neighbours on the same half sphere
  std::vector<Vector3d> v, w;         // recorded twist: [m/s] and [rad/s], in the axes of TossProblem; may be empty
};

// Median of many values with its standard error, both robust.
struct Measured {
  double value = 0.0, std = 0.0;
  size_t count = 0;
};

struct Window {
  size_t toss = 0, first = 0, count = 0;  // samples
};

struct TossProblem {
  const Experiment* experiment = nullptr;
  std::vector<Toss> tosses;
  std::vector<Sole> soles;
  World nominal;
  double sigma_p = 0.0, sigma_R = 0.0;  // [m], [rad] noise of a pose, each axis
  double slow_p = 0.0, slow_R = 0.0;    // [m], [rad] errors of a tracker that stay the same for a whole window
  std::vector<double> rest_heights;     // [m] over the model's ground, of bodies that lie flat at the end of a toss
  std::optional<Measured> fall, inertia, rest_height;  // see strikes.h; empty where poses do not tell
  bool stated = false;                  // the noise is the experiment's
  bool linear_in_body = false, angular_in_body = true;  // axes of the twist, found from the poses
  bool has_linear = false, has_angular = false;         // the twist is there and a measurement of its own
  std::vector<std::string> notes;
  std::vector<Window> windows;
  double horizon = 0.0;  // [s] of a window
};

// False when the recordings are not those of one free rigid body over a ground; `why` says what is missing.
bool make_toss_problem(const Experiment& experiment, TossProblem* problem, std::string* why);

// Velocities by differences of the poses around sample k, over +- `half` samples by a local quadratic; world axes.
struct LocalMotion {
  Vector3d v{0, 0, 0}, a{0, 0, 0};      // [m/s], [m/s^2] of the frame's origin
  Vector3d w{0, 0, 0}, alpha{0, 0, 0};  // [rad/s], [rad/s^2]
  double misfit = 0.0;                  // root mean square of what is left, in units of the noise
};
LocalMotion calc_local_motion(const TossProblem& problem, const Toss& toss, size_t begin, size_t end, size_t at);

// Lowest positions of the points and spheres of the body's shapes [m].
std::vector<Vector3d> list_lowest_points(const TossProblem& problem, const Transform& X_WB);

// Rotation vector that turns `from` into `to`, world axes.
Vector3d calc_turn(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

}  // namespace hrp::diagnosis::toss
