// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/joint_conventions.h"

#include <algorithm>
#include <utility>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/exchanged_joints.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/conventions/mounting.h"
#include "diagnosis/conventions/unit_doubts.h"
#include "diagnosis/conventions/zero_search.h"
#include "diagnosis/estimate/odds.h"

namespace hrp::diagnosis {
namespace {

// The effort whose sign is turned; null if none is.
const EffortUnit* find_turned(const std::vector<EffortUnit>& units) {
  const auto at = std::find_if(units.begin(), units.end(), [](const EffortUnit& u) { return u.scale < 0.0; });
  return at == units.end() ? nullptr : &*at;
}

// A zero that is off by half a turn turns the sign of the weight's torque, but not that of the bodies' inertia: an
// effort then looks like one with its sign turned, or in another unit. If zeros alone explain efforts as they are
// logged clearly better, nothing else is off. Drives that count the torque on the motor, not on the link, turn the
// signs of all efforts: that is one convention, while each zero is a value of its own.
void prefer_zeros_alone(const Experiment& e, int jobs, LogConventions* out) {
  const Experiment in_time = convert_motion(e, *out);
  const std::vector<RefutedFriction> friction = find_refuted_friction(in_time);
  const Experiment as_logged = drop_friction(in_time, friction);
  const std::vector<JointZero> zeros = find_zeros(as_logged, jobs);
  if (zeros.empty()) return;
  const ListFit by_zeros = fit_list(convert_zeros(as_logged, zeros), jobs);
  if (compare(by_zeros, fit_list(convert_recordings(e, *out), jobs)) < kWholeGain) return;
  if (find_turned(out->units)) {
    const Experiment turned = turn_efforts(in_time, list_efforts(in_time));
    const double zeros_cost = kOneValue * static_cast<double>(zeros.size());
    if (compare(by_zeros, fit_list(drop_friction(turned, find_refuted_friction(turned)), jobs)) <
        kWholeGain + zeros_cost)
      return;
  }
  const Experiment in_zeros = convert_zeros(in_time, zeros);  // outlives its data
  const TorqueData at_zeros = make_torque_data(in_zeros);
  if (!find_effort_units(at_zeros).empty()) return;
  out->units.clear();
  out->untold = list_untold_units(at_zeros, {});
  out->friction = friction;
  out->zeros = zeros;
}

// Robots on a fixed base. Nothing more than a turned sign of an effort where there is one: it hides all else.
LogConventions find_of_joints(const Experiment& e, int jobs) {
  LogConventions out;
  TorqueData data = make_torque_data(e);
  out.absent = find_absent_torque(data);
  const Experiment whole = return_torque(e, out.absent.part);
  if (out.absent.part != Absent::kNothing) data = make_torque_data(whole);
  const LoggedMotion motion = sample_motion(data);
  check_exchanged_joints(data, motion, jobs);
  // With the torque returned, angles and gravity as logged explain all but a detail: no other ratios, zeros or
  // mounting.
  if (out.absent.part == Absent::kNothing) out.angles = find_absolute_angles(data, motion, jobs);
  const Experiment of_joints = convert_angles(whole, out.angles);
  if (out.absent.part == Absent::kNothing) out.ratios = find_gear_ratios(of_joints, jobs);
  const Experiment of_links = convert_ratios(of_joints, out.ratios);
  out.commands = find_late_commands(of_links, jobs);
  const Experiment in_time = convert_commands(of_links, out.commands);
  const TorqueData as_logged = make_torque_data(in_time);
  out.units = find_effort_units(as_logged);
  if (find_turned(out.units)) prefer_zeros_alone(e, jobs, &out);
  if (find_turned(out.units)) return out;
  out.untold = list_untold_units(as_logged, out.units);
  Experiment in_torques = convert_efforts(in_time, out.units);
  out.friction = find_refuted_friction(in_torques);
  in_torques = drop_friction(std::move(in_torques), out.friction);
  if (out.absent.part != Absent::kNothing) return out;
  out.zeros = find_zeros(in_torques, jobs);
  if (!out.units.empty()) prefer_zeros_alone(e, jobs, &out);
  if (out.zeros.empty()) check_mounting(in_torques, jobs);
  return out;
}

}  // namespace

LogConventions find_joint_conventions(const Experiment& e, int jobs) {
  std::vector<TurnedEffort> signs;
  for (int pass = 0;; ++pass) {
    const Experiment in_signs = turn_efforts(e, signs);
    LogConventions out = find_of_joints(in_signs, jobs);
    const EffortUnit* turned = find_turned(out.units);
    out.signs = signs;
    if (!turned) return out;
    if (pass > e.num_joints()) {
      refuse_input(e.recordings.front().find_place(e.signal_name(turned->joint, Quantity::kEffort)),
                   "fits the torque of the motion with neither sign: is an axis of the model turned?");
    }
    add_turned_effort(convert_motion(in_signs, out), turned->joint, jobs, &signs);
  }
}

Experiment convert_motion(const Experiment& e, const LogConventions& c) {
  const Experiment whole = return_torque(turn_efforts(e, c.signs), c.absent.part);
  return convert_commands(convert_ratios(convert_angles(whole, c.angles), c.ratios), c.commands);
}

}  // namespace hrp::diagnosis
