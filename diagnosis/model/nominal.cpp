// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/nominal.h"

#include "common/effects/link_law.h"
#include "diagnosis/data/servo_gains.h"
#include "servers/dynamics/joint_effects.h"

namespace hrp::diagnosis {
namespace {

JointLaws make_laws(const Experiment& e, const JointSpec& joint) {
  const Scenario& scenario = e.scenario;
  JointLaws laws;
  const ServoGains& gains = get_servo_gains(scenario, joint.name);
  if (joint.actuated && !is_effort_driven(e)) {
    laws.kp = gains.kp;
    laws.kd = gains.kd;
    laws.effort_limit = gains.effort_limit;
  }
  laws.viscous = joint.viscous_friction;
  laws.coulomb = joint.coulomb_friction;
  const auto stated = scenario.joint_laws.find(joint.name);
  if (stated == scenario.joint_laws.end()) return laws;
  for (const StatedEffect& effect : stated->second) apply_stated_joint_effect(joint.name, effect, &laws);
  return laws;
}

}  // namespace

bool is_effort_driven(const Experiment& e) { return e.scenario.drive == "effort"; }

NominalRobot make_nominal(const Experiment& e) {
  NominalRobot robot;
  robot.tree = e.robot.tree;
  for (const SteadyForce& force : apply_link_laws(e.scenario, &robot.tree)) {
    robot.force_W.resize(robot.tree.links.size(), Vector3d::Zero());
    robot.force_W[static_cast<size_t>(force.link)] += force.force_W;
  }
  for (int j = 0; j < robot.tree.num_joints(); ++j) {
    JointSpec& joint = robot.tree.joint(j);
    const auto rotor = e.scenario.rotor_inertia.find(joint.name);
    if (rotor != e.scenario.rotor_inertia.end()) joint.rotor_inertia = rotor->second;
    robot.laws.push_back(make_laws(e, joint));
  }
  return robot;
}

void add_loads(const RecordingSpec& recording, TreeSpec* tree) {
  for (const LoadSpec& load : recording.loads) {
    const int link = tree->find_link(load.link);
    if (link > 0) add_payload(load.mass, load.p_LC, 0.0, &tree->links[static_cast<size_t>(link)].inertia);
  }
}

std::vector<SteadyForce> list_pulls(const RecordingSpec& recording, const TreeSpec& tree) {
  std::vector<SteadyForce> pulls;
  for (const HandPush& push : recording.pushes) {
    const int link = tree.find_link(push.link);
    if (push.known && link > 0) pulls.push_back({link, push.p_LQ, push.force_W});
  }
  return pulls;
}

}  // namespace hrp::diagnosis
