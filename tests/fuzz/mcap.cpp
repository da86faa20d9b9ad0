// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/reader.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const hrp::test::MemoryFile file(data, size);
  try {
    hrp::mcap::Reader reader(file.path());
    reader.read_messages([](const hrp::mcap::Message&) { return true; });
  } catch (const hrp::mcap::McapError&) {
  }
  return 0;
}
