// SPDX-License-Identifier: BSD-3-Clause
// State of a hidden robot on MuJoCo, and the steps of its integration.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <utility>
#include <vector>

#include "diagnosis/generator/joint_reality.h"
#include "diagnosis/generator/reality.h"
#include "diagnosis/generator/walk_forces.h"

namespace hrp::cases {

// Bush of one foot: addresses of slide, roll, pitch and the six coefficients.
struct Bush {
  int qpos = 0, dof = 0;
  double k[3]{}, c[3]{}, hardening_angle = 0;
};

// A horizontal force that comes and goes: amplitude [N], frequency [Hz], direction in the world's plane [rad].
struct Gust {
  int body = 0;
  double amplitude = 0, frequency = 0, direction = 0;
};

struct Reality::Impl {
  RobotPlan robot;
  std::vector<JointReality> joints;
  mjModel* m = nullptr;
  mjData* d = nullptr;
  std::vector<int> q_link, v_link, q_motor, v_motor;  // addresses; motor = link where nothing is elastic
  std::vector<Bush> bushes;
  std::vector<std::pair<int, Vec3>> forces;  // body, constant force in world axes [N]
  std::vector<Gust> gusts;
  std::unique_ptr<WalkForces> walk_forces;
  int push_body = -1;
  Vec3 push{};
  const Commands* commands = nullptr;
  double dt = 2e-4;
  std::vector<double> beside;  // torque on each link that does not go through its transmission [N m]
  std::vector<double> z;       // lag states [N m], then Bouc-Wen states [rad], then warmth of the coils

  ~Impl() {
    if (d) mj_deleteData(d);
    if (m) mj_deleteModel(m);
  }

  int count() const { return joint_count(robot); }
  void find_addresses(const std::vector<Hidden>& hidden);
  double find_step(bool soles_lift = false);
  void choose_step(double end, bool soles_lift);
  double find_rate(bool stiffness, bool soles_lift);
  double calc_servo_effort(int j, double t, const double* q, const double* v) const;
  void apply_forces(double t, const std::vector<double>& states, std::vector<double>& rates);
  void apply_joint(int j, double t, const std::vector<double>& states, std::vector<double>& rates);
  void update_dry_friction(double t);
  void step(double t, double h);
  void reset();
  Reading read(double t);
  void check_sane(double t) const;
  bool has_fallen() const;
};

}  // namespace hrp::cases
