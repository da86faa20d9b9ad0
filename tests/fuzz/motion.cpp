// SPDX-License-Identifier: BSD-3-Clause
// Motions: Choreonoid's .seq when the first byte is even, our .csv when it is odd.
#include "controller/motion/motion.h"
#include "common/base/diagnostics.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  const std::string text = hrp::test::make_text(data + 1, size - 1);
  try {
    if (data[0] % 2 == 0) {
      hrp::parse_seq_motion(text, "m.seq", {"a", "b"});
    } else {
      hrp::parse_csv_motion(text, "m.csv");
    }
  } catch (const hrp::InputError&) {
  }
  return 0;
}
