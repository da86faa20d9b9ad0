// SPDX-License-Identifier: BSD-3-Clause
// What a robot on its feet recorded, whichever sensors it has: smoothed clips without gaps, and where each sensor sits.
// Nothing is demanded; what is missing is noted.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "diagnosis/floating/log/tracks.h"

namespace hrp::diagnosis::floating {

constexpr double kCalibrated = 0.002;  // [rad] to which zeros of joints are known

// A force sensor: which of force x y z, torque x y z it has in every recording, and where.
struct ForceSensor {
  std::string name;
  int link = -1, foot = -1;  // moving link; foot of LeggedLog on that link, -1: none
  Transform X_LS;
  bool axis[6] = {false, false, false, false, false, false};
  LinkInertia below;   // of the sensor, in the axes of its link, where its reading is no whole wrench: then in the tree
  double hangs = 0;    // [kg] below a sensor that tells the whole wrench: its own reading leaves it out
  bool world = false;  // readings are in world axes, and are what the ground does to the foot
  bool has_force() const { return axis[0] && axis[1] && axis[2]; }
  bool has_wrench() const { return has_force() && axis[3] && axis[4] && axis[5]; }
};

struct Foot {
  std::string name;
  int link = -1, sensor = -1;  // sensor of LeggedLog, -1: none
  bool flat = false;           // a flat sole, else a ball or unknown
  Vector3d p_LC{0, 0, 0};      // [m] centre of the sole's lower face, or of the ball
  double radius = 0;           // [m] of a ball
  Vector3d size{0, 0, 0};      // [m] of a flat sole along the link's x and y; 0: not described
};

struct ImuSensor {
  std::string name;
  int link = -1;
  Matrix3d R_LI = Matrix3d::Identity();
  Vector3d p_LI{0, 0, 0};
  bool attitude = false, gyro = false, accelerometer = false;
};

struct ImuTracks {
  Track attitude[4], gyro[3], accelerometer[3];  // attitude w x y z
};

// One recording, or the part of it between two gaps.
struct Clip {
  size_t recording = 0;
  bool train = true;
  std::vector<double> time;                                    // [s] even
  double step = 0, sigma = 0;                                  // [s] of the grid; deviation of the kernel
  size_t edge = 0;                                             // samples at both ends that the kernel reaches beyond
  std::vector<Track> position, effort, command, command_rate;  // by joint; empty where not recorded
  std::vector<Track> logged;  // efforts as they were logged, where `effort` is corrected
  std::vector<Track> force;   // by sensor * 6
  std::vector<ImuTracks> imus;
  Track base_position[3], base_attitude[4];  // attitude w x y z
  // By sample: what the kernel takes away, over that of the quietest quarter; the worst of accelerometers and forces.
  std::vector<double> roughness;
  std::vector<std::vector<double>> taken_away;  // by column, by sample; empty after make_legged_log()
  size_t size() const { return time.size(); }
};

// Constant after make_legged_log().
struct LeggedLog {
  const Experiment* experiment = nullptr;
  TreeSpec tree;                    // without what is below force sensors
  double mass = 0, mass_below = 0;  // [kg] of the robot; of it below sensors
  std::vector<ForceSensor> sensors;
  std::vector<Foot> feet;
  std::vector<ImuSensor> imus;
  std::vector<Clip> clips;
  std::vector<char> has_position, has_effort, has_law;  // by joint, in every recording
  bool base_pose = false;
  std::vector<std::string> missing;    // "no column /wrench/l_sole/torque/x: ..."
  std::vector<std::string> notes;      // gaps, held samples
  std::vector<std::string> too_short;  // recordings without a clip, with the reason
  double sample_time = 0;
  int num_joints() const { return tree.num_joints(); }
  bool is_driven(size_t joint) const { return has_effort[joint] || has_law[joint]; }
};

// From every second sample: two logs of the same grid whose noise is independent. Of all samples: not smoothed.
LeggedLog make_legged_log(const Experiment& experiment, Half half);

}  // namespace hrp::diagnosis::floating
