// SPDX-License-Identifier: BSD-3-Clause
// Alternatives that the missing torque cannot distinguish from a finding, even if the finding fits well.
#pragma once

#include "diagnosis/evidence/torque/grade.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Lists alternative explanations of one graded term:
//
// - A wrong torque constant equals a wrong scale of the effort log, and a constant torque equals a bias of it. Only a
//   log that follows the servo's law separates them.
// - Coulomb friction may be Stribeck friction if the upper bound of the static friction is well above the level.
// - A constant torque equals the mean of Coulomb friction that is larger in one direction.
// - A gear that loses the share r of a load that drives it equals load-dependent friction mu = r / (2 - r) in both
//   directions together with a torque constant 1 + mu times the stated one. Both need the load to lift it and 1 - r of
//   it to lower it.
//
// `excess`: the Stribeck term beside the friction, or null. `level`: the joint's Coulomb friction, or null.
std::vector<Alternative> list_indistinguishable(const TorqueData& data, const GradedTerm& term,
                                                const GradedTerm* excess, const GradedTerm* level);

// Alternative to a wrong mass beside load-dependent friction: one gear that is hard to drive backwards
// (torque/gears.h). `friction`: load-dependent friction of the only joint that carries the link of `mass`.
Alternative make_gear_alternative(const TorqueData& data, const GradedTerm& mass, const GradedTerm& friction);

// An estimate from a 95 % range. Its standard deviation also contains `deviation`.
Estimate make_ranged(const char* name, const std::string& unit, const Range& range, double deviation);

// Findings of an effort log that the servo's law contradicts: its scale and its bias.
std::vector<Finding> make_log_findings(const Experiment& experiment, int joint, const ServoReading& log);
// Findings from a joint's position and velocity columns, which contradict each other: scale, bias, delay.
std::vector<Finding> make_velocity_findings(const Experiment& experiment, int joint,
                                            const std::vector<VelocityReading>& logs);

}  // namespace hrp::diagnosis
