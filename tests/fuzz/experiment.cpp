// SPDX-License-Identifier: BSD-3-Clause
// Experiment files: what the recordings are, which topics of a bag or columns of a table hold them, and the scenario
// that they are, too.
#include "common/base/diagnostics.h"
#include "common/robot/column_map.h"
#include "common/robot/experiment_keys.h"
#include "common/robot/scenario.h"
#include "common/robot/topic_map.h"
#include "tests/fuzz/fuzz.h"

namespace {

template <typename Parse>
void try_reader(Parse parse, const std::string& text) {
  try {
    parse(text, "experiment.yaml");
  } catch (const hrp::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text = hrp::test::make_text(data, size);
  try_reader(hrp::parse_experiment_keys, text);
  try_reader(hrp::parse_topic_map, text);
  try_reader(hrp::parse_column_maps, text);
  try_reader(hrp::parse_scenario, text);
  return 0;
}
