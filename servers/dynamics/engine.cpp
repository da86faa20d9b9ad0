// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/engine.h"

namespace hrp {

std::string SimulatorEngine::step(const ContactSet& contacts, const JointCommand& command) {
  const StepStatus status = simulator_.step(contacts, command);
  if (status == StepStatus::kOk) return "";
  const std::string what = get_step_status_text(status);
  return simulator_.fault_text().empty() ? what : what + ": " + simulator_.fault_text();
}

std::unique_ptr<DynamicsEngine> make_simulator_engine(const RobotDescription& robot, const Scenario& scenario) {
  return std::make_unique<SimulatorEngine>(robot, scenario);
}

}  // namespace hrp
