// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/scenario.h"
#include "common/base/diagnostics.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    hrp::parse_scenario(hrp::test::make_text(data, size), "s.yaml");
  } catch (const hrp::InputError&) {
  }
  return 0;
}
