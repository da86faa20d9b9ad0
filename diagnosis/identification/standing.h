// SPDX-License-Identifier: BSD-3-Clause
// Which foot stands when, from its force sensor: the base of the chain is the soles that stand, one or both.
//
// A foot stands at a sample when it carries at least kAirborne and its centre of pressure is kEdge inside the sole's
// outline: a sole that carries its load on an edge has it there, and its bush's angles are not those of a level sole.
// That must hold for kReach before and after, as far as the filters look.
#pragma once

#include <utility>
#include <vector>

#include "diagnosis/identification/foot_frame.h"
#include "diagnosis/identification/robot_log.h"

namespace hrp::identification {

constexpr double kAirborne = 20.0;  // [N]
constexpr double kEdge = 0.003;     // [m] force sensors without zero are off by 1 mm of 250 N
constexpr double kReach = 0.25;     // [s]

using Mask = Eigen::Array<bool, Eigen::Dynamic, 1>;

struct SensorZero;
// By foot, sample by sample. For kReach at both ends, where a run begins and ends, as next to them.
std::vector<Mask> find_standing(const RobotLog& log, const std::vector<FootFrame>& feet,
                                const std::vector<SensorZero>& zeros);
// First sample and one after the last of each stretch of true.
std::vector<std::pair<Eigen::Index, Eigen::Index>> find_stretches(const Mask& mask);

}  // namespace hrp::identification
