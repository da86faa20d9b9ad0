// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/disturbance.h"

#include <random>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"

namespace hrp {
namespace {

// Uniform in (-1, 1): made from the bits of the generator, because distributions of the standard library differ.
double draw(std::mt19937_64* generator) {
  return 2.0 * ((static_cast<double>((*generator)() >> 11) + 0.5) * 0x1.0p-53) - 1.0;
}

int find_link(const TreeSpec& tree, const PushSpec& push, Transform* X_LF) {
  const int frame = tree.find_frame(push.link);
  if (frame >= 0) {
    *X_LF = tree.frames[static_cast<size_t>(frame)].X_LF;
    return tree.frames[static_cast<size_t>(frame)].link;
  }
  const int link = tree.find_link(push.link);
  if (link >= 0) return link;
  Diagnostic diagnostic;
  diagnostic.field = "pushes." + push.name + ".link";
  diagnostic.message = "the robot has no link '" + push.link + "'";
  throw InputError(diagnostic);
}

}  // namespace

RobotDescription vary_robot(const RobotDescription& robot, const Scenario& scenario) {
  RobotDescription varied = robot;
  if (scenario.variation.mass == 0.0) return varied;
  std::mt19937_64 generator(scenario.variation.seed);
  for (LinkSpec& link : varied.tree.links) {
    const double factor = 1.0 + scenario.variation.mass * draw(&generator);
    link.inertia.mass *= factor;
    link.inertia.I_LLcm_L *= factor;
  }
  return varied;
}

Scenario vary_scenario(const RobotDescription& robot, const Scenario& scenario) {
  Scenario varied = scenario;
  if (scenario.variation.pose == 0.0) return varied;
  std::mt19937_64 generator(scenario.variation.seed + 0x9E3779B97F4A7C15ull);
  for (int i = 0; i < robot.tree.num_joints(); ++i) {
    const auto found = varied.initial_joints.find(robot.tree.joint(i).name);
    if (found != varied.initial_joints.end()) found->second += scenario.variation.pose * draw(&generator);
  }
  return varied;
}

Pushes::Pushes(const TreeSpec& tree, const Scenario& scenario) : model_(tree), data_(model_) {
  for (const PushSpec& spec : scenario.pushes) {
    Transform X_LF;
    Push push{find_link(tree, spec, &X_LF), spec};
    push.spec.p_LQ = X_LF * spec.p_LQ;
    pushes_.push_back(push);
  }
  active_.reserve(pushes_.size());
}

const ExternalWrenches& Pushes::find(double time, const State& state) {
  active_.clear();
  bool posed = false;
  for (const Push& push : pushes_) {
    constexpr double kTick = 1e-9;  // [s] times are sums of steps
    if (time < push.spec.start - kTick || time >= push.spec.start + push.spec.duration - kTick) continue;
    if (!posed) update_kinematics(model_, state, &data_);
    posed = true;
    const Vector3d arm = get_pose(data_, push.link).R * push.spec.p_LQ;
    ExternalWrench wrench;
    wrench.link = push.link;
    wrench.F_W << arm.cross(push.spec.force_W), push.spec.force_W;
    active_.push_back(wrench);
  }
  return active_;
}

}  // namespace hrp
