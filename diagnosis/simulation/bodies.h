// SPDX-License-Identifier: BSD-3-Clause
// The rigid-body side of a rollout: mass matrix and bias efforts of the simulated joints. Two kinds: the robot itself,
// and one joint with all others taken as recorded, which is some twenty times cheaper and good enough to tell causes
// apart.
#pragma once

#include <memory>
#include <vector>

#include "common/multibody/inverse_dynamics.h"
#include "diagnosis/simulation/plant.h"
#include "diagnosis/data/smooth.h"

namespace hrp::diagnosis {

// Efforts [sample][joint] that a motion of the plant's bodies takes, forces at its links included, laws of joints not.
Eigen::MatrixXd calc_efforts(const Plant& plant, const Eigen::MatrixXd& q, const Eigen::MatrixXd& qd,
                             const Eigen::MatrixXd& qdd);

// The wrenches of steady forces on the links; needs update_kinematics. Empty where there are none.
LinkWrenches calc_wrenches(const std::vector<SteadyForce>& forces, const Model& model, const Data& data);

class Bodies {
 public:
  virtual ~Bodies() = default;
  // Mass matrix M [n x n, row by row] and bias [n], M qdd + bias = effort, of the n simulated joints at (q, qd). The
  // moment is t [s] of the recording, near sample `near`.
  virtual void evaluate(double t, size_t near, const double* q, const double* qd, double* M, double* bias) = 0;
  // Efforts [n] that the recorded motion takes at sample k.
  virtual void calc_efforts(size_t k, double* tau) = 0;
};

// A joint along one recording, by sample: its true (link side) motion as far as known, the inertia about it, and the
// effort `load` that the motion of everything takes but for inertia * qdd; slopes of `load` over q and qd of this
// joint.
struct JointPath {
  std::vector<double> q, qd, qdd, inertia, load, stiffness, damping;
};
using RobotPath = std::vector<JointPath>;  // by joint

// All joints by the model of the plant.
std::unique_ptr<Bodies> make_robot_bodies(const Plant& plant, const SmoothRecording& smooth);
// Joint j alone along its path. The path must outlive it.
std::unique_ptr<Bodies> make_path_bodies(const JointPath& path, const std::vector<double>& time);

// The path of every joint along a recording under a plant. Slopes are taken from `slopes` where given (they hardly
// depend on what a hypothesis changes), else computed at every fourth sample. With `links`, the motion of those joints
// (by joint, empty: as recorded) replaces the recorded one.
struct LinkMotion {
  std::vector<double> q, qd, qdd;
};
RobotPath calc_path(const Plant& plant, const SmoothRecording& smooth, const RobotPath* slopes,
                    const std::vector<LinkMotion>& links);

}  // namespace hrp::diagnosis
