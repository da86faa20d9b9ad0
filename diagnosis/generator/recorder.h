// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "diagnosis/generator/reality.h"

namespace hrp::cases {

// Torque that a drive's current shows and the joint does not feel: amplitude sin(periods q + phase) [N m].
struct EffortRipple {
  double amplitude = 0, periods = 0, phase = 0;
};

// How a case is recorded.
struct RecorderPlan {
  double rate = 500;                                                  // [Hz]
  double jitter = 0;                                                  // of the time stamps, share of a period
  double dropped = 0;                                                 // share of rows that were lost
  double clock_origin = 0;                                            // [s] what the clock shows at the start
  double position_noise = 0, velocity_noise = 0, effort_noise = 0;    // standard deviations [rad, rad/s, N m]
  double force_noise = 0, torque_noise = 0;                           // [N, N m]
  double rate_noise = 0, acceleration_noise = 0, attitude_noise = 0;  // IMU [rad/s, m/s^2, rad]
  double pose_noise = 0;                                              // motion capture [m, rad]
  bool noise_stated = true;
  bool with_velocity = true, with_effort = true, with_base_pose = false, with_commands = true, with_attitude = true;
  double encoder_step = 0;            // [rad] positions are whole numbers of it; 0: as fine as the file
  double stamp_error = 0;             // [s] standard deviation of what the clock stamps
  std::vector<double> effort_noises;  // [N m] by joint, in the place of effort_noise; empty: that
  std::vector<EffortRipple> ripples;  // by joint; empty: none
  bool effort_driven = false;         // efforts are the input, commands are not recorded
  std::string link_encoder;           // joint that has a second encoder behind the transmission; empty: none
};

struct RecordingPlan {
  std::string file, role, motion;
  double start = 0, duration = 10;  // [s]; a start above 0 begins in mid-motion
  Vec3 push{};
  std::vector<Hidden> loads{};  // that hang on the robot in this recording, as the experiment states
  bool soles_lift = false;      // see Reality::run
};

struct Column {
  std::string name;
  std::vector<double> values;
  double noise = 0;  // standard deviation of what was added [unit of the column]
};

RecorderPlan draw_recorder(const RobotPlan& robot, const std::vector<Hidden>& hidden, Prng& random);

// The same with perfect sensors.
RecorderPlan without_noise(RecorderPlan plan);

// Times of the rows of one recording, with jitter.
std::vector<double> draw_row_times(const RecorderPlan& plan, double start, double duration, Prng& random);

// Runs the reality and returns the columns as written, sensor faults included; noise comes from `random` (noise off: a
// plan with zero deviations).
std::vector<Column> record(const RobotPlan& robot, const std::vector<Hidden>& hidden, const RecorderPlan& plan,
                           const RecordingPlan& recording, const Commands& commands, const std::vector<double>& times,
                           Prng& random);

// Columns from readings that were taken at all `instants` (increasing) that list_instants() asks for; `times` may end
// earlier than asked for.
std::vector<double> list_instants(const RobotPlan& robot, const std::vector<Hidden>& hidden, const RecorderPlan& plan,
                                  const std::vector<double>& times);
std::vector<Column> make_columns(const RobotPlan& robot, const std::vector<Hidden>& hidden, const RecorderPlan& plan,
                                 const Commands& commands, const std::vector<double>& times,
                                 const std::vector<double>& instants, const std::vector<Reading>& readings,
                                 Prng& random);
// A sensor's reading with the faults hidden in it (quaternions x y z w), and when what it reads now was true.
std::vector<double> add_sensor_faults(const std::vector<Hidden>& hidden, const std::string& sensor,
                                      std::vector<double> values);
double find_sensor_time(const std::vector<Hidden>& hidden, const std::string& sensor, double t);

std::string make_csv(const std::vector<Column>& columns);
std::string make_urdf(const RobotPlan& robot);
std::string make_experiment_yaml(const RobotPlan& robot, const RecorderPlan& plan,
                                 const std::vector<RecordingPlan>& recordings);

}  // namespace hrp::cases
