// SPDX-License-Identifier: BSD-3-Clause
// Rigid-body dynamics of a rollout: mass matrix and bias efforts of the simulated joints. Two implementations: the
// whole robot, and one joint while all others follow the recording. The second one is about twenty times cheaper and
// accurate enough to distinguish causes.
#pragma once

#include <memory>
#include <vector>

#include "common/multibody/inverse_dynamics.h"
#include "diagnosis/data/smooth.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Efforts [sample][joint] of a motion of the plant's bodies, with external forces on its links, without the joints'
// laws.
Eigen::MatrixXd calc_efforts(const Plant& plant, const Eigen::MatrixXd& q, const Eigen::MatrixXd& qd,
                             const Eigen::MatrixXd& qdd);

// A motion of all joints at even steps [sample][joint].
struct JointsMotion {
  Eigen::MatrixXd q, v, a;
};

// The links of elastic joints behind their drives' motion, all others as the drives, `step` [s]:
//   M q'' + h(q, q') = k (q_drive - q) + d (q_drive' - q')
// by the midpoint rule, which adds no damping. They start at rest beside their drives, twisted by their load.
JointsMotion follow_drives(const Plant& plant, JointsMotion drives, double step);

// Wrenches of steady forces on the links; requires update_kinematics. Empty if there are none.
LinkWrenches calc_wrenches(const std::vector<SteadyForce>& forces, const Model& model, const Data& data);

class Bodies {
 public:
  virtual ~Bodies() = default;
  // Mass matrix M [n x n, row by row] and bias [n] of the n simulated joints at (q, qd): M qdd + bias = effort. `t` [s]
  // of the recording, near sample `near`.
  virtual void evaluate(double t, size_t near, const double* q, const double* qd, double* M, double* bias) = 0;
  // Efforts [n] of the recorded motion at sample k.
  virtual void calc_efforts(size_t k, double* tau) = 0;
};

// One joint along a recording, by sample: its true (link-side) motion as far as known; the inertia about it; the effort
// `load` of the motion without inertia * qdd; and the derivatives of `load` with respect to q (`stiffness`) and qd
// (`damping`) of this joint.
struct JointPath {
  std::vector<double> q, qd, qdd, inertia, load, stiffness, damping;
};
using RobotPath = std::vector<JointPath>;  // by joint

// The whole robot by the model of the plant.
std::unique_ptr<Bodies> make_robot_bodies(const Plant& plant, const SmoothRecording& smooth);
// Joint j alone along its path, which must outlive the result.
std::unique_ptr<Bodies> make_path_bodies(const JointPath& path, const std::vector<double>& time);

// Paths of all joints along a recording under a plant. Derivatives come from `slopes` if given (they hardly depend on
// the hypothesis), else they are computed at every fourth sample. `links`: motion that replaces the recorded one, by
// joint; empty: as recorded.
struct LinkMotion {
  std::vector<double> q, qd, qdd;
};
RobotPath calc_path(const Plant& plant, const SmoothRecording& smooth, const RobotPath* slopes,
                    const std::vector<LinkMotion>& links);

}  // namespace hrp::diagnosis
