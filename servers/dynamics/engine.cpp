// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/engine.h"

#include <cstdio>

#include "servers/dynamics/disturbance.h"

namespace hrp {
namespace {

constexpr double kHugeEffort = 1e5;  // [N m or N] no drive of a robot
constexpr double kFastJoint = 1e3;   // [rad/s or m/s] no joint of a robot

// Without "step 12: ": the caller says where.
std::string remove_step(const std::string& text) {
  const size_t colon = text.find(": ");
  return text.rfind("step ", 0) == 0 && colon != std::string::npos ? text.substr(colon + 2) : text;
}

std::string find_likely_reason(const Scenario& scenario, const State& state, const JointCommand& command) {
  if (command.effort.size() > 0 && command.effort.cwiseAbs().maxCoeff() > kHugeEffort) {
    char text[80];
    std::snprintf(text, sizeof text, "the controller's efforts, up to %g N m", command.effort.cwiseAbs().maxCoeff());
    return text;
  }
  for (const PushSpec& push : scenario.pushes) {
    if (push.force_W.norm() > kHugeEffort) return "the push '" + push.name + "'";
  }
  if (scenario.integrator != "implicit") {
    return "'integrator: " + scenario.integrator +
           "' cannot carry servos and contacts as stiff as these with this time step; "
           "use 'integrator: implicit' or a shorter steps.time_step";
  }
  const bool fast = state.qd.size() > 0 && state.qd.cwiseAbs().maxCoeff() > kFastJoint;
  return std::string(fast ? "joints had been thrown into motion before: " : "") +
         "gains (servo, joint_laws) or contact.stiffness too high, or a mass or inertia too small, for this time step";
}

}  // namespace

// Once, with what a person needs to mend it.
std::string SimulatorEngine::describe_blow_up(const JointCommand& command) const {
  char time[40];
  std::snprintf(time, sizeof time, "t = %.4f s", simulator_.time());
  std::string fastest;
  if (simulator_.state().qd.size() > 0) {
    Eigen::Index joint = 0;
    simulator_.state().qd.cwiseAbs().maxCoeff(&joint);
    fastest = ", fastest before: joint '" + simulator_.tree().joint(static_cast<int>(joint)).name + "'";
  }
  return std::string("the state blows up at ") + time + ": " + remove_step(simulator_.fault_text()) + fastest +
         "; likely reason: " + find_likely_reason(scenario_, simulator_.state(), command);
}

SimulatorEngine::SimulatorEngine(const RobotDescription& robot, const Scenario& scenario)
    : scenario_(scenario),
      simulator_(vary_robot(robot, scenario), vary_scenario(robot, scenario)),
      others_(robot, scenario),
      pushes_(robot, scenario, simulator_.state()) {}

std::string SimulatorEngine::step(const ContactSet& contacts, const JointCommand& command) {
  const ExternalWrenches& pushes = pushes_.find(simulator_.time(), simulator_.state());
  acting_ = pushes_.acting();
  if (others_.empty()) return describe(simulator_.step(contacts, command, pushes), command);
  std::string fault;
  const ExternalWrenches& all = others_.start(contacts, simulator_.state(), pushes, &fault);
  if (fault.empty()) fault = describe(simulator_.step(others_.robot_contacts(), command, all), command);
  if (fault.empty()) fault = others_.finish(simulator_.contact_forces());
  others_.append_pushes(&acting_);
  return fault;
}

std::string SimulatorEngine::describe(StepStatus status, const JointCommand& command) const {
  if (status == StepStatus::kOk) return "";
  if (status == StepStatus::kNonFiniteState) return describe_blow_up(command);
  const std::string what = get_step_status_text(status);
  return simulator_.fault_text().empty() ? what : what + ": " + simulator_.fault_text();
}

std::unique_ptr<DynamicsEngine> make_simulator_engine(const RobotDescription& robot, const Scenario& scenario) {
  return std::make_unique<SimulatorEngine>(robot, scenario);
}

}  // namespace hrp
