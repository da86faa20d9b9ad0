// SPDX-License-Identifier: BSD-3-Clause
// Effects that no missing torque tells from a finding, whatever its fit says.
#pragma once

#include "diagnosis/evidence/torque_grade.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// - A wrong torque constant is a wrong scale of the effort's log, a constant torque its bias: told only where the log
//   follows the servo's law.
// - A level of dry friction may be larger at rest by what the curve's likelihood allows.
// - A constant torque is the mean of dry friction that holds more in one direction, moving and at rest.
// - A gear that loses r of the load while the load drives it is friction of mu = r / (2 - r) of the load both ways beside a
//   torque constant 1 + mu times the stated one: both need the load to lift it, and 1 - r of it to lower it.
// `excess`: that of a Stribeck curve, or null; `level`: of the joint's dry friction, or null.
std::vector<Alternative> list_indistinguishable(const TorqueData& data, const GradedTerm& term, const GradedTerm* excess,
                                                const GradedTerm* level);

// The gear beside which nothing is wrong with the mass (torque_gears.h); `friction`: the load-dependent friction of the joint that alone
// carries the link of `mass`.
Alternative make_gear_alternative(const TorqueData& data, const GradedTerm& mass, const GradedTerm& friction);

// Value and 95 % range as the report writes them.
Estimate make_ranged(const char* name, const std::string& unit, const Range& range, double deviation);

// Findings of a log against the servo's law: its scale, its bias.
std::vector<Finding> make_log_findings(const Experiment& experiment, int joint, const ServoReading& log);
// Findings of a joint's position or velocity against each other: a scale, a delay.
std::vector<Finding> make_velocity_findings(const Experiment& experiment, int joint, const std::vector<VelocityReading>& logs);

}  // namespace hrp::diagnosis
