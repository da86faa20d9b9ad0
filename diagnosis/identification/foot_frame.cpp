// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/foot_frame.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/robot/sole.h"

namespace hrp::identification {

Scenario without_bush(Scenario scenario) {
  scenario.foot_bush.clear();
  scenario.joint_laws.clear();
  return scenario;
}

std::vector<FootFrame> make_feet(const Scenario& scenario, const RobotDescription& robot) {
  std::vector<FootFrame> feet;
  const std::vector<Sole> soles = make_soles(robot);
  for (const std::string& name : scenario.feet) {
    FootFrame foot;
    foot.link = robot.tree.find_link(name);
    if (foot.link < 0) throw InputError(scenario.make_diagnostic("feet", "the robot has no link '" + name + "'"));
    const auto sole = std::find_if(soles.begin(), soles.end(), [&](const Sole& s) { return s.link == foot.link; });
    if (sole != soles.end()) foot.p_UC = sole->p_LR;
    const LinkInertia& inertia = robot.tree.links[static_cast<size_t>(foot.link)].inertia;
    foot.mass = inertia.mass;
    foot.p_Ucm = inertia.p_LLcm_L;
    foot.upper_mass = FootBushSpec{}.upper_mass_ratio * inertia.mass;
    const auto bush = scenario.foot_bush.find(name);
    if (bush != scenario.foot_bush.end()) {
      if (bush->second.center) foot.p_UC = *bush->second.center;
      foot.upper_mass = bush->second.upper_mass_ratio * inertia.mass;
    }
    if (sole != soles.end()) {
      for (const SolePoint& p : sole->points) foot.sole.extend(Eigen::Vector2d((p.p_LQ - foot.p_UC).head<2>()));
    }
    feet.push_back(foot);
  }
  return feet;
}

BushAngles calc_angles(const Vector3d& n_U) {
  return {std::atan2(-n_U.y(), n_U.z()), std::asin(std::clamp(n_U.x(), -1.0, 1.0))};
}

Matrix3d make_R_SU(const BushAngles& a) {
  return (Eigen::AngleAxisd(-a.pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(-a.roll, Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace hrp::identification
