// SPDX-License-Identifier: BSD-3-Clause
// Tells efforts in another unit from efforts that carry an unknown load: a unit scales the torque of all bodies alike,
// a load adds the torque of one.
#pragma once

#include "diagnosis/measurement/kept_samples.h"
#include "diagnosis/measurement/torque/terms.h"

namespace hrp::diagnosis {

// True unless a scale of each joint's nominal torque explains the recorded efforts of these joints (at least one, with
// used training samples) clearly better than a load of any link, beside friction, rotors and constants. A load weighs
// at most what moves of the robot.
bool may_be_load(const TorqueData& data, const std::vector<int>& joints);

constexpr long kLoadColumns = 4;  // of a load: mass and moment
// What a drive's effort has beside tau: columns of v, direction, a, constant.
enum Nuisance : long { kSpeed, kDry, kRotor, kConstant, kNuisance };

// Training samples of one joint: nominal torque, effort, and regressors of friction, rotor and constant in any unit.
struct UnitRows {
  Eigen::VectorXd tau, effort;  // [N m], logged unit
  Eigen::MatrixXd nuisance;     // columns: Nuisance
};
UnitRows collect_efforts(const TorqueData& data, int joint);

// Columns of loads, terms of links, in the rows of collect_efforts(), by joint; those of one link stand together.
std::vector<Eigen::MatrixXd> collect_loads(const TorqueData& data, const std::vector<int>& joints,
                                           const std::vector<Term>& loads);

// [kg] of all links that move: arms carry less than they weigh.
double find_moving_mass(const TreeSpec& tree);

// Residual of each column of y after a regression on the columns of X.
Eigen::MatrixXd take_out(const Eigen::MatrixXd& X, const Eigen::MatrixXd& y);

}  // namespace hrp::diagnosis
