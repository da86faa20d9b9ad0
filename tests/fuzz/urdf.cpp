// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/diagnostics.h"
#include "common/robot/scenario.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const hrp::Scenario scenario =
      hrp::parse_scenario("robot: r.urdf\nbase: fixed\nservo: {default: {kp: 1}}\n", "s.yaml");
  try {
    hrp::parse_robot(hrp::test::make_text(data, size), "r.urdf", scenario);
  } catch (const hrp::InputError&) {
  }
  return 0;
}
