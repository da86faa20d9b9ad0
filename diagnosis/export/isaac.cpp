// SPDX-License-Identifier: BSD-3-Clause
// A table for Isaac Lab's actuator models (isaaclab.actuators): one entry a joint with the fields of ActuatorBaseCfg
// and DelayedPDActuatorCfg under their names.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/effects/units.h"
#include "diagnosis/export/take_home.h"
#include "diagnosis/export/unheld.h"

namespace hrp::diagnosis {
namespace {

constexpr Holds kIsaacHolds{true, true, false, true, true};

void write_joint(const JointSpec& joint, const JointLaws& laws, std::ostringstream* out) {
  const double k = laws.torque_scale, limit = find_torque_limit(joint, laws);
  *out << "  " << joint.name
       << ":\n    class: " << (laws.command_delay > 0.0 ? "DelayedPDActuatorCfg" : "ImplicitActuatorCfg")
       << "\n    stiffness: " << print_value(k * laws.kp) << "           # " << get_joint_unit(joint, "N m/rad")
       << ", times the true gain\n    damping: " << print_value(k * laws.kd) << "\n";
  if (std::isfinite(limit)) *out << "    effort_limit: " << print_value(limit) << "\n";
  *out << "    armature: " << print_value(laws.motor_inertia) << "            # " << get_joint_unit(joint, "kg m^2")
       << "\n    friction: " << print_value(std::max(laws.static_level, laws.coulomb)) << "            # "
       << get_joint_unit(joint, "N m") << ", at rest\n    dynamic_friction: " << print_value(laws.coulomb) << "    # "
       << get_joint_unit(joint, "N m") << ", in motion\n    viscous_friction: " << print_value(laws.viscous) << "    # "
       << get_joint_unit(joint, "N m s/rad") << "\n";
  if (laws.command_delay > 0.0)
    *out << "    delay: " << print_value(laws.command_delay)
         << "               # s: max_delay = delay / physics step\n";
  for (const std::string& text : list_unheld(joint, laws, kIsaacHolds)) *out << "    # not held: " << text << "\n";
}

}  // namespace

std::string make_isaac_table(const TakeHome& model) {
  std::ostringstream out;
  out << "# Actuators for Isaac Lab, by joint: fields of isaaclab.actuators under their names.\n# Friction as torques "
         "needs "
         "Isaac Lab 2.2 or later; before, `friction` is a coefficient and cannot hold it.\n";
  for (const std::string& force : model.forces) out << "# not held: " << force << "\n";
  for (const auto& [link, effects] : model.scenario.link_laws) {
    for (const StatedEffect& e : effects)
      out << "# not held here (see robot.xml): " << link << ", " << e.effect << "\n";
  }
  out << "actuators:\n";
  for (int j = 0; j < model.robot.tree.num_joints(); ++j) {
    if (model.robot.tree.joint(j).actuated)
      write_joint(model.robot.tree.joint(j), model.laws[static_cast<size_t>(j)], &out);
  }
  return out.str();
}

}  // namespace hrp::diagnosis
