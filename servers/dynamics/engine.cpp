// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/engine.h"

namespace hrp {

SimulatorEngine::SimulatorEngine(const RobotDescription& robot, const Scenario& scenario)
    : simulator_(vary_robot(robot, scenario), vary_scenario(robot, scenario)),
      pushes_(robot, vary_scenario(robot, scenario)) {}

std::string SimulatorEngine::step(const ContactSet& contacts, const JointCommand& command) {
  const StepStatus status = simulator_.step(contacts, command, pushes_.find(simulator_.time(), simulator_.state()));
  if (status == StepStatus::kOk) return "";
  const std::string what = get_step_status_text(status);
  return simulator_.fault_text().empty() ? what : what + ": " + simulator_.fault_text();
}

std::unique_ptr<DynamicsEngine> make_simulator_engine(const RobotDescription& robot, const Scenario& scenario) {
  return std::make_unique<SimulatorEngine>(robot, scenario);
}

}  // namespace hrp
