// SPDX-License-Identifier: BSD-3-Clause
// What the steps that make the missing torque (torque.cpp) share.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque/flags.h"
#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Motion with the sharpest filter and its nominal torque, full grid.
struct SharpMotion {
  Eigen::MatrixXd q, v, a, tau;
};

struct TorqueWork {
  const Experiment& e;
  const BodyTorques& bodies;
  const Plant plant;
  TorqueData data;
  std::vector<double> noise;                             // [rad] by joint
  std::vector<Flags> still;                              // by recording of the experiment, full grid
  std::vector<Flags> sudden;                             // the same; of robots with loaded feet
  std::vector<SharpMotion> sharp;                        // by recording of the experiment
  bool curved = false;                                   // the torque of the smoothed motion is not the smoothed torque
  std::vector<std::vector<std::vector<double>>> closed;  // by recording, by joint: positions from a held foot
};

}  // namespace hrp::diagnosis
