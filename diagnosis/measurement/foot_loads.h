// SPDX-License-Identifier: BSD-3-Clause
// Feet of a robot on a rail or stand that touch the ground or are held, with the measured force of the ground on them:
//
//   tau = M(q) a + h(q, v) - J^T F,   F: measured wrench on the foot
//
// A foot that is held closes the chain: it gives the position of a rail that was not recorded.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

struct LoadedFoot {
  std::string sensor;  // name of the wrench in the experiment
  int frame = -1;      // of the robot's tree, at which the wrench acts
  bool world = false;  // axes of the reading: the world's, else the frame's
};

// Sensors at links under `feet` or `feet_attached` of a base that does not move, with forces in every recording.
std::vector<LoadedFoot> list_loaded_feet(const Experiment& experiment);

// Columns of one foot's reading: force x y z, torque x y z; empty where a torque was not recorded.
std::vector<const std::vector<double>*> find_wrench_columns(const Recording& recording, const std::string& sensor);

// J^T F by joint [N m or N]. `wrench`: six numbers of every foot as recorded, force then torque. Needs updated kinematics.
Eigen::VectorXd calc_load_torques(const Model& model, const Data& data, const std::vector<LoadedFoot>& feet,
                                  const Eigen::VectorXd& wrench);

// Position at every sample of a prismatic joint that was not recorded, from a foot that is held. Its zero is where the
// recording begins. Empty when the recording has no such foot.
std::vector<double> close_chain(const Experiment& experiment, const Recording& recording, int joint);

}  // namespace hrp::diagnosis
