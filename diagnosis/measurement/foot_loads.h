// SPDX-License-Identifier: BSD-3-Clause
// Feet of a robot on a rail or stand that touch the ground or are held, with the measured wrench of the ground on them:
//
//   tau = M(q) a + h(q, v) - J^T F,   F: measured wrench on the foot
//
// A held foot closes the kinematic chain and so gives the position of a rail that was not recorded.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

struct LoadedFoot {
  std::string sensor;  // name of the wrench sensor in the experiment
  int frame = -1;      // index in the robot's tree, where the wrench acts
  bool world = false;  // axes of the reading: world, else the frame's
};

// Wrench sensors at links of `feet` or `feet_attached` of a fixed base, if every recording has their forces.
std::vector<LoadedFoot> list_loaded_feet(const Experiment& experiment);

// Columns of a foot's wrench: force x y z, torque x y z; null if not recorded.
std::vector<const std::vector<double>*> find_wrench_columns(const Recording& recording, const std::string& sensor);

// J^T F by joint [N m or N]. `wrench`: six numbers per foot as recorded, force [N] then torque [N m]. Requires updated
// kinematics.
Eigen::VectorXd calc_load_torques(const Model& model, const Data& data, const std::vector<LoadedFoot>& feet,
                                  const Eigen::VectorXd& wrench);

// Positions [m], one per sample, of a prismatic joint that was not recorded, from a held foot. Zero at the first
// sample. Empty if the recording has no held foot.
std::vector<double> close_chain(const Experiment& experiment, const Recording& recording, int joint);

}  // namespace hrp::diagnosis
