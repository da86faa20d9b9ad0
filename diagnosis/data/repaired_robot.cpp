// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/repaired_robot.h"

#include "common/base/diagnostics.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::diagnosis {

RobotDescription load_repaired_robot(Scenario* scenario) {
  try {
    return load_robot(*scenario);
  } catch (const InputError&) {
    if (scenario->marks.count("repair_inertias")) throw;
    scenario->repair_inertias = true;
    RobotDescription robot = load_robot(*scenario);
    scenario->text += "\nrepair_inertias: true\n";
    return robot;
  }
}

}  // namespace hrp::diagnosis
