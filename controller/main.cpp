// SPDX-License-Identifier: BSD-3-Clause
#include "controller/client.h"
#include "controller/play.h"

int main(int argc, char** argv) {
  return hrp::run_controller(argc, argv, "hrp-controller", hrp::make_scenario_controller);
}
