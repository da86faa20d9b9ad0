// SPDX-License-Identifier: BSD-3-Clause
// Sensor readings from the state and the forces of the last step. Rates and attitudes are those of the state that is
// read; forces and accelerations are those that acted over the step that led to it.
#pragma once

#include <vector>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/model.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

// reading = quantised(R(rpy)^T scale value + bias + noise). `channel` numbers the first of the three axes.
Vector3d apply_errors(const SensorErrors& errors, const Vector3d& value, unsigned long long seed,
                      unsigned long long channel, unsigned long long step);

// Nearest multiple of the quantum; the value itself for 0.
double quantise(double value, double quantum);

// What the encoders turn with (the motor side of an elastic transmission), offsets included, and logged efforts.
struct EncoderTruth {
  Eigen::VectorXd q, qd, effort;
};

class Sensors {
 public:
  // Throws InputError for an unknown link.
  Sensors(const Model& model, const Scenario& scenario);
  void reset(const State& state, const Data& data, const EncoderTruth& encoders);
  // Before the state moves on: what the step's forces and accelerations were. `data` at the start of the step;
  // runs inverse dynamics with vdot and the wrenches that acted.
  void update_forces(const Model& model, const Eigen::VectorXd& vdot, const LinkWrenches& wrenches, Data* data);
  // After: `data` at the state that is read.
  void update_readings(const State& state, const Data& data, const EncoderTruth& encoders, unsigned long long step);
  const SensorSample& sample() const { return sample_; }
  bool needs_every_step() const { return needs_every_step_; }

 private:
  struct Mounted {
    int link = 0;
    Transform X_LS;
  };
  // The last values of one group of three channels, for delays.
  struct Delay {
    double steps = 0.0;  // late by so many steps ...
    double gain = 0.0;   // ... more with every step (negative: less, never below none)
    std::vector<Vector3d> ring;
  };
  Vector3d pass(const SensorErrors& errors, Delay* delay, const Vector3d& value, unsigned long long channel,
                unsigned long long step);
  Mounted find_mount(const Model& model, const std::string& link, const Vector3d& p) const;
  void add_delay(const SensorErrors& errors, const Scenario& scenario);
  void update_imus(const Data& data, unsigned long long step);
  void update_wrenches(unsigned long long step);
  void update_encoders(const EncoderTruth& encoders, unsigned long long step);

  SensorsSpec spec_;
  unsigned long long seed_;
  Vector3d gravity_W_;
  bool needs_every_step_ = false;
  std::vector<Mounted> imus_, wrenches_;
  std::vector<Delay> delays_;             // two for every IMU (rate, acceleration), two for every wrench sensor
  std::vector<Vector3d> acceleration_W_;  // [m/s^2] of each IMU
  // Parent to link, about its origin, its axes
  std::vector<Vector6d, Eigen::aligned_allocator<Vector6d>> joint_wrench_L_;
  Eigen::VectorXd tau_;
  SensorSample sample_;
};

}  // namespace hrp
