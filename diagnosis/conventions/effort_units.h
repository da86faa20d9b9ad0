// SPDX-License-Identifier: BSD-3-Clause
// Finds logged efforts that are no torques: drives often log their current [A], or a share of their limit.
//
// Along the recorded motion, effort = tau / k + friction + rotor, with tau the nominal inverse dynamics and k [N m per
// logged unit]. Errors bias a regression of effort on tau towards zero, and one of tau on effort as well. The two
// slopes therefore bracket 1 / k (Frisch's bounds). Links are not too heavy by more than a factor of e. If every joint
// with a clear result asks for so much less effort, the unit is the cause. A load may ask for ten times the effort, but
// not for the same factor at two joints.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// The unit of a joint's effort, or of its gains.
struct EffortUnit {
  int joint = 0;
  double scale = 1.0;            // torque [N m or N] per logged unit
  double low = 1.0, high = 1.0;  // bounds of the scale
  bool by_others = false;        // undetermined at this joint; value of its neighbours
  bool of_gains = false;         // no effort was logged; the stated servo gains are in another unit
  bool at_least = false;         // weight does not tell it from a rotor, which would make it larger
  // Relative deviation of a load's mass that was found beside the units (loaded_units.h); infinite: no load shows
  // beside them. Zero: the unit needs no motion (the servo's law tells it).
  double of_load = std::numeric_limits<double>::infinity();
  double by_load = 0.0;           // the same of the torque of the joint that bears the load most; zero: none
  double without_friction = 1.0;  // the scale by find_unit_without_friction(); 1: none
  double without_constant = 1.0;  // the scale by find_unit_without_constant(); 1: none
};

// True if a load shows beside the units, its mass does not, and it is a large part of some joint's torque: another
// load, maybe of another link, with other units does as well.
bool is_load_or_unit(const EffortUnit& unit);

// One entry for each joint whose efforts (or, without efforts, stated gains) are in another unit. Empty if they are
// torques or the motion does not determine it. The efforts of a servo are compared with its law instead (servo_law.h).
// If an effort has the wrong sign: that joint alone, with a scale below zero.
std::vector<EffortUnit> find_effort_units(const TorqueData& data);

// True if the joint's recorded effort shows whether it is a torque: by the servo's law, or by the torque that weight
// and inertia of the model take. Without weight, as on a slide: if it is what the bodies take without any rotor.
bool tells_unit(const TorqueData& data, int joint);

// The unit that the joint's efforts have if its drive has no rotor. Empty if friction explains them as well.
std::optional<EffortUnit> find_unit_without_rotor(const TorqueData& data, int joint);

// The unit [N m per logged unit] in which the efforts need neither dry friction nor a constant; below zero if the log's
// sign is turned. Empty if these explain the torque better in any unit, or if it is within a factor of e of one. A
// drive at one voltage, as in a step of a motor: its effort is constant, and so is friction.
std::optional<double> find_unit_without_friction(const TorqueData& data, int joint);

// The unit in which the efforts need no constant, beside friction and rotor. Empty if a constant explains them better,
// or as above. Weight that hardly changes along the motion, as on a slide: a unit takes from it what a constant adds.
std::optional<double> find_unit_without_constant(const TorqueData& data, int joint);

// The experiment with efforts in N m and gains in N m/rad.
Experiment convert_efforts(Experiment experiment, const std::vector<EffortUnit>& units);

}  // namespace hrp::diagnosis
