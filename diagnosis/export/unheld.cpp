// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/export/unheld.h"

#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "common/effects/units.h"

namespace hrp::diagnosis {

std::string make_comment(const std::string& text) {
  std::string out;
  for (char c : text) out += c == '-' && !out.empty() && out.back() == '-' ? ' ' : c;
  return "<!-- " + out + " -->\n";
}

std::string name_link(const TreeSpec& tree, int link) {
  const std::string& name = tree.links[static_cast<size_t>(link)].name;
  return name == "world" ? "world_link" : name;
}

double find_torque_limit(const JointSpec& joint, const JointLaws& laws) {
  constexpr double kUnit = 2.718;  // a larger factor, or a smaller one, is the unit of the log: URDFs are in N m
  const bool stated = laws.effort_limit < kUnlimited;
  const bool unit = !stated && std::abs(std::log(std::abs(laws.torque_scale))) > std::log(kUnit);
  const double logged = stated ? laws.effort_limit : joint.effort_limit;
  return std::min((unit ? 1.0 : laws.torque_scale) * logged, laws.saturation);
}

std::string print_value(double value) { return format("%.6g", value == 0.0 ? 0.0 : value); }

std::vector<std::string> list_unheld(const JointSpec& joint, const JointLaws& laws, const Holds& holds) {
  std::vector<std::string> list;
  const auto p = print_value;
  const auto in = [&](double value, const char* unit) { return p(value) + " " + get_joint_unit(joint, unit); };
  if (!holds.rotor && laws.motor_inertia > 0.0)
    list.push_back("reflected inertia of the rotor, " + in(laws.motor_inertia, "kg m^2"));
  if (!holds.gain && laws.torque_scale != 1.0)
    list.push_back("the true torque is " + p(laws.torque_scale) + " times the drive's effort");
  if (!holds.spring && laws.spring_stiffness != 0.0)
    list.push_back("a spring of " + in(laws.spring_stiffness, "N m/rad") + ", at rest at " +
                   in(laws.spring_rest, "rad"));
  if (!holds.delay && laws.command_delay > 0.0) list.push_back("commands arrive " + p(laws.command_delay) + " s late");
  if (laws.lag > 0.0) list.push_back("the drive lags, time constant " + p(laws.lag) + " s");
  if (!holds.static_friction && laws.static_level > laws.coulomb)
    list.push_back("dry friction is " + in(laws.static_level, "N m") + " at rest and falls to " + p(laws.coulomb) +
                   " N m above " + in(laws.stribeck_velocity, "rad/s"));
  if (laws.asymmetry != 0.0)
    list.push_back("dry friction is (1 +- " + p(laws.asymmetry) + ") times its level forward and backward");
  if (laws.bends && laws.has_friction())
    list.push_back("dry friction bends by about " + in(laws.presliding, "rad") + " before it slips");
  if (laws.load_ratio > 0.0)
    list.push_back("dry friction grows by " + p(laws.load_ratio) + " times the drive's effort");
  if (laws.backdriven > 0.0)
    list.push_back("the gear takes " + p(laws.backdriven) + " of the load's torque while the load drives it");
  if (laws.cogging_amplitude != 0.0)
    list.push_back("ripple of " + in(laws.cogging_amplitude, "N m") + " sin(" + p(laws.cogging_periods) + " q + " +
                   p(laws.cogging_phase) + ")");
  if (laws.elastic)
    list.push_back("an elastic transmission, " + in(laws.stiffness, "N m/rad") + " and " +
                   in(laws.damping, "N m s/rad"));
  if (laws.gap > 0.0) list.push_back("backlash of " + in(laws.gap, "rad"));
  if (laws.hysteresis_stiffness > 0.0)
    list.push_back("hysteresis of " + in(laws.hysteresis_stiffness, "N m/rad") + ", yielding at " +
                   in(laws.hysteresis_yield, "rad"));
  if (laws.joint_offset != 0.0) list.push_back("the encoder reads " + in(laws.joint_offset, "rad") + " too much");
  if (!laws.terms.empty()) list.push_back("a further law of the drive, see ../scenario.yaml");
  return list;
}

}  // namespace hrp::diagnosis
