// SPDX-License-Identifier: BSD-3-Clause
// Recordings of one tossed rigid body: poses, twists if they are independent measurements, and the short windows over
// which the motion is predicted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/toss/rollout.h"

namespace hrp::diagnosis::toss {

// One recording: the samples that have a complete pose.
struct Toss {
  std::string file;
  bool train = true;
  std::vector<double> time;           // [s] of the samples with a complete pose
  std::vector<Vector3d> p;            // [m] origin of the body's frame, world axes
  std::vector<Eigen::Quaterniond> R;  // attitude; neighbours have the same quaternion sign
  std::vector<Vector3d> v, w;         // recorded twist [m/s], [rad/s], in the axes of TossProblem; may be empty
};

// Median of many values, with its robust standard error.
struct Measured {
  double value = 0.0, std = 0.0;
  size_t count = 0;
};

// Consecutive samples [first, first + count) of a toss.
struct Window {
  size_t toss = 0, first = 0, count = 0;  // samples
};

// All inputs of the diagnosis; constant.
struct TossProblem {
  const Experiment* experiment = nullptr;
  std::vector<Toss> tosses;
  std::vector<Sole> soles;
  World nominal;
  double sigma_p = 0.0, sigma_R = 0.0;  // [m], [rad] noise of a pose, per axis
  double slow_p = 0.0, slow_R = 0.0;    // [m], [rad] tracker errors that are constant within a window
  std::vector<double> rest_heights;     // [m] above the model's ground: heights of bodies at rest, per toss
  std::optional<Measured> fall, inertia, rest_height;  // see strikes.h; empty if undetermined
  bool stated = false;                                 // the experiment states the noise
  bool has_linear = false, has_angular = false;        // the twist exists and is an independent measurement
  std::vector<std::string> notes;
  std::vector<Window> windows;
  double horizon = 0.0;  // [s] length of the longest window
};

// Builds the problem. Returns false if the recordings are not those of one free rigid body above a ground; `why` then
// says what is missing.
bool make_toss_problem(const Experiment& experiment, TossProblem* problem, std::string* why);

// Velocities and accelerations at sample `at`, in world axes: a local quadratic through the poses of the samples
// [begin, end).
struct LocalMotion {
  Vector3d v{0, 0, 0}, a{0, 0, 0};      // [m/s], [m/s^2] of the frame's origin
  Vector3d w{0, 0, 0}, alpha{0, 0, 0};  // [rad/s], [rad/s^2]
  double misfit = 0.0;                  // rms of the residual, in units of the noise
};
LocalMotion calc_local_motion(const TossProblem& problem, const Toss& toss, size_t begin, size_t end, size_t at);

// Lowest points [m] of the points and spheres of the body's shapes, in world axes.
std::vector<Vector3d> list_lowest_points(const TossProblem& problem, const Transform& X_WB);

// Rotation vector [rad] from `from` to `to`, in world axes.
Vector3d calc_turn(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

}  // namespace hrp::diagnosis::toss
